// SPDX-License-Identifier: MIT
// labels: device threads
// A Skin whose cells are pressed by depth.
#include "tests/support.hpp"

using namespace test;

namespace {

const SkinOptions by_depth{.control = Control::depth};

// Depths of up to 0.4 mm, some of which pull.
std::vector<float> depths(size_t cells, int n) {
    std::vector<float> all;
    for (size_t i = 0; i < cells; ++i) all.push_back(3e-4f * std::sin(0.3f * float(i) + float(n)) + 1e-4f);
    return all;
}

} // namespace

TEST_CASE("a skin that is pressed by depth is strained by depth over thickness, and no cell pulls") {
    SkinDescription d = finger(6, 1, 5e-5);
    d.material.curvature_length = 0;
    Skin skin(Device::cpu(1), d, by_depth);
    const std::vector<float> at[] = {{1e-4f, 2e-4f, -1e-4f, 0, 5e-4f, -0.0f},
                                     {3e-4f, 1e-4f, 1e-4f, -2e-4f, 5e-4f, 1e-4f}};
    std::vector<double> before(6), sum(6), rates(6);
    for (const auto& [n, dt] : {std::pair{0, 0.01}, {1, 0.02}, {0, 0.5}, {0, 0.1}}) {
        skin.press(at[n], dt);
        for (size_t i = 0; i < 6; ++i) {
            const double strain = std::max(0.0, double(at[n][i])) / 1e-3, rate = (strain - before[i]) / dt;
            sum[i] += dt * (strain + before[i]) / 2;
            CHECK(skin.response(Quantity::sa1)[i] == relative(strain, 1e-6));
            CHECK(skin.response(Quantity::sa2)[i] == relative(sum[i], 1e-6));
            CHECK(skin.response(Quantity::fa1)[i] == absolute(rate, 1e-6 * 0.5 / dt));
            CHECK(skin.response(Quantity::fa2)[i] == absolute((rate - rates[i]) / dt, 1e-6 * 50 / dt));
            CHECK(skin.response(Quantity::indentation)[i] == relative(1e-3 * strain, 1e-6));
            before[i] = strain;
            rates[i] = rate;
        }
    }
    const Report report = skin.report();
    CHECK(report.strain.value == relative(0.5, 1e-6));
    CHECK(report.retardation_times.empty());
}

TEST_CASE("pressed by depth, a skin has the bits of a spring of 1 Pa that is pressed by the strains") {
    SkinDescription d = finger(67, 23, 5e-5), spring = d;
    spring.material = {.modulus = 1, .viscosity = 0, .thickness = 1e-3, .curvature_length = 1e-5};
    SkinOptions options = by_depth;
    options.responses = {Quantity::sa1, Quantity::sa2, Quantity::fa1};
    Skin skin(Device::cpu(1), d, options);
    options.control = Control::pressure;
    Skin other(Device::cpu(1), spring, options);
    for (int n = 0; n < 3; ++n) {
        std::vector<float> strains = depths(67 * 23, n);
        skin.press(strains, 0.01);
        for (float& x : strains) x = x > 0 ? x / 1e-3f : 0.0f;
        other.press(strains, 0.01);
        for (Quantity q : options.responses) CHECK(same_bits(answers(skin, q), answers(other, q)));
    }
}

TEST_CASE("a skin that is pressed by depth refuses materials and depths that have no meaning") {
    const SkinDescription d = finger(4, 3, 5e-5);
    Skin skin(Device::cpu(1), d, by_depth);
    SkinDescription point = d;
    point.receptors.fa2 = Fa2::point; // a rate that jumps has no density
    point.material = {.modulus = 1e5, .viscosity = 1e3, .thickness = 1e-3, .curvature_length = 0};
    refuses([&] { Skin(Device::cpu(1), point, by_depth); },
            "receptors.fa2 = \"point\"; allowed: \"step-mean\" with control = depth");
    refuses([&] { skin.set_material(d.material); }, "none with control = depth");
    refuses([&] { skin.press(std::vector<float>(12, -INFINITY), 0.01); }, "pressure = -inf in cell [0, 0]");
    refuses([&] { skin.press(std::vector<float>(12, NAN), 0.01); }, "pressure = nan in cell [0, 0]");
    std::vector<float> deep(24, 0.0f);
    deep[17] = 1e37f; // a finite depth, and over 1 mm no finite strain
    std::vector<char> before(skin.state_bytes()), after(before);
    skin.save(before.data(), before.size());
    refuses([&] { skin.press(deep.data() + 12, 12, 0.01); },
            "pressure = 9.999999933815813e+36 in cell [1, 1]; allowed: depths below 3.4e38 times the thickness");
    refuses(
        [&] { skin.press_frames(deep.data(), 2, 12, 0.01); },
        "pressure = 9.999999933815813e+36 in cell [1, 1] of frame 1; allowed: depths below 3.4e38 times the thickness");
    skin.save(after.data(), after.size());
    CHECK(after == before);
    refuses(
        [&] {
            Skin(Device::cpu(1), d, {.count = 2, .materials = {d.material, d.material}, .control = Control::depth});
        },
        "materials = (given)");
    SkinDescription thin = d;
    for (const double thickness : {0.0, 1e-50}) { // 0 in float
        thin.material.thickness = thickness;
        refuses([&] { Skin(Device::cpu(1), thin, by_depth); }, "; allowed: above 0 in float");
    }
    thin.material.thickness = 1e-3;
    thin.receptors.follow.sa1 = Signal::stress;
    refuses([&] { Skin(Device::cpu(1), thin, by_depth); }, "receptors.follow.sa1");
}
