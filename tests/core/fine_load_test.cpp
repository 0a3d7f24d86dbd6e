// SPDX-License-Identifier: MIT
// Report::fine_load: how much of a load is finer than receptors lie deep.
#include "host/core/model/spread.hpp"
#include "host/core/press/report.hpp"
#include "tests/support.hpp"

#include <numeric>

using namespace test;

namespace {

constexpr int side = 40;
constexpr double spacing = 1e-4;

// A flat skin whose FA1 receptors lie so many cells deep.
SkinDescription deep(double cells) {
    SkinDescription s = fingertip();
    s.grid = {side, side, spacing};
    s.surface = {.kind = Surface::Kind::flat, .relief = 1e-5};
    s.receptors.depth = {.sa1 = 1e-5, .fa1 = cells * spacing};
    return s;
}

std::vector<double> load_of(double (*pressure)(double x, double y)) {
    std::vector<double> all;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) all.push_back(pressure(x + 0.5 - side / 2, y + 0.5 - side / 2));
    return all;
}

constexpr auto even = [](double, double) { return 7.0; };
constexpr auto cell = [](double x, double y) { return x == 0.5 && y == 0.5 ? 3.0 : 0.0; };
constexpr auto half = [](double x, double) { return x > 0 ? 2.0 : 0.0; };
constexpr auto disc = [](double x, double y) { return std::hypot(x, y) < 6 ? 1.0 : 0.0; };
constexpr auto dome = [](double x, double y) { return std::max(0.0, 1 - std::hypot(x, y) / 8); };
constexpr auto waves = [](double x, double y) { return std::max(0.0, 1 - std::hypot(x, y) / 11) * (1 + std::cos(x)); };

// The share of a load that the stress at the depth of the deepest class brings to other cells, by sums over all cells.
double moved(const std::vector<double>& load, double depth) {
    const model::PointForce<double> below({depth, DepthKernel::stress, 0});
    std::vector<double> weight(side * side);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
            weight[size_t(y * side + x)] = model::of_square(double(x), double(y), 1.0, below);
    double stays = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            double stress = 0;
            for (int b = 0; b < side; ++b)
                for (int a = 0; a < side; ++a)
                    stress += weight[size_t(std::abs(y - b) * side + std::abs(x - a))] * load[size_t(b * side + a)];
            stays += std::min(stress, load[size_t(y * side + x)]);
        }
    return 1 - stays / std::accumulate(load.begin(), load.end(), 0.0);
}

} // namespace

TEST_CASE("nothing of an even load is finer than a depth, almost all of a point, and of an edge a closed form") {
    for (const int reach : {1, 4, 9}) {
        const double wide = 2 * reach + 1;
        CHECK(std::abs(fine_load_of(deep(reach), load_of(even))) < 1e-12);
        CHECK(fine_load_of(deep(reach), load_of(cell)) == relative(1 - 1 / (wide * wide), 1e-12));
        // Cell k behind the edge is pressed by 1, and the mean around it is (k + reach)/wide.
        const double edge = reach * (reach + 1) / (2 * wide) / (side / 2);
        CHECK(fine_load_of(deep(reach), load_of(half)) == relative(edge, 1e-12));
    }
    std::vector<double> pulled = load_of(half);
    for (double& p : pulled) p *= -1e-3;
    CHECK(fine_load_of(deep(4), pulled) == relative(fine_load_of(deep(4), load_of(half)), 1e-12));
    CHECK(std::isnan(fine_load_of(deep(4), std::vector<double>(side * side))));
    SkinDescription without = deep(4);
    without.grid.spacing.reset();
    CHECK(std::isnan(fine_load_of(without, load_of(cell))));
    without = deep(20);
    const double by_depth = fine_load_of(without, load_of(disc));
    without.receptors.depth = {}; // a fingertip's deepest receptors lie 2 mm deep
    CHECK(fine_load_of(without, load_of(disc)) == by_depth);
}

TEST_CASE("the share of a load that is finer than a depth is that which the stress there moves, within a tenth") {
    for (auto shape : {+cell, +disc, +dome, +waves})
        for (const double depth : {2.0, 4.0, 8.0}) {
            CAPTURE(depth);
            const std::vector<double> load = load_of(shape);
            const double fine = fine_load_of(deep(depth), load);
            CHECK(fine > 0);
            CHECK(std::abs(fine - moved(load, depth)) < 0.1);
        }
}

TEST_CASE("plan, run and a skin report the same share of a load, and only a skin without depths has too much of it") {
    Scene s{deep(5)};
    s.load = {.radius = 6, .intensity = 2e4};
    s.time = {.step = 0.1, .duration = 0.5};
    s.receptors.depth = {};
    const Figure by_run = report(s, run(s)).fine_load;
    CHECK(by_run.value == plan(s).fine_load);
    CHECK(by_run.greatest == 0.1);
    CHECK(by_run.outside());
    const std::vector<double> load = model::prepare_run(s).schedule.pressure;
    Skin skin(Device::cpu(1), s, {.responses = {Quantity::sa1}, .count = 2});
    CHECK(std::isnan(skin.report().fine_load.value));
    skin.press(std::vector<float>(load.begin(), load.end()), 0.1, std::vector<int>{1});
    CHECK(skin.report(1).fine_load.value == relative(by_run.value, 1e-6));
    CHECK(std::isnan(skin.report(0).fine_load.value));

    s.receptors.depth = fingertip_depths();
    const Figure deeper = report(s, run(s)).fine_load;
    CHECK(deeper.value == by_run.value);
    CHECK(deeper.greatest == 1);
    s.sites = {{Quantity::sa1, {3, 4}}};
    s.output.traces = {};
    CHECK(report(s, run(s)).fine_load.value == by_run.value);
    s.more_loads = {s.load};
    s.more_loads[0].intensity = -1e4; // half of it remains
    CHECK(plan(s).fine_load == relative(by_run.value, 1e-12));
}
