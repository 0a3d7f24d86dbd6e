// SPDX-License-Identifier: MIT
// labels: device threads long
// Where the usual methods fail, as theory says, and that the exact one does not. One cell, one elastic unit of load.
#include "host/core/press/device.hpp"
#include "host/lab/march/march.hpp"
#include "tests/drawn_skin.hpp"
#include "tests/support.hpp"

using namespace test;

namespace {

// Strain after 1 .. steps steps at z = dt/tau under pressure 1.
std::vector<double> under_load(Method method, double z, int steps, Precision precision, double E) {
    Scene s;
    s.model = Model::march;
    s.grid = {2, 2, {}};
    s.load.kind = Load::Kind::map;
    s.load.map.edit().assign(4, 1.0);
    s.method = method;
    s.allow_unstable = true;
    s.material = {E, 1, {}, {}};
    s.time = {z / E, (steps + 1) * z / E};
    s.output.traces = {Quantity::strain};
    RunOptions options{.precision = precision};
    std::vector<double> strain = run(s, Device::cpu(1), options).trace(Quantity::strain).mean;
    strain.erase(strain.begin());
    return strain;
}

// The same in units of sigma/E.
std::vector<double> relax(Method method, double z, int steps, Precision precision = Precision::f64, double E = 1) {
    std::vector<double> strain = under_load(method, z, steps, precision, E);
    for (double& v : strain) v *= E;
    return strain;
}

// A chain of three elements, 4 ms beside 1.4 s, on one cell; a pressure of 1 Pa is held from time 0 on.
const std::vector<KelvinVoigt> stiff_chain = {{2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}};

Scene stiff_scene(const std::vector<KelvinVoigt>& chain, Method method, double step, int steps) {
    Scene s;
    s.grid = {1, 1, {}};
    s.material.elements = chain;
    s.load.kind = Load::Kind::map;
    s.load.map = {1};
    s.time = {step, (steps + 0.5) * step};
    s.output.traces = {Quantity::strain, Quantity::fa1};
    s.model = Model::moments;
    s.method = method;
    return s;
}

struct Creep {
    double strain, rate;
};

Creep last_of(const Scene& s) {
    const Result r = run(s, Device::cpu(1));
    return {r.trace(Quantity::strain).mean.back(), r.trace(Quantity::fa1).mean.back()};
}

double off(double x, double expected) { return std::abs(x / expected - 1); }

// The factor by which one step at z = dt/tau shrinks the distance of a strain to its end.
double amplification(Method method, double z) {
    const double g = 1 - std::sqrt(0.5);
    switch (method) {
    case Method::euler: return 1 - z;
    case Method::rk2: return 1 - z + z * z / 2;
    case Method::rk4: return 1 - z + z * z / 2 - z * z * z / 6 + z * z * z * z / 24;
    case Method::backward_euler: return 1 / (1 + z);
    case Method::crank_nicolson: return (2 - z) / (2 + z);
    case Method::sdirk2: return (1 - (1 - 2 * g) * z) / ((1 + g * z) * (1 + g * z));
    default: return std::exp(-z);
    }
}

// Strain and rate after so many steps of a method, each element by its own amplification.
Creep creep_of(const std::vector<KelvinVoigt>& chain, Method method, double step, int steps) {
    Creep sum{0, 0};
    for (const KelvinVoigt& e : chain) {
        const double left = std::pow(amplification(method, step * e.modulus / e.viscosity), steps);
        sum.strain += (1 - left) / e.modulus;
        sum.rate += left / e.viscosity;
    }
    return sum;
}

const Method baselines[] = {Method::euler,          Method::rk2,   Method::rk4, Method::backward_euler,
                            Method::crank_nicolson, Method::sdirk2};

} // namespace

TEST_CASE(
    "a step of any method shrinks the distance of a strain to its end by its amplification, in a cell and in each "
    "element of a chain, at any step") {
    Random random;
    for (Method method : {Method::exact, Method::euler, Method::rk2, Method::rk4, Method::backward_euler,
                          Method::crank_nicolson, Method::sdirk2}) {
        CAPTURE(name(method));
        for (int i = 0; i < 60; ++i) {
            const double z = random.decades(-3, i % 2 ? 0.7 : 5);
            const int steps = i % 2 ? 60 : 8;
            CAPTURE(z);
            const std::vector<double> strain = relax(method, z, steps);
            for (int n = 1; n <= steps; ++n) {
                const double left = std::pow(amplification(method, z), n);
                REQUIRE(strain[size_t(n - 1)] == absolute(1 - left, 1e-14 * n * (1 + std::abs(left)) * (1 + z)));
            }
            const double step = 0.004 * z; // of the fastest element's time
            Scene chain = stiff_scene(stiff_chain, method, step, steps);
            chain.allow_unstable = true;
            const Creep found = last_of(chain), expected = creep_of(stiff_chain, method, step, steps);
            CHECK(off(found.strain, expected.strain) < 1e-9);
            // A rate that has decayed is the rounding of what it was, 1 Pa over the viscosity.
            CHECK(found.rate == absolute(expected.rate, 1e-7 * std::abs(expected.rate) + 1e-12 / 8e3));
        }
    }
    // What that means: forward Euler rings from z = 1 on and grows from 2, RK4 from 2.7853 on; Crank-Nicolson rings.
    CHECK(amplification(Method::euler, 2) == -1);
    CHECK(amplification(Method::rk4, 2.785293563405282) == relative(1, 1e-12));
    CHECK(1 - amplification(Method::crank_nicolson, 15400) == relative(1.99974, 1e-5));
    CHECK(1 - amplification(Method::sdirk2, 8.24) == relative(1.207, 1e-3));
}

