// SPDX-License-Identifier: MIT
// labels: device threads
// A skin's state as bytes: the same on every backend, and what a skin goes on from.
#include "tests/support.hpp"

#include <cstring>
#include <fstream>

using namespace test;

namespace {

// Skins of one element and of several, of one material and of many, of fields and of few sites and many.
std::vector<SkinDescription> descriptions() {
    std::vector<SkinDescription> all;
    for (int sites : {0, 9, 300}) // of many all cells are stepped
        for (bool chain : {false, true})
            for (bool maps : {false, true}) {
                SkinDescription d = ridged(19, 11);
                d.receptors.fa2 = Fa2::step_mean;
                if (maps) d = with_materials(d);
                if (chain) d = with_chain(d), d.material.dashpot.reset();
                all.push_back(with_sites(d, sites));
            }
    all.push_back(with_sites(ridged(101, 11), 2000)); // whose rows are shared among threads
    return all;
}

} // namespace

TEST_CASE("a state goes on with another modulus and viscosity: its strain is kept") {
    SkinDescription d = small_scene(9, 7);
    d.receptors.fa2 = Fa2::step_mean;
    Skin soft(Device::cpu(), d);
    soft.press(frame(d, 1), 0.2);
    const Bytes state = saved(soft);
    d.material.modulus = 1e6;
    Skin stiff(Device::cpu(), d);
    stiff.load(state.data(), state.size());
    soft.press(frame(d, 1), 0);
    stiff.press(frame(d, 1), 0);
    for (int i = 0; i < 63; ++i)
        CHECK(stiff.response(Quantity::sa1)[size_t(i)] == soft.response(Quantity::sa1)[size_t(i)]);
}

TEST_CASE(
    "a state of another description or version, or of other bytes, is refused by name, and nothing has happened") {
    SkinDescription d = small_scene(9, 7);
    d.receptors.fa2 = Fa2::step_mean;
    Skin skin(Device::cpu(), d);
    for (int i : {0, 1}) skin.press(frame(d, i), 0.01 * (1 + i));
    const Bytes own = saved(skin);
    const auto refused = [&](const Bytes& state) {
        const std::string message = refusal(Error::Code::bad_input, [&] { skin.load(state.data(), state.size()); });
        CHECK(saved(skin) == own);
        return message;
    };
    const auto says = [&](auto change, const SkinOptions& options, const char* what) {
        SkinDescription other = d;
        change(other);
        CHECK(refused(saved(Skin(Device::cpu(), other, options))).find(what) != std::string::npos);
    };
    says([](SkinDescription& o) { o.grid.width = 10; }, {}, "width 10");
    says([](SkinDescription& o) { o.grid.height = 8; }, {}, "height 8");
    says([](SkinDescription& o) { o.sites = {{Quantity::sa2, {1, 1}}}; }, {}, "sites of hash");
    says(
        [](SkinDescription& o) {
            o.material.modulus = o.material.viscosity = {}, o.material.elements = {{1, 2}, {3, 4}};
        },
        {}, "number of elements 2");
    SkinOptions plain, without;
    plain.precision = Precision::f32;
    without.responses = {Quantity::sa1};
    without.precision = Precision::f32_compensated;
    says([](SkinDescription&) {}, plain, "compensated sums 0");
    says([](SkinDescription&) {}, without, "integral for sa2 0");
    Bytes bad = own;
    bad[8] = 7;
    CHECK(refused(bad).find("version 7") != std::string::npos);
    bad = own;
    bad[0] = 'x';
    CHECK(refused(bad).find("Skin::save") != std::string::npos);
    bad = own;
    bad.pop_back();
    CHECK(refused(bad).find(std::to_string(own.size()) + " bytes") != std::string::npos);
    bad = own;
    const float nan = NAN;
    std::memcpy(bad.data() + bad.size() - 4, &nan, 4);
    CHECK(refused(bad).find("not finite") != std::string::npos);
    refuses([&] { skin.load(nullptr, own.size()); }, "(null)");
    Bytes small(own.size() - 1);
    refuses([&] { skin.save(small.data(), small.size()); }, "bytes");
}

