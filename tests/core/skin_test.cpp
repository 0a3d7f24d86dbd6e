// SPDX-License-Identifier: MIT
// labels: device threads
// dermis::Skin, frame by frame, on the CPU and on Vulkan.
#include "host/core/model/laplacian.hpp"
#include "host/core/press/device.hpp"
#include "tests/allocations.hpp"
#include "tests/oracle/scene_files.hpp"
#include "tests/shim.hpp"
#include "tests/support.hpp"

#include <cstring>
#include <thread>

using namespace test;

namespace {

// In metres, with receptors at depths.
SkinDescription in_depths(SkinDescription d) {
    d.grid.spacing = 1e-3;
    for (auto* length : {&d.surface.relief, &d.material.thickness, &d.material.curvature_length}) *length = 1e-3;
    d.material.modulus = 1.3, d.material.viscosity = 1;
    d.receptors.depth = {.sa1 = 3e-3, .sa2 = {}, .fa1 = 7e-3, .fa2 = 3e-3};
    return d;
}

// Everything that a skin answers over some frames of different lengths.
std::vector<std::vector<float>> pressed(Skin& skin, const SkinDescription& d, const std::vector<Quantity>& what) {
    std::vector<std::vector<float>> all;
    int n = 0;
    for (double dt : {0.01, 0.02, 0.0, 0.005, 3.0}) {
        skin.press(frame(d, n++), dt);
        for (Quantity q : what) all.push_back(answers(skin, q));
    }
    return all;
}

} // namespace

TEST_CASE(
    "frame by frame a skin has the bits of the run of the same sequence, however many frames lie between fields") {
    const int width = 45, height = 21, frames = 40; // a march takes several frames at once
    const SkinDescription plain_skin = ridged(width, height);
    for (const auto& [d, hold] : {std::pair{plain_skin, Hold::linear},
                                  {plain_skin, Hold::parabolic},
                                  {with_chain(plain_skin), Hold::linear},
                                  {with_chain(with_materials(plain_skin)), Hold::parabolic},
                                  {in_depths(plain_skin), Hold::linear}}) {
        Scene s;
        static_cast<SkinDescription&>(s) = d;
        const std::string path = temporary("skin_sequence.npy").string();
        std::vector<std::vector<double>> maps(frames, std::vector<double>(size_t(width * height))); // rests at first
        for (int n = 1; n < frames; ++n) std::ranges::copy(frame(s, n), maps[size_t(n)].begin());
        oracle::write_frames(path, s.grid, maps);
        s.load.kind = Load::Kind::sequence;
        s.load.path = path;
        s.load.interval = s.time.step = 0.02;
        s.load.hold = hold;
        s.time.duration = 0.02 * frames;
        s.model = Model::march;
        s.precision = Precision::f32;
        const auto has_fields = [](int n) { return n < 4 || n == 13 || n == 39; };
        for (int n = 1; n < frames; ++n)
            if (has_fields(n))
                s.output.fields.push_back({0.02 * n, {std::begin(all_responses), std::end(all_responses)}});
        const Result run_ = run(s, Device::cpu(1));
        SkinOptions plain{.precision = Precision::f32, .hold = hold};
        Skin skin(Device::cpu(1), s, plain);
        size_t field = 0;
        for (int n = 1; n < frames; ++n) {
            skin.press(frame(s, n), 0.02);
            if (!has_fields(n)) continue;
            for (Quantity q : all_responses) {
                const Field& f = run_.fields.at(field++);
                REQUIRE(f.quantity == q);
                const Skin::Response r = skin.response(q);
                REQUIRE(r.size == f.values.size());
                bool equal = true;
                for (size_t i = 0; i < r.size; ++i) equal &= double(r[i]) == f.values[i];
                CAPTURE(name(q));
                CAPTURE(n);
                CHECK(equal);
            }
        }
        std::remove(path.c_str());
    }
}

