// SPDX-License-Identifier: MIT
// labels: threads
// A punch that is pressed to a depth, and receptors that follow the stress.
#include "tests/support.hpp"

#include <numbers>

using namespace test;

namespace {

// The preset's skin under a punch of 1 mm: relaxation times of 4, 70 and 1400 ms, a fourth of the stress in the end.
Scene punched(int cells, double spacing) {
    Scene s = flat_finger(cells, spacing);
    s.material.curvature_length = 0;
    s.load = {.kind = Load::Kind::punch,
              .radius = int(std::lround(1e-3 / spacing)),
              .intensity = 1e-3,
              .control = Load::Control::depth};
    s.time = {.step = 0.025, .duration = 1};
    return s;
}

constexpr double moduli[] = {5e4, 5e4, 5e4}, times[] = {0.004, 0.07, 1.4}, equilibrium = 5e4;

// The stress, over the equilibrium, at t under a strain that rises by `rate` until T and is held.
double stress_after_ramp(double rate, double T, double t) {
    double s = rate * std::min(t, T);
    for (int i = 0; i < 3; ++i)
        s += moduli[i] / equilibrium * rate * times[i] *
             (std::exp(-std::max(t - T, 0.0) / times[i]) - std::exp(-t / times[i]));
    return s;
}

} // namespace

TEST_CASE("the pressure of a punch has the force of Sneddon's, and is least in the middle") {
    for (double nu : {0.3, 0.4, 0.5}) {
        Scene s = punched(61, 5e-5);
        s.receptors.poisson = nu;
        const Map map = maps(s).pressure; // per Pa of E(t), times the depth
        double force = 0;
        for (double p : map) force += p * 5e-5 * 5e-5;
        CHECK(force == doctest::Approx(2 * 1e-3 * 1e-3 / (1 - nu * nu)).epsilon(1e-12));
        const double middle = map[30 * 61 + 30];
        CHECK(middle == doctest::Approx(1e-3 / (std::numbers::pi * (1 - nu * nu) * 1e-3)).epsilon(1e-3));
        CHECK(map[30 * 61 + 45] == doctest::Approx(middle / std::sqrt(1 - 0.75 * 0.75)).epsilon(2e-3));
        CHECK(map[30 * 61 + 51] == 0);
    }
}

TEST_CASE("on the axis below a flat punch the stress is that of Sneddon") {
    for (double z : {3e-4, 1e-3}) {
        Scene s = punched(201, 2e-5);
        s.output.traces = {Quantity::sa1};
        s.receptors.depth.sa1 = z;
        const double q = z / 1e-3, mean = 2 * 1e-3 * 1e-3 / ((1 - 0.16) * std::numbers::pi * 1e-6);
        const double expected = mean / 2 * (1 + 3 * q * q) / ((1 + q * q) * (1 + q * q));
        CHECK(run(s).traces[0].probes[0].back() == doctest::Approx(expected).epsilon(1e-3));
    }
}

TEST_CASE("the strain below a punch that is held is constant, whatever the material") {
    for (bool elastic : {false, true}) {
        Scene s = punched(61, 5e-5);
        if (elastic) {
            s.material.elements.clear();
            s.material.spring.reset();
            s.material.modulus = 3e4;
            s.material.viscosity = 1e3;
        }
        s.receptors.depth.sa1 = 3e-4;
        const Result r = run(s);
        const std::vector<double>& strain = r.traces[0].probes[0];
        const std::vector<double>& sa1 = r.traces[1].probes[0];
        for (size_t n = 2; n < strain.size(); ++n) {
            CHECK(std::abs(strain[n] - strain[1]) <= 1e-12 * strain[1]);
            CHECK(std::abs(sa1[n] - sa1[1]) <= 1e-12 * sa1[1]);
        }
    }
}

TEST_CASE("SA1 that follows the stress adapts at a held depth, as in the experiment of 1983") {
    for (auto [depth, fall] : {std::pair{0.65e-3, -38.91}, {1.3e-3, -29.14}}) {
        const double T = depth / 4e-4; // 0.4 mm/s
        Scene s = punched(41, 1e-4);
        s.load.intensity = depth;
        s.load.envelope = {.kind = Envelope::Kind::ramp, .rise = T};
        s.receptors.follow.sa1 = Signal::stress;
        s.time = {.step = 0.025, .duration = T + 12.1};
        s.output.fields = {{T, {Quantity::sa1}}, {T + 12, {Quantity::sa1}}};
        s.tolerance = 1e-9;
        const Result r = run(s);
        const size_t middle = 20 * 41 + 20;
        const double before = r.fields[0].values[middle], after = r.fields[1].values[middle];
        CHECK(100 * (after / before - 1) == doctest::Approx(fall).epsilon(2e-4)); // the page's two digits
        const double exact = stress_after_ramp(1, T, T + 12) / stress_after_ramp(1, T, T);
        CHECK(std::abs(after / before - exact) < 1e-9 * exact);
        const double w = maps(s).pressure[middle] / depth;
        for (size_t n : {10u, 60u, 200u, 500u}) // the trace
            CHECK(r.traces[1].probes[0][n] ==
                  doctest::Approx(w * depth / T * stress_after_ramp(1, T, double(n) * 0.025)).epsilon(1e-9));
        CHECK(r.predicted_error < 1e-9);
    }
}

TEST_CASE("under a given pressure the stress is the pressure, and its integral the integral of the pressure") {
    Scene s = punched(41, 1e-4);
    s.load = {.kind = Load::Kind::circular, .intensity = 2e3};
    s.load.envelope = {.kind = Envelope::Kind::ramp, .rise = 0.5};
    s.receptors.follow = {.sa1 = Signal::stress, .sa2 = Signal::stress};
    const Result r = run(s);
    for (size_t n = 0; n < r.time.size(); ++n) {
        const double t = r.time[n], risen = std::min(t / 0.5, 1.0);
        CHECK(r.traces[1].probes[0][n] == doctest::Approx(2e3 * risen / equilibrium).epsilon(1e-12));
        const double integral = t < 0.5 ? t * t : t - 0.25;
        CHECK(r.traces[2].probes[0][n] == doctest::Approx(2e3 * integral / equilibrium).epsilon(1e-12));
    }
}

TEST_CASE("materials of a sweep relax as themselves below a punch") {
    Scene s = punched(31, 1e-4);
    s.receptors.follow.sa1 = Signal::stress;
    std::vector<Material> materials(2, s.material);
    materials[1].elements = chain_of({.moduli = {1e5}, .times = {0.2}, .equilibrium = 2e4});
    materials[1].spring.reset();
    const std::vector<Result> all = run(s, materials);
    Scene second = s;
    second.material = materials[1];
    const Result alone = run(second);
    CHECK(all[1].traces[1].probes[0] == alone.traces[1].probes[0]);
    const double w = maps(s).pressure[15 * 31 + 15];
    CHECK(alone.traces[1].probes[0][10] == doctest::Approx(w * (1 + 5 * std::exp(-0.25 / 0.2))).epsilon(1e-9));
}

TEST_CASE("a depth has the unit of a length") {
    const std::string punch = "preset = \"fingertip\"\n[load]\nkind = \"punch\"\ncontrol = \"depth\"\nintensity = ";
    CHECK(Scene::from_string(punch + "\"0.65 mm\"\n").load.intensity == doctest::Approx(6.5e-4).epsilon(1e-15));
}