TEST_CASE(
    "a state has parts, each with its name and length: unknown, missing, repeated and cut ones are refused by name") {
    const SkinDescription d = small_scene(9, 7);
    Skin skin(Device::cpu(), d);
    for (int i : {0, 1}) skin.press(frame(d, i), 0.01 * (1 + i));
    const Bytes own = saved(skin);
    const auto refused = [&](const Bytes& state) {
        const std::string message = refusal(Error::Code::bad_input, [&] { skin.load(state.data(), state.size()); });
        CHECK(saved(skin) == own);
        return message;
    };
    const auto with = [&](size_t at, std::initializer_list<unsigned char> bytes) {
        Bytes state = own;
        std::copy(bytes.begin(), bytes.end(), state.begin() + std::ptrdiff_t(at));
        return state;
    };
    const size_t strains = 16 + 16 + 36; // behind the header and the part "shape"
    REQUIRE(std::memcmp(&own[strains], "strains", 8) == 0);
    const char* const parts = "the parts shape, strains and pressure, each once";
    CHECK(refused(with(strains, {'n', 'e', 'u', 'r', 'o', 'n', 's', 0})) ==
          std::string("state = (part \"neurons\"); allowed: ") + parts);
    CHECK(refused(with(strains, {'s', 'h', 'a', 'p', 'e', 0, 0, 0})) ==
          std::string("state = (part \"shape\"); allowed: ") + parts);
    CHECK(refused(with(strains + 8, {8})).find("part \"strains\" of ") != std::string::npos);
    CHECK(refused(with(strains + 15, {0x80})).find(" bytes") != std::string::npos); // longer than memory
    const Bytes no_pressure(own.begin(), own.end() - 16 - 9 * 7 * 4);
    CHECK(refused(no_pressure).find(std::to_string(no_pressure.size()) + " bytes") != std::string::npos);
    Bytes longer = own;
    longer.resize(own.size() + 3);
    CHECK(refused(longer).find(std::to_string(longer.size()) + " bytes") != std::string::npos);
}

TEST_CASE("states of version 2, as the library before 0.2.0 wrote them, are read and go on with the same bits") {
    const Bytes file = [] {
        std::ifstream in(std::string(DERMIS_TEST_DATA) + "/state_version_2.bin", std::ios::binary);
        return Bytes(std::istreambuf_iterator<char>(in), {});
    }();
    REQUIRE(file.size() == 692 + 772);
    SkinDescription d;
    d.grid = {5, 4, {}};
    d.surface.kind = Surface::Kind::flat;
    d.receptors.fa2 = Fa2::step_mean;
    d.material.elements = {{3, 0.05}, {2, 0.9}};
    d.material.spring = 5;
    const Validated vulkan;
    for (const Device& device : {Device::cpu(1), vulkan.device()})
        for (int pads : {1, 2}) {
            CAPTURE(device.info().name);
            SkinOptions options{.precision = Precision::f32_compensated, .count = pads};
            if (pads == 2) d.sites = {{Quantity::sa1, {1, 1}}, {Quantity::sa2, {3, 2}}, {Quantity::fa2, {1, 1}}};
            else d.sites.clear();
            Skin went_on(device, d, options), took(device, d, options);
            const auto press = [&](Skin& skin, int n) {
                std::vector<float> pressure(size_t(pads) * 20);
                for (size_t i = 0; i < pressure.size(); ++i) pressure[i] = float(int(i * 7 + size_t(n) * 11) % 23) / 8;
                skin.press(pressure, 0.01 * (1 + n));
            };
            for (int n = 0; n < 3; ++n) press(went_on, n);
            const size_t first = pads == 1 ? 0 : 692, bytes = pads == 1 ? 692 : 772;
            took.load(file.data() + first, bytes);
            CHECK(saved(took) == saved(went_on));
            press(went_on, 3);
            press(took, 3);
            for (Quantity q : {Quantity::sa1, Quantity::sa2, Quantity::fa2}) {
                const Skin::Response a = took.response(q), b = went_on.response(q);
                CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end()));
            }
            Bytes cut(file.begin() + std::ptrdiff_t(first), file.begin() + std::ptrdiff_t(first + bytes - 4));
            refuses([&] { took.load(cut.data(), cut.size()); }, std::to_string(bytes) + " bytes");
        }
}

