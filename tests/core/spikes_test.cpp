// SPDX-License-Identifier: MIT
// labels: device threads
// The spikes of a Skin's nerve fibres.
#include "host/core/cpu/fibres.hpp"
#include "host/core/description/description.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <cstring>

using namespace test;

namespace {

constexpr int side = 12;

// Fibres of three classes, some with several endings, on cells of a small skin that is pressed by depth, so that its
// strains are known.
std::vector<Afferents> three_classes() {
    std::vector<Afferents> all(3);
    all[0].type = Quantity::sa1;
    all[1].type = Quantity::fa1;
    all[2].type = Quantity::fa2;
    for (int i = 0; i < 20; ++i) all[size_t(i % 3)].cells.push_back({i % side, (5 * i) % side});
    all.push_back({.type = Quantity::fa1, .model = {}, .cells = {}, .endings = 4}); // two fibres, of four endings each
    for (int i = 0; i < 8; ++i) all[3].cells.push_back({(7 * i) % side, i});
    return all;
}
SkinOptions spiking(Control control = Control::depth) {
    SkinOptions options{.responses = {Quantity::sa1}, .control = control};
    options.afferents = three_classes();
    return options;
}

// A vibration that grows, whose depths differ from cell to cell, m.
std::vector<float> depths(int frame, double dt, int pad = 0) {
    std::vector<float> all;
    for (int i = 0; i < side * side; ++i)
        all.push_back(float(2e-4 * (1 + 0.01 * i + 0.1 * pad) * (1 + std::sin(2 * 3.14159265 * 40 * dt * frame))));
    return all;
}

std::vector<Device> spiking_devices(const Validated& vulkan) {
    return {Device::cpu(1), Device::cpu(2), vulkan.device()};
}

} // namespace

TEST_CASE("fibres of a skin fire as the same fibres under the strains of their cells") {
    const Validated vulkan;
    for (const Device& device : spiking_devices(vulkan)) {
        const SkinDescription d = finger(side, side);
        Skin skin(device, d, spiking());
        std::vector<model::FibreKind> kinds;
        const std::vector<Afferents> all = scene::validated_afferents(d, three_classes());
        for (const Afferents& a : all) kinds.push_back(model::kind_of(a));
        cpu::Fibres<f32> alone(kinds, 1, 1, simd::best());
        size_t fired = 0;
        for (int n = 0; n < 200; ++n) {
            const double dt = n % 50 < 40 ? 0.001 : 0.004;
            const std::vector<float> depth = depths(n, 0.001);
            skin.press(depth, dt);
            std::vector<float> inputs;
            for (size_t k = 0; k < all.size(); ++k)
                for (size_t i = 0; i < all[k].cells.size(); ++i) {
                    const Cell c = all[k].cells[i];
                    inputs.push_back(float(kinds[k].factors[i / kinds[k].endings]) *
                                     (depth[size_t(c.y * side + c.x)] / float(*d.material.thickness)));
                }
            REQUIRE(alone.prepare(dt));
            alone.set_input(0, inputs.data());
            alone.forget_spikes();
            alone.press(0, 1);
            const std::vector<Spike> spikes = spikes_of(skin);
            REQUIRE(spikes.size() == alone.spikes().size());
            for (size_t i = 0; i < spikes.size(); ++i) {
                CHECK(spikes[i].pad == 0);
                CHECK(spikes[i].frame == 0);
                CHECK(spikes[i].afferent == alone.spikes()[i].fibre);
                // a step may round a strain otherwise than this quotient, which moves a spike by a place or two of the
                // search
                CHECK(std::abs(spikes[i].share - alone.spikes()[i].share) * dt < 1e-7);
                CHECK(spikes[i].share > 0);
                CHECK(spikes[i].share <= 1);
            }
            fired += spikes.size();
        }
        CHECK(fired > 100);
    }
}

TEST_CASE("fibres on sites fire as fibres on the same cells of a field") {
    const Validated vulkan;
    for (const Device& device : spiking_devices(vulkan)) {
        SkinDescription d = finger(side, side);
        SkinOptions options = spiking();
        options.afferents.pop_back(); // a class has its sites once
        Skin field(device, d, options);
        for (const Afferents& a : options.afferents)
            for (const Cell c : a.cells) d.sites.push_back({.type = a.type, .cell = c});
        for (Afferents& a : options.afferents) a.cells.clear(); // the sites of the class
        Skin sites(device, d, options);
        size_t fired = 0;
        for (int n = 0; n < 60; ++n) {
            field.press(depths(n, 0.001), 0.001);
            sites.press(depths(n, 0.001), 0.001);
            CHECK(same_bits(spikes_of(field), spikes_of(sites)));
            fired += spikes_of(field).size();
        }
        CHECK(fired > 30);
    }
}