TEST_CASE("an explicit method is taken just below the limit of the fastest element, and refused just above") {
    for (auto [method, limit] : {std::pair{Method::euler, 2.0}, {Method::rk2, 2.0}, {Method::rk4, 2.785293563405282}}) {
        CAPTURE(name(method));
        CHECK(last_of(stiff_scene(stiff_chain, method, limit * 0.004 * (1 - 1e-3), 1000)).strain < 3.6e-6);
        const Scene above = stiff_scene(stiff_chain, method, limit * 0.004 * (1 + 1e-3), 1000);
        const std::string message = refusal(Error::Code::bad_input, [&] { run(above, Device::cpu(1)); });
        CHECK(message.find("in material.elements") != std::string::npos);
        CHECK(message.find("stable up to dt/tau = 2") != std::string::npos);
        // The other elements alone would allow such a step.
        const std::vector<KelvinVoigt> without_fastest = {stiff_chain[1], stiff_chain[2]};
        CHECK(off(last_of(stiff_scene(without_fastest, method, 0.02, 1000)).strain, 1 / 1e6 + 1 / 5e5) < 1e-5);
    }
}

TEST_CASE("with the units that the study prints forward Euler overflows at step 11 in float and 75 in double; exact is "
          "at sigma/E") {
    const double z = 15400, E = 1.54e6;
    const auto overflow = [&](Precision p) {
        const std::vector<double> strain = under_load(Method::euler, z, 100, p, E);
        return std::find_if(strain.begin(), strain.end(), [](double v) { return !std::isfinite(v); }) - strain.begin() +
               1;
    };
    CHECK(overflow(Precision::f32) == 11);
    CHECK(overflow(Precision::f64) == 75);
    for (Precision p : {Precision::f32, Precision::f64})
        CHECK(relax(Method::exact, z, 3, p, E)[0] == relative(1, p == Precision::f32 ? 0x1p-23 : 0x1p-52));
    for (Method m : {Method::euler, Method::rk2, Method::rk4}) {
        Scene s;
        s.model = Model::march;
        s.material.modulus = E;
        s.method = m;
        const std::string message = refusal(Error::Code::bad_input, [&] { run(s, Device::cpu()); });
        CHECK(message.find("here 15400") != std::string::npos);
        CHECK(message.find("allow_unstable") != std::string::npos);
    }
}

TEST_CASE("baselines keep E*integral(eps) + eta*eps = integral(sigma), whatever their error") {
    for (Method method : baselines) {
        CAPTURE(name(method));
        Scene s;
        s.model = Model::march;
        s.grid = {1, 1, {}};
        s.load.kind = Load::Kind::map;
        s.load.map = {2.0};
        s.method = method;
        s.time = {0.3, 9};
        RunOptions f64;
        f64.precision = Precision::f64;
        const Result r = run(s, Device::cpu(), f64);
        for (size_t n = 0; n < r.time.size(); ++n)
            CHECK(1.54 * r.trace(Quantity::sa2).mean[n] + r.trace(Quantity::strain).mean[n] ==
                  relative(2 * r.time[n], 1e-12));
    }
}

TEST_CASE("a small step moves a cell, and ridges on an offset of 1e4 lose nothing in a second difference") {
    CHECK(model::phi(1e-8).p1 == relative(1 - 0.5e-8, 1e-15)); // in float 1 - exp(-z) is 0
    for (int x = 1; x < 400; ++x) {
        const auto ridge = [](int i) { return float(1e4 + std::sin(2 * 3.14159265358979 * i / 128)); };
        const float w = ridge(x - 1), c = ridge(x), e = ridge(x + 1);
        CHECK(double(dermis::f32::second_difference(w, c, e)) == double(w) - 2.0 * c + e); // of the rounded input
    }
}