TEST_CASE("a state of another stencil, spring or response is refused word for word") {
    SkinDescription d = small_scene(9, 7);
    d.receptors.fa2 = Fa2::step_mean;
    d.material.modulus = d.material.viscosity = {};
    d.material.elements = {{3, 0.5}};
    d.material.spring = 5;
    const auto why = [&](const SkinDescription& other, const SkinOptions& options = {}) {
        const Bytes state = saved(Skin(Device::cpu(1), other, options));
        return refusal(Error::Code::bad_input, [&] { Skin(Device::cpu(1), d).load(state.data(), state.size()); });
    };
    SkinDescription other = d;
    other.material.spring.reset();
    CHECK(why(other) == "state = (number of springs 0); allowed: number of springs 1, as the skin has");
    SkinOptions without{.responses = {Quantity::sa1, Quantity::sa2, Quantity::fa1}};
    CHECK(why(d, without) ==
          "state = (rate of a spring for fa2 0); allowed: rate of a spring for fa2 1, as the skin has");
    d.sites = {{Quantity::sa1, {4, 3}}}; // reads 5 cells, or 9 of the wider stencil
    other = d;
    other.stencil = Stencil::fourth_order;
    CHECK(why(other) == "state = (number of cells 9); allowed: number of cells 5, as the skin has");
}

TEST_CASE("a skin drops none of its elements, however fast or slow: it does not know its load") {
    SkinDescription d;
    d.grid = {4, 3, {}};
    d.material.elements = {{1, 1e-9}, {1, 1}, {1, 1.000001}, {1, 1e9}};
    d.material.dashpot = 1e12;
    SkinOptions options{.precision = Precision::f32};
    const size_t header = Skin(Device::cpu(), d, options).state_bytes() - size_t(4 * 3 * 4 * (5 + 1 + 1));
    CHECK(header == 100); // five strains, an integral and a pressure in each cell
}

TEST_CASE("a skin's report says which responses the curvature has turned") {
    SkinDescription d;
    d.grid = {40, 30, {}};
    d.surface.kind = Surface::Kind::wave;
    d.surface.noise = 0;
    for (double ridges : {0.5, 12.0}) {
        d.surface.ridges = ridges;
        SkinOptions options{.responses = {Quantity::sa1, Quantity::fa2}};
        Skin skin(Device::cpu(), d, options);
        CHECK(skin.report().sign_changed.empty()); // nothing is pressed
        skin.press(std::vector<float>(1200, 1.0f), 0.5);
        const Report r = skin.report();
        bool turned = false;
        for (float x : skin.response(Quantity::sa1)) turned |= x < 0;
        CHECK(turned == (std::count(r.sign_changed.begin(), r.sign_changed.end(), Quantity::sa1) == 1));
        CHECK(turned == r.gain.outside());
        CHECK(turned == (ridges > 1));
    }
}