TEST_CASE(
    "a surface that gives its curvature has the bits of a stencil that computes the same, in cells and in sites") {
    const Validated vulkan;
    SkinDescription stencil = ridged(45, 21);
    const size_t cells = 45 * 21;
    stencil.surface = {.kind = Surface::Kind::map, .map = std::vector<double>(cells)};
    for (size_t i = 0; i < cells; ++i)
        stencil.surface.map.edit()[i] = std::sin(double(i % 45)) + double(i / 45 % 4) / 3;
    SkinDescription given = stencil, other = stencil;
    given.surface.curvature = model::laplacian(stencil.surface.map, stencil.grid, STENCIL_FIVE_POINT, EDGES_MIRROR);
    other.surface.curvature = std::vector<double>(cells, 0.25);
    const std::vector<Quantity> what = {Quantity::sa1, Quantity::fa1};
    SkinOptions options{.responses = what};
    for (bool sites : {false, true}) {
        if (sites) {
            options.responses.clear();
            for (SkinDescription* d : {&stencil, &given, &other})
                d->sites = {{Quantity::sa1, {3, 4}}, {Quantity::fa1, {44, 20}}};
        }
        Skin skin(Device::cpu(1), stencil, options);
        const auto expected = pressed(skin, stencil, what);
        for (const Device& device : {Device::cpu(1), Device::cpu(2), vulkan.device()}) {
            Skin same(device, given, options), another(device, other, options);
            CHECK(pressed(same, given, what) == expected);
            CHECK(pressed(another, other, what) != expected);
            if (!sites) CHECK(another.response(Quantity::curvature)[0] != same.response(Quantity::curvature)[0]);
        }
    }
    given.surface.curvature.edit().pop_back();
    CHECK(refusal(Error::Code::bad_input, [&] { Skin(Device::cpu(1), given); }) ==
          "surface.curvature = 944; allowed: width*height = 945 cells, row 0 first");
    other.surface.kind = Surface::Kind::flat;
    CHECK(refusal(Error::Code::bad_input, [&] { Skin(Device::cpu(1), other); }) ==
          "surface.curvature = 945; allowed: only with surface.kind \"file\"");
}

TEST_CASE("pressures of the cells that sites read are refused by their cell and number; fields read all cells") {
    const Validated vulkan;
    for (const Device& device : {Device::cpu(1), Device::cpu(3), vulkan.device()}) {
        SkinDescription d = ridged(40, 30);
        for (int i = 0; i < 6; ++i) d.sites.push_back({Quantity(1 + i % 4), {i * 7 % 40, i * 5 % 30}});
        Skin skin(device, d);
        const std::vector<int> cells = skin.cells();
        CHECK((std::ranges::is_sorted(cells) && cells.size() < 1200));
        std::vector<float> whole = frame(d, 1), pressures(cells.size(), 1);
        whole.back() = NAN; // of a cell that no site may read
        CHECK(refusal(Error::Code::bad_input, [&] { skin.press(whole, 0.01); }) != "");
        pressures.back() = NAN;
        const std::string cell = std::to_string(cells.back() % 40) + ", " + std::to_string(cells.back() / 40);
        CHECK(refusal(Error::Code::bad_input, [&] {
                  skin.press_cells(pressures.data(), pressures.size(), 0.01);
              }).find("pressure = nan in cell [" + cell + "]") == 0);
        refuses([&] { skin.press_cells(pressures.data(), pressures.size() - 1, 0.01); },
                std::to_string(cells.size()) + ", as cells() lists them");
    }
    Skin fields(Device::cpu(1), ridged(5, 4));
    fields.press_frames(nullptr, size_t(1) << 60, 0, 0.01, std::vector<int>{}); // of no pad: it ends at once
    CHECK(fields.cells().size() == 20);
    fields.press_cells(frame(ridged(5, 4), 1).data(), 20, 0.01);
    CHECK(fields.response(Quantity::sa1)[7] != 0);
}