TEST_CASE("long runs: plain float stalls or drifts, compensated float does not, on CPU and Vulkan alike") {
    // the last output of a march of one cell in each precision, under pressure 1
    const auto last = [](double z, long long steps, Quantity q, Precision p, const Device& device) {
        Scene s;
        s.model = Model::march;
        s.grid = {1, 1, {}};
        s.load.kind = Load::Kind::map;
        s.load.map = {1.0};
        s.material = {1, 1, {}, {}};
        s.time = {z, z * double(steps + 1)};
        s.output.traces = {q};
        const model::PreparedRun run = everything(s);
        double value = NAN;
        const auto stepper = march(device, run.skin, run.schedule, p,
                                   [&](auto&, const model::Sample& sample) { value = sample.totals[size_t(q)].mean; });
        model::Timeline timeline(run.schedule, run.skin);
        for (model::Step step; timeline.next(step);) {
            if (step.trace < steps) step.trace = -1; // nobody looks
            stepper->press(step);
        }
        stepper->finish();
        return value;
    };
    const Device cpu = Device::cpu(1);
    const double creep = -std::expm1(-1e-2);
    CHECK(std::abs(last(1e-8, 1000000, Quantity::strain, Precision::f32_compensated, cpu) / creep - 1) < 1e-7);
    CHECK(std::abs(last(1e-8, 1000000, Quantity::strain, Precision::f32, cpu) / creep - 1) > 1e-4);

    // three hours at 1 kHz, tau = 1 s
    const double t = 10800, integral = t - 1 + std::exp(-t);
    CHECK(std::abs(last(1e-3, 10800000, Quantity::sa2, Precision::f32_compensated, cpu) / integral - 1) < 1e-6);
    CHECK(std::abs(last(1e-3, 10800000, Quantity::sa2, Precision::f32, cpu) / integral - 1) > 0.01);

    const Validated vulkan;
    for (Precision p : {Precision::f32, Precision::f32_compensated})
        CHECK(last(1e-4, 3000, Quantity::sa2, p, vulkan.device()) == last(1e-4, 3000, Quantity::sa2, p, cpu));
}

TEST_CASE("what plain sums would lose is carried without being asked for") {
    Scene s = test::small_scene(4, 4);
    s.model = Model::march;
    CHECK(run(s, Device::cpu()).precision == Precision::f32_compensated);
    RunOptions plain{.precision = Precision::f32};
    CHECK(run(s, Device::cpu(), plain).precision == Precision::f32);
}

TEST_CASE("stencils converge at orders 2, 4 and 2 on smooth fields that fit the edges") {
    for (Edges edges : {Edges::periodic, Edges::mirror})
        for (auto [stencil, order] :
             {std::pair{Stencil::five_point, 2}, {Stencil::fourth_order, 4}, {published_stencil, 2}}) {
            CAPTURE(int(stencil));
            CAPTURE(int(edges));
            double error[2];
            for (int k = 0; k < 2; ++k) {
                const int n = 32 << k;
                Scene s;
                s.model = Model::march;
                s.grid = {n, n, 1.0 / n};
                s.surface.kind = Surface::Kind::map;
                s.surface.relief = 1;
                s.material.modulus = 1.54;
                s.material.viscosity = 1;
                s.material.thickness = 0;
                s.material.curvature_length = 0;
                s.stencil = stencil;
                s.edges = edges;
                // periodic: whole waves; mirror: even about the edge, half a cell beyond the first cell
                const double w = 2 * M_PI, phase = edges == Edges::mirror ? M_PI / 2 : 0.3;
                for (int y = 0; y < n; ++y)
                    for (int x = 0; x < n; ++x)
                        s.surface.map.edit().push_back(std::sin(w * (x + 0.5) / n + phase) *
                                                       std::sin(w * (y + 0.5) / n + phase));
                const SceneMaps m = maps(s);
                error[k] = 0;
                for (size_t i = 0; i < m.surface.size(); ++i)
                    error[k] = std::max(error[k], std::abs(m.rest_curvature[i] + 2 * w * w * m.surface[i]));
            }
            CHECK(std::log2(error[0] / error[1]) == relative(order, 0.02));
        }
}

TEST_CASE("the stencil estimate is the five-point error on a smooth skin, and names kinks") {
    Scene s;
    s.model = Model::march;
    s.surface.kind = Surface::Kind::map;
    s.grid = {60, 60, {}};
    s.edges = Edges::periodic;
    const double k = 2 * M_PI / 20;
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 60; ++x) s.surface.map.edit().push_back(std::sin(k * x));
    s.load.kind = Load::Kind::map;
    s.load.map.edit().assign(3600, 0.0);
    s.time = {0.1, 0.2};
    const Result smooth = run(s, Device::cpu());
    double error = 0;
    const std::vector<double> C = maps(s).rest_curvature;
    for (size_t i = 0; i < C.size(); ++i) error = std::max(error, std::abs(C[i] + k * k * s.surface.map[i]));
    CHECK(smooth.stencil_estimate == relative(error, 0.05));
    CHECK(smooth.kinks == 0);
    s.load.map = {};
    s.load.kind = Load::Kind::circular; // apex and rim
    s.surface = {};
    s.time = {1, 20};
    CHECK(run(s, Device::cpu()).kinks > 20);
}