TEST_CASE("a skin's report has the greatest strain of its state, a spring's share in it") {
    const Validated vulkan;
    SkinDescription d;
    d.grid = {8, 6, 1e-4};
    d.surface.relief = 1e-5;
    d.material.thickness = 1e-3;
    d.material.curvature_length = 1e-5;
    d.material.elements = {{2e4, 2e2}, {1e4, 3e3}};
    for (bool spring : {false, true}) {
        if (spring) d.material.spring = 4e4;
        for (const Device& device : {Device::cpu(1), vulkan.device()}) {
            Skin skin(device, d);
            CHECK(skin.report().strain.value == 0);
            std::vector<float> pressure(48, 500.0f);
            pressure[13] = 2000.0f;
            skin.press(pressure, 0.05);
            skin.press(pressure, 1e3); // long enough to end
            const double strain = 2000 * (1 / 2e4 + 1 / 1e4 + (spring ? 1 / 4e4 : 0));
            CHECK(std::abs(skin.report().strain.value - strain) <= 1e-6 * strain);
            CHECK(std::abs(skin.report().indentation.value - 1e-3 * strain) <= 1e-9 * strain);
            CHECK(!skin.report().strain.outside());
        }
    }
}

TEST_CASE("a skin tells strain, indentation and curvature: with them its responses are the formula, bit for bit") {
    const Validated vulkan;
    for (const Device& device : {Device::cpu(1), vulkan.device()})
        for (const SkinDescription& with : descriptions()) {
            SkinDescription d = with;
            d.material.spring = {}; // of which no state holds the strain
            d.grid.spacing = 0.5;
            d.surface.relief = 1;
            d.material.thickness = 0.25;
            d.material.curvature_length = 0.5;
            CAPTURE(device.info().name);
            CAPTURE(d.material.elements.size());
            CAPTURE(d.sites.size());
            SkinOptions options{.count = 2};
            Skin skin(device, d, options);
            for (float at_rest : answers(skin, Quantity::strain)) CHECK(at_rest == 0);
            std::vector<float> pressure = frame(d, 1), second = frame(d, 4);
            pressure.insert(pressure.end(), second.begin(), second.end());
            const float* const told = skin.response(Quantity::curvature).data;
            skin.press(pressure, 0.02);
            const std::vector<float> strain = answers(skin, Quantity::strain),
                                     indentation = answers(skin, Quantity::indentation),
                                     curvature = answers(skin, Quantity::curvature), sa1 = answers(skin, Quantity::sa1);
            CHECK(skin.response(Quantity::curvature).data == told); // the same memory
            const size_t sites = d.sites.size(), count = sites ? sites : 19 * 11;
            REQUIRE(strain.size() == 2 * count);
            f32::Constants c{};
            c.curvature_length = 0.5f;
            size_t of_class = 0;
            bool same = true, bent = false;
            for (size_t pad = 0; pad < 2; ++pad)
                for (size_t i = 0; i < count; ++i) {
                    const size_t at = pad * count + i;
                    CHECK(indentation[at] == 0.25f * strain[at]);
                    bent |= curvature[at] != 0;
                    if (sites && d.sites[i].type != Quantity::sa1) continue;
                    same &= sa1[sites ? of_class : at] == f32::response(strain[at], f32::gain_at(curvature[at], c));
                    ++of_class;
                }
            CHECK(same);
            CHECK(bent);
        }
}

TEST_CASE("the fields that a skin tells are those of a march") {
    SkinDescription d = descriptions()[3]; // elements in maps, and a spring
    Scene s;
    static_cast<SkinDescription&>(s) = d;
    s.load.envelope = {.kind = Envelope::Kind::ramp, .rise = 1};
    s.time = {0.25, 0.75};
    s.model = Model::march;
    s.precision = Precision::f64;
    s.output.traces.clear();
    s.output.fields = {{0.5, {Quantity::strain, Quantity::curvature}}};
    const Result r = run(s);
    const SceneMaps m = maps(s);
    Skin skin(Device::cpu(), d);
    for (double t : {0.25, 0.5}) {
        std::vector<float> pressure;
        for (double p : m.pressure) pressure.push_back(float(p * t));
        skin.press(pressure, 0.25);
    }
    for (const Field& f : r.fields) {
        const Skin::Response told = skin.response(f.quantity);
        CHECK(difference({told.begin(), told.end()}, {f.values.begin(), f.values.end()}) < 1e-6);
    }
}
