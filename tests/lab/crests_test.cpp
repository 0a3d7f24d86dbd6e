// SPDX-License-Identifier: MIT
// labels: threads
// Contact on the crests of the ridges alone.
#include "tests/oracle/scene_files.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <filesystem>
#include <numbers>

using namespace test;

namespace {

constexpr int width = 120, height = 60, period = 10;

// Straight ridges of whole cells under a dome of pressure.
Scene on_ridges() {
    Scene s;
    s.grid = {.width = width, .height = height, .spacing = 5e-5};
    s.surface = {.kind = Surface::Kind::map, .relief = 1e-5};
    s.material = {.modulus = 2e4, .viscosity = 1e3, .thickness = 1e-3, .curvature_length = 0};
    std::vector<double> ridges, dome;
    for (int i = 0; i < width * height; ++i) {
        const double x = i % width, r = std::hypot(x - width / 2, i / width - height / 2) / 30;
        ridges.push_back(std::cos(2 * std::numbers::pi * x / period));
        dome.push_back(std::sqrt(std::max(0.0, 1 - r * r)));
    }
    s.surface.map = ridges;
    s.load = {.kind = Load::Kind::map, .map = dome, .contact = Load::Contact::crests, .contact_length = period * 5e-5};
    s.time = {.step = 0.01, .duration = 0.1};
    return s;
}

} // namespace

TEST_CASE("the force of a press on crests is that of the even press, within a billionth") {
    for (double share : {0.1, 0.5, 0.9, 1.0}) {
        Scene s = on_ridges();
        s.load.contact_share = share;
        CHECK(sum_of(maps(s).pressure) == doctest::Approx(sum_of(s.load.map)).epsilon(1e-12));
    }
}

TEST_CASE("the share of the cells that is given is pressed, in proportion to its height, with the mean of a period") {
    Scene s = on_ridges();
    s.load.map = std::vector<double>(width * height, 3.0);
    for (double share : {0.3, 0.5}) {
        s.load.contact_share = share;
        const Map p = maps(s).pressure;
        const auto is_pressed = [](double v) { return v > 0; };
        const double pressed = double(std::ranges::count_if(p.values(), is_pressed)) / double(p.size());
        CHECK(std::abs(pressed - share) <= 1.0 / period + 1e-9); // heights come in groups of a period's cells
        double mean = 0;                                         // of a period far from the edges
        for (int x = 50; x < 50 + period; ++x) mean += p[size_t(30 * width + x)] / period;
        CHECK(mean == doctest::Approx(3).epsilon(2e-3)); // the rest is the edge's, and the scaling of the whole
        const auto over = [&](int x) { return p[size_t(30 * width + x)]; };
        const auto height_of = [](int x) { return std::cos(2 * std::numbers::pi * x / period); };
        if (share == 0.5) // three cells of a crest rise in a line over their heights
            CHECK((over(60) - over(61)) / (over(61) - over(62)) ==
                  doctest::Approx((height_of(60) - height_of(61)) / (height_of(61) - height_of(62))).epsilon(1e-6));
    }
}

TEST_CASE("the frames of a sequence are pressed on crests as the map of a product is") {
    Scene product = on_ridges();
    product.load.envelope = {.kind = Envelope::Kind::table, .times = {0, 0.05}, .values = {0, 1}};
    product.receptors.fa2 = Fa2::step_mean;
    const auto path = temporary("crests.npy");
    const std::vector<double> map = product.load.map.values();
    oracle::write_frames(path, product.grid, {std::vector<double>(map.size()), map});
    Scene frames = product;
    frames.load = {.kind = Load::Kind::sequence,
                   .path = path.string(),
                   .interval = 0.05,
                   .contact = Load::Contact::crests,
                   .contact_length = product.load.contact_length};
    product.output.fields = frames.output.fields = {{0.09, {Quantity::strain, Quantity::fa1}}};
    RunOptions f64;
    f64.precision = Precision::f64;
    const Result a = run(frames, Device::cpu(), f64), b = run(product, Device::cpu(), f64);
    for (size_t i : {0u, 1u}) CHECK(difference(a.fields[i].values, b.fields[i].values) < 1e-12);
    std::filesystem::remove(path);
}

TEST_CASE("a texture that slides under crests changes the force as it changes the pressure on them") {
    Scene s = on_ridges();
    Texture t{.map = {}, .width = period, .height = 1, .spacing = {}, .velocity = {5e-3, 0}}; // a cell each step
    for (int i = 0; i < period; ++i) t.map.edit().push_back(1 + 0.5 * std::cos(2 * std::numbers::pi * i / period));
    s.load.texture = t;
    s.output.traces = {Quantity::strain};
    s.material.viscosity = 1e-3; // the strain follows the pressure at once
    s.receptors.fa2 = Fa2::step_mean;
    const std::vector<double> mean = run(s).traces[0].mean;
    CHECK(mean[9] > 1.1 * mean[5]); // crest on crest, and crest on groove
    s.load.contact = Load::Contact::even;
    s.load.contact_length.reset();
    const std::vector<double> even = run(s).traces[0].mean;
    CHECK(even[9] == doctest::Approx(even[5]).epsilon(0.02));
}