TEST_CASE("a pause keeps the state, every strain of a chain and the rate of a spring too") {
    const Validated vulkan;
    SkinOptions plain;
    plain.precision = Precision::f32; // a compensated sum may take what it has carried along into its last place
    const SkinDescription one = ridged(33, 12);
    for (const Device& device : {Device::cpu(2), vulkan.device()})
        for (const SkinDescription& d : {one, with_chain(one)}) {
            Skin skin(device, d, plain), twin(device, d, plain);
            for (float v : skin.response(Quantity::sa1)) REQUIRE(v == 0);
            for (Skin* s : {&skin, &twin}) s->press(frame(d, 1), 0.1);
            for (int i = 0; i < 3; ++i) skin.press(frame(d, 1), 0);
            const auto strained = answers(twin, Quantity::sa1);
            CHECK(same_bits(answers(skin, Quantity::sa1), strained));
            for (Skin* s : {&skin, &twin}) s->press(frame(d, 2), 0.1);
            CHECK(same_bits(answers(skin), answers(twin)));
        }
}

TEST_CASE("what cannot be pressed is named, and nothing has happened") {
    const Validated vulkan;
    const SkinDescription d = ridged(20, 10);
    for (const Device& device : {Device::cpu(1), vulkan.device()}) {
        Skin skin(device, d), twin(device, d);
        for (Skin* s : {&skin, &twin}) s->press(frame(d, 1), 0.1);
        std::vector<float> bad = frame(d, 2);
        bad[3 * 20 + 7] = INFINITY;
        bad[5 * 20] = NAN;
        refuses([&] { skin.press(bad, 0.1); }, "pressure = inf in cell [7, 3]; allowed: finite numbers");
        refuses([&] { skin.press(bad.data(), 199, 0.1); }, "pressure = 199 cells; allowed: width*height = 200");
        refuses([&] { skin.press(frame(d, 2), -0.1); }, "dt = -0.1; allowed: a finite number >= 0");
        refuses([&] { skin.press(frame(d, 2), NAN); }, "dt = nan");
        refuses([&] { skin.response(Quantity::deformation); }, "response = \"deformation\"");
        std::vector<float> frames = frame(d, 2);
        frames.insert(frames.end(), bad.begin(), bad.end());
        refuses([&] { skin.press_frames(frames.data(), 2, 200, 0.1); },
                "pressure = inf in cell [7, 3] of frame 1; allowed: finite numbers");
        refuses([&] { skin.press_frames(frames.data(), 0, 200, 0.1); }, "count = 0; allowed: at least 1 frame");
        refuses([&] { skin.press_frames(frames.data(), 1, 400, 0.1); },
                "pressure = 400 cells; allowed: width*height = 200");
        refuses([&] { skin.press_frames(frames.data(), 1, 200, -0.1); }, "dt = -0.1; allowed: a finite number >= 0");
        refuses([&] { skin.press_frames(frames.data(), 1, 200, 1e300); }, "dt = 1e+300; allowed: seconds over which");
        for (Skin* s : {&skin, &twin}) s->press(frame(d, 3), 0.1);
        CHECK(same_bits(answers(skin), answers(twin)));
    }
}

TEST_CASE("a skin that cannot be is refused by name") {
    const auto says = [](const char* what, auto&& change) {
        SkinDescription d = ridged(20, 10);
        SkinOptions options;
        change(d, options);
        refuses([&] { Skin(Device::cpu(1), d, options); }, what);
    };
    says("grid.width = 0", [](auto& d, auto&) { d.grid.width = 0; });
    says("responses = \"strain\"", [](auto&, auto& o) { o.responses = {Quantity::strain}; });
    says("responses = \"fa1\"", [](auto&, auto& o) { o.responses = {Quantity::fa1, Quantity::fa1}; });
    says("responses = (none)", [](auto&, auto& o) { o.responses = {}; });
    says("precision = \"f64\"", [](auto&, auto& o) { o.precision = Precision::f64; });
    says("material.viscosity = 0", [](auto& d, auto&) { d.material.viscosity = 0; });
    says("sites[0]", [](auto& d, auto&) { d.sites = {{Quantity::fa1, {20, 0}}}; });
    // without FA2 an elastic skin is fine
    SkinDescription d = ridged(20, 10);
    d.material.viscosity = 0;
    SkinOptions options{.responses = {Quantity::sa1, Quantity::fa1}};
    Skin elastic(Device::cpu(1), d, options);
    elastic.press(std::vector<float>(200, 2.0f), 0.5);
    CHECK(elastic.response(Quantity::fa1).size == 200);
    refusal(Error::Code::bad_input, [&] { elastic.response(Quantity::fa2); });
}

