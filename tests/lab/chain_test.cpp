// SPDX-License-Identifier: MIT
// Elements in series, against numbers of their closed form in 50 digits. The suite `planner` draws chains against their
// superposition, and the suites `ways` and `backends` compare their bits.
#include "tests/support.hpp"

#include <filesystem>
#include <fstream>

using namespace test;

namespace {

// Retardation times of 4 ms, 70 ms and 1.4 s, with a spring of 4 MPa and a dashpot of 20 MPa s.
Material finger() {
    Material m;
    m.elements = {{2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}};
    m.spring = 4e6;
    m.dashpot = 2e7;
    return m;
}

// One cell under a pressure of 1 Pa times an envelope.
Scene one_cell(const Material& material, const Envelope& envelope, double step, long long outputs) {
    Scene s;
    s.grid = {1, 1, {}};
    s.material = material;
    s.load.kind = Load::Kind::map;
    s.load.map = {1};
    s.load.envelope = envelope;
    s.receptors.fa2 = Fa2::step_mean;
    s.time = {step, step * (double(outputs) - 0.5)};
    s.tolerance = 1e-9;
    return s;
}

double mean_of(const Result& r, Quantity q, size_t row) {
    for (const Trace& t : r.traces)
        if (t.quantity == q) return t.mean[row];
    FAIL("no trace");
    return 0;
}

Scene read(const std::string& text) {
    const std::string path = temporary("chain.toml").string();
    std::ofstream(path) << text;
    const auto remove = [](const std::string* file) { std::filesystem::remove(*file); };
    const std::unique_ptr<const std::string, decltype(remove)> removed(&path, remove);
    return Scene::from_file(path);
}

} // namespace

TEST_CASE("a chain under a step, a ramp and a sine has the strain, integral and rate of its closed form in 50 digits") {
    struct Row {
        double time, strain, integral, rate;
    };
    Envelope step, ramp, sine;
    ramp.kind = Envelope::Kind::ramp;
    ramp.rise = 0.05;
    sine.kind = Envelope::Kind::sine;
    sine.frequency = 250;
    const std::vector<Row> of_step = {{0.001, 3.762618274578382e-7, 3.1544964648775754e-10, 1.1291073273085571e-4},
                                      {0.01, 8.5681441607596831e-7, 6.4193817864214467e-9, 2.4112998527891302e-5},
                                      {0.1, 1.6532234041432347e-6, 1.2700135572221583e-7, 4.8036759219099654e-6},
                                      {1, 2.8209160560111428e-6, 2.2737166905007153e-6, 7.4935415472351798e-7},
                                      {10, 4.2484190193537601e-6, 3.7130213372904736e-5, 5.1129271890171381e-8}};
    const std::vector<Row> of_ramp = {{0.01, 1.2838763572842893e-7, 5.4775230486285699e-10, 1.7136288321519366e-5},
                                      {0.05, 1.031901357298585e-6, 2.2545711306674149e-8, 2.6662491767434414e-5},
                                      {0.1, 1.5081257571457315e-6, 8.7973224993311412e-8, 6.40197631543028e-6},
                                      {1, 2.80197212779063e-6, 2.2035086411956133e-6, 7.6199657434177507e-7},
                                      {10, 4.2471404484412898e-6, 3.7024024205515528e-5, 5.1149679684792996e-8}};
    const std::vector<Row> of_sine = {{0.0005, 2.0205629989725789e-7, 5.0958928633871802e-11, 3.7159074663977233e-4},
                                      {0.001, 3.3278477994647842e-7, 1.8991454595819232e-10, 1.2243533682894187e-4},
                                      {0.0101, 6.0533811948200962e-8, 7.214100983645855e-10, -4.3036084860228752e-4},
                                      {0.1003, 4.4097863712178041e-8, 8.7921010561634309e-10, 4.2977342823206678e-4},
                                      {1.0007, 1.9451771898733421e-7, 1.6706200107730913e-9, 3.0981869192869423e-4}};
    for (const auto& [envelope, rows] : {std::pair{step, of_step}, {ramp, of_ramp}, {sine, of_sine}})
        for (const Row& row : rows) {
            const double dt = row.time >= 0.01 && envelope.kind != Envelope::Kind::sine ? row.time / 10 : 1e-4;
            const auto n = static_cast<long long>(std::round(row.time / dt));
            CAPTURE(int(envelope.kind));
            CAPTURE(row.time);
            Scene s = one_cell(finger(), envelope, row.time / double(n), n + 1);
            s.output.traces = {Quantity::strain, Quantity::sa2, Quantity::fa1};
            const Result r = run(s, Device::cpu());
            CHECK(mean_of(r, Quantity::strain, size_t(n)) == relative(row.strain, 2e-13));
            CHECK(mean_of(r, Quantity::sa2, size_t(n)) == relative(row.integral, 2e-13));
            CHECK(mean_of(r, Quantity::fa1, size_t(n)) == relative(row.rate, 2e-13));
            CHECK(r.precision == Precision::f64);
            CHECK(r.predicted_error < 1e-9);
        }
}