TEST_CASE("fibres that cannot be are refused by name, and a step that is too long for them changes nothing") {
    const Device cpu = Device::cpu(1);
    const auto refused = [&](auto change) {
        SkinOptions options = spiking();
        change(options.afferents[0]);
        return refusal(Error::Code::bad_input, [&] { Skin(cpu, finger(side, side), options); });
    };
    AfferentModel m = afferent_model(Quantity::sa1);
    CHECK(refused([](Afferents& a) { a.type = Quantity::sa2; }) ==
          "afferents.type = \"sa2\"; allowed: sa1, fa1, fa2, which have parameters; give a model for sa2");
    CHECK(refused([&](Afferents& a) { a.model = m, a.model->membrane_time = 0; }) ==
          "afferents[0].membrane_time = 0; allowed: a finite number > 0");
    CHECK(refused([&](Afferents& a) { a.model = m, a.model->gains[2][0] = 1; }) ==
          "afferents[0].gains[2] = 1; allowed: 0: a filter of 2 poles has a continuous derivative of order 1 at most");
    CHECK(refused([&](Afferents& a) { a.model = m, a.model->frequency = 100; }) ==
          "afferents[0].quality = (not given); allowed: a number > 0: frequency and quality belong together");
    CHECK(refused([&](Afferents& a) { a.model = m, a.model->reset = 1; }) ==
          "afferents[0].reset = 1; allowed: a finite number < 1");
    CHECK(refused([](Afferents& a) {
              a.cells[1] = {side, 0};
          }) == "afferents[0].cells[1] = [12, 0]; allowed: [x, y] with x in 0..11, y in 0..11");
    CHECK(refused([](Afferents& a) { a.cells.clear(); }) ==
          "afferents[0].cells = (none); allowed: some cells, or sites of sa1 in the description");
    CHECK(refused([](Afferents& a) {
              a.cells.clear(), a.endings = 8;
          }).starts_with("afferents[0].endings = 8; allowed: 1 at sites, unless a line radius = \"1.5 mm\" says"));
    CHECK(refused([](Afferents& a) { a.endings = 0; }) == "afferents[0].endings = 0; allowed: a whole number, 1..64");
    CHECK(refused([](Afferents& a) { a.endings = 65; }) == "afferents[0].endings = 65; allowed: a whole number, 1..64");
    CHECK(refused([](Afferents& a) { a.endings = 3; }) ==
          "afferents[0].endings = 3; allowed: a divisor of the number of cells, 7");
    CHECK(refused([](Afferents& a) { a.follow = Signal::stress; }) ==
          "afferents[0].follow = \"stress\"; allowed: \"strain\", unless the skin is pressed by pressure and has one "
          "material that comes to rest");
    Skin skin(cpu, finger(side, side), spiking()), other(cpu, finger(side, side), spiking());
    for (int n = 0; n < 40; ++n) {
        if (n % 10 == 5) CHECK_THROWS_AS(skin.press(depths(n, 0.001), 1e4), Error);
        skin.press(depths(n, 0.001), 0.001);
        other.press(depths(n, 0.001), 0.001);
        CHECK(same_bits(spikes_of(skin), spikes_of(other)));
    }
}

TEST_CASE("a state with a number of a fibre that no press makes is refused; what is loaded stays loadable") {
    SkinOptions options = spiking();
    AfferentModel m = afferent_model(Quantity::sa1);
    m.after[0] = {.amplitude = -2, .time = 0.01};
    options.afferents[0].model = m;
    const Device cpu = Device::cpu(1);
    Skin skin(cpu, finger(side, side), options);
    for (int n = 0; n < 40; ++n) skin.press(depths(n, 0.001), 0.001);
    std::vector<char> state(skin.state_bytes());
    skin.save(state.data(), state.size());
    constexpr char part[] = "fibres\0";
    const size_t at = size_t(std::search(state.begin(), state.end(), part, part + sizeof part) - state.begin()) + 16;
    const auto with = [&](size_t number, float x) { // of the part
        std::vector<char> changed = state;
        std::memcpy(changed.data() + at + number * sizeof x, &x, sizeof x);
        return changed;
    };
    const auto refused = [&](size_t fibre, size_t plane, float x) {
        const std::vector<char> changed = with(fibre * FIBRE_PLANES + plane, x);
        return refusal(Error::Code::bad_input, [&] { skin.load(changed.data(), changed.size()); });
    };
    CHECK(refused(0, FIBRE_Y1, 3e38f).find("state = (y' = ") == 0);
    CHECK(refused(0, FIBRE_Y0, 1e25f).find(" of afferent 0); allowed: -1e+24 .. 1e+24") != std::string::npos);
    CHECK(refused(6, FIBRE_MEMBRANE, 1.5f).find("state = (V = 1.5 of afferent 6); allowed: -1e+30 .. 1") == 0);
    CHECK(refused(0, FIBRE_REST, -1e-6f).find("state = (refractory time = ") == 0);
    CHECK(refused(0, FIBRE_REST, 0.01f).find("of afferent 0); allowed: 0 .. 0.00284") != std::string::npos);
    CHECK(refused(0, FIBRE_AFTER0, 0.1f).find("(after = ") != std::string::npos);
    CHECK(refused(0, FIBRE_AFTER1, 0.1f).find("of afferent 0); allowed: 0 .. 0") != std::string::npos);
    CHECK(refused(21, FIBRE_INPUT, 1e13f).find("of afferent 20); allowed: -1e+12") != std::string::npos); // an ending
    CHECK(refused(27, FIBRE_INPUT, 1e13f).find("of afferent 21); allowed: -1e+12") != std::string::npos);
    std::vector<char> after(state.size());
    skin.save(after.data(), after.size());
    CHECK(after == state);
    size_t taken = 0;
    for (size_t number = 0; number < (state.size() - at) / sizeof(float); ++number)
        for (const float x : {1e22f, -1e22f, 1e12f, -1e9f, 1.0f, -5.0f, 1e-45f, 1e-3f}) {
            const std::vector<char> changed = with(number, x);
            Skin wild(cpu, finger(side, side), options);
            try {
                wild.load(changed.data(), changed.size());
            } catch (const Error&) {
                continue;
            }
            ++taken;
            for (const double dt : {1e-3, 0.02, 1e-6}) {
                wild.press(depths(3, 0.001), dt);
                for (const Spike& s : spikes_of(wild)) CHECK((s.share > 0 && s.share <= 1));
                wild.save(after.data(), after.size());
                CHECK_NOTHROW(wild.load(after.data(), after.size()));
            }
        }
    CHECK(taken > 500);
}