TEST_CASE("from press to press nothing is allocated, and a device is called as often every time") {
    const Device vulkan = open_device("vulkan", shimmed()); // validation would allocate
    for (bool materials : {false, true})
        for (bool sites : {false, true}) {
            SkinDescription d = ridged(267, 300);
            if (materials) {
                d.material.viscosity_map = std::vector<double>(267 * 300, 2.0);
                d.material.viscosity_map.edit()[5 * 267 + 5] = 1;
            }
            if (sites) d.sites = {{Quantity::fa1, {5, 5}}, {Quantity::sa1, {266, 299}}};
            for (const Device& device : {Device::cpu(1), Device::cpu(2), vulkan}) {
                CAPTURE(device.info().name);
                Skin skin(device, d);
                const std::vector<float> a = frame(d, 1), b = frame(d, 2);
                for (int i = 0; i < 4; ++i) skin.press(i % 2 ? a : b, 0.01); // a driver makes its own beginning
                shim.calls.reserve(10000);
                const size_t before = allocations();
                skin.reset();
                size_t calls = 0;
                for (int i = 0; i < 10; ++i) {
                    shim.calls.clear();
                    skin.press(i % 2 ? a : b, 0.01 + 0.001 * i);
                    if (i <= 2) calls = shim.calls.size(); // each waits for the press before the last
                    REQUIRE(shim.calls.size() == calls);
                }
                const size_t after = allocations();
                CHECK(after == before);
                CHECK((calls > 0) == device.info().vulkan);
                CHECK(calls < 24);
                for (const std::string name : shim.calls)
                    CHECK_MESSAGE((name.find("vkCreate") == name.npos && name.find("vkAllocate") == name.npos &&
                                   name.find("vkMap") == name.npos && name != "vkUpdateDescriptorSets"),
                                  name);
            }
        }
}

TEST_CASE("skins on threads of their own do not disturb one another") {
    const SkinDescription d = ridged(40, 30);
    const std::vector<Quantity> what(std::begin(all_responses), std::end(all_responses));
    Skin alone(Device::cpu(1), d);
    const auto expected = pressed(alone, d, what);
    std::vector<std::vector<std::vector<float>>> got(6);
    std::vector<std::thread> threads;
    const Device shared = Device::cpu(1); // by threads that make their skins at the same time
    for (size_t i = 0; i < got.size(); ++i)
        threads.emplace_back([&, i] {
            Skin skin(i < 2 ? Device::cpu(2) : i < 4 ? shared : Device::open("vulkan"), d);
            got[i] = pressed(skin, d, what);
        });
    for (std::thread& t : threads) t.join();
    for (const auto& one : got) CHECK(one == expected);
}

TEST_CASE("a device whose bits differ is refused for a skin too, unless asked for by name") {
    const vulkan::Loader wrong = faulty(&Shim::miscompile_far);
    SkinDescription d = ridged(20, 12);
    const Device device = open_device("vulkan", wrong);
    CHECK_NOTHROW(Skin(device, d));
    d.stencil = Stencil::fourth_order;
    CHECK(refusal(Error::Code::no_device, [&] { Skin(device, d); }).find("bits differ") != std::string::npos);
    const Device named = open_device("0", wrong);
    CHECK(named.info().exact); // as far as opening it has tested
    CHECK_NOTHROW(Skin(named, d));
    CHECK_FALSE(named.info().exact);
}