TEST_CASE("a chain of one element is that element; two equal ones are one of half the modulus and viscosity") {
    Scene one = small_scene(20, 15), chain = one, two = one;
    one.material.modulus = 1.54, one.material.viscosity = 0.7;
    chain.material.elements = {{1.54, 0.7}};
    two.material.elements = {{3.08, 1.4}, {3.08, 1.4}};
    const Result a = run(one, Device::cpu()), b = run(chain, Device::cpu()), c = run(two, Device::cpu());
    for (size_t t = 0; t < a.traces.size(); ++t) {
        CHECK(b.traces[t].mean == a.traces[t].mean);
        CHECK(b.traces[t].max == a.traces[t].max);
        CHECK(c.traces[t].mean == a.traces[t].mean); // halves are exact
    }
}

TEST_CASE(
    "a baseline takes each element of a chain by itself: where the fastest is stiff, order and stability are lost") {
    Envelope step;
    Material stiff;
    stiff.elements = {{2e6, 8e3}, {5e5, 7e5}}; // 4 ms, 1.4 s
    const auto error = [&](Method method, double dt) {
        Scene s = one_cell(stiff, step, dt, static_cast<long long>(0.4 / dt) + 1);
        s.output.traces = {Quantity::strain};
        s.tolerance = {};
        Scene exact = s;
        s.method = method;
        s.allow_unstable = true;
        const auto a = run(s, Device::cpu()).traces[0].mean, b = run(exact, Device::cpu()).traces[0].mean;
        double worst = 0;
        for (size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
        return worst / b.back();
    };
    CHECK(error(Method::euler, 0.01) > 100); // z = 2.5 of the fast element
    CHECK(error(Method::euler, 0.001) < 0.1);
    CHECK(error(Method::backward_euler, 0.01) < 0.2); // stable, and blurred
    CHECK(error(Method::backward_euler, 0.01) > 0.02);
    CHECK(error(Method::sdirk2, 0.001) < error(Method::backward_euler, 0.001) / 4);
}

TEST_CASE("a scene file's relaxation is the chain that relaxes so") {
    const std::string mean = "[receptors]\nfa2 = \"step-mean\"\n",
                      relaxation =
                          "[material]\nrelaxation = { moduli = [2.5e5, 2.5e5, 2.5e5], times = [4e-3, 7e-2, 1.4], "
                          "equilibrium = 2.5e5 }\n";
    const std::vector<KelvinVoigt> chain = read(relaxation + mean).material.elements;
    // by partial fractions in 50 digits
    const KelvinVoigt expected[] = {
        {1e6, 0}, {3174817.74533, 16814.8578792}, {1583300.75266, 165143.474228}, {486990.215745, 1382273.21823}};
    REQUIRE(chain.size() == 4);
    for (size_t k = 0; k < 4; ++k) {
        CHECK(chain[k].modulus == relative(expected[k].modulus, 1e-11));
        CHECK(chain[k].viscosity == relative(expected[k].viscosity, 1e-11));
    }
}