TEST_CASE("a device keeps the pipelines of its skins and 128 others, however many kinds of skin come and go") {
    const Device device = open_device("0", shimmed());
    const SkinDescription d = ridged(20, 10);
    Skin stays(device, d), twin(Device::cpu(1), d);
    shim.calls.clear();
    for (int kind = 0; kind < 450; ++kind) {
        SkinOptions options{.count = 2};
        Skin(device, ridged(4 + kind % 150, 3 + kind / 150 * 8), options);
    }
    const auto calls = [](const char* name) { return std::ranges::count(shim.calls, std::string(name)); };
    const auto made = calls("vkCreateComputePipelines"), ended = calls("vkDestroyPipeline");
    CHECK(made > int(vulkan::Pipelines::most_unused) + 1);
    CHECK(made - ended <= int(vulkan::Pipelines::most_unused) + 1);
    for (Skin* skin : {&stays, &twin}) skin->press(frame(d, 1), 0.1);
    CHECK(same_bits(answers(stays), answers(twin)));
}

TEST_CASE("after a submission that did not come back nothing of a skin is destroyed") {
    const LeftToDriver leaks;
    const Device device = open_device("0", shimmed());
    const SkinDescription d = ridged(20, 12);
    {
        Skin skin(device, d);
        shim.fault = {"vkWaitForFences", 0, VK_ERROR_DEVICE_LOST, true};
        refusal(Error::Code::device, [&] { skin.press(frame(d, 1), 0.1), skin.response(Quantity::sa1); });
        shim.calls.clear();
    }
    for (const std::string name : shim.calls) CHECK(name != "vkDestroyPipeline");
}

TEST_CASE("what is beyond float is refused, or is seen to be: never a number that looks right") {
    const Validated vulkan;
    for (const Device& device : {Device::cpu(1), vulkan.device()}) {
        const SkinDescription d = ridged(20, 10);
        Skin skin(device, d), twin(device, d);
        for (Skin* s : {&skin, &twin}) s->press(frame(d, 1), 0.1);
        for (double dt : {1e-39, 5e-324, 1e39, 1e300})
            CHECK(refusal(Error::Code::bad_input, [&] { skin.press(frame(d, 2), dt); }).find("dt = ") == 0);
        for (Skin* s : {&skin, &twin}) s->press(frame(d, 3), 0.1);
        CHECK(same_bits(answers(skin), answers(twin)));
        const auto says = [&](const char* what, auto&& change) {
            SkinDescription wrong = d;
            change(wrong);
            CHECK(refusal(Error::Code::bad_input, [&] { Skin(device, wrong); }).find(what) == 0);
        };
        says("material.modulus = 1e+39", [](auto& w) { w.material.modulus = 1e39; });
        says("material.curvature_length = 1e+39; allowed: up to 3.4e38 for a skin in float", [](auto& w) {
            w.grid.spacing = w.material.viscosity = 1;
            w.surface.relief = w.material.thickness = 1;
            w.material.curvature_length = 1e39;
        });
        says("receptors.fa2_gains = 1e+39", [](auto& w) { w.receptors.fa2_gains = {1e39, 1}; });
        says("grid.spacing = 1e-20", [](auto& w) {
            w.grid.spacing = 1e-20;
            w.material.viscosity = 1;
            w.surface.relief = w.material.thickness = w.material.curvature_length = 1;
        });
        says("surface.relief = ", [](auto& w) {
            w.surface.kind = Surface::Kind::map;
            w.surface.map = std::vector<double>(200, 0.0);
            w.surface.map.edit()[21] = 1e39;
            w.sites = {{Quantity::fa2, {1, 1}}};
        });
        for (float v : {3e38f, -3e38f}) skin.press(std::vector<float>(200, v), 0.1);
        for (float v : skin.response(Quantity::fa2)) REQUIRE_FALSE(std::isfinite(v));
    }
}
