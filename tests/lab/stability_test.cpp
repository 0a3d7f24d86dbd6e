// SPDX-License-Identifier: MIT
// labels: device threads long
// Where the usual methods fail, as theory says, and that the exact one does not. One cell, one elastic unit of load.
#include "host/core/press/device.hpp"
#include "host/lab/march/march.hpp"
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

double last_error(Method method, double z, int steps) { return std::abs(relax(method, z, steps).back() - 1); }

bool within_load(const std::vector<double>& strain) {
    for (double v : strain)
        if (!(v >= 0 && v <= 1 + 1e-12)) return false;
    return true;
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

TEST_CASE("forward Euler: 0, 2, 0, 2 at z = 2, slow decay just below, growth just above") {
    const std::vector<double> at_limit = relax(Method::euler, 2, 100);
    for (size_t n = 0; n < at_limit.size(); ++n) CHECK(at_limit[n] == relative(n % 2 ? 0 : 2, 1e-12));
    CHECK(last_error(Method::euler, 2 * (1 - 1e-3), 1000) == relative(0.1351, 1e-3));
    CHECK(last_error(Method::euler, 2 * (1 + 1e-3), 1000) == relative(7.374, 1e-3));
    CHECK(last_error(Method::euler, 2 * 1.01, 1000) == relative(3.98e8, 1e-2));
    CHECK(std::abs(relax(Method::euler, 2 * (1 + 1e-3), 1000, Precision::f32).back() - 1) == relative(7.375, 1e-2));
}

TEST_CASE("RK2 grows without changing sign just above z = 2, RK4 just above 2.7853") {
    CHECK(last_error(Method::rk2, 2 * (1 + 1e-3), 1000) == relative(7.389, 1e-2));
    CHECK(last_error(Method::rk2, 2 * (1 - 1e-3), 1000) == relative(0.1353, 1e-2));
    const std::vector<double> rk2 = relax(Method::rk2, 2 * (1 + 1e-3), 1000);
    for (size_t n = 1; n < rk2.size(); ++n) REQUIRE(rk2[n] < rk2[n - 1]); // away from 1, always on the same side
    const double limit = 2.785293563405282;
    CHECK(last_error(Method::rk4, limit * (1 + 1e-3), 1000) == relative(66.6, 1e-2));
    CHECK(last_error(Method::rk4, limit * (1 - 1e-3), 1000) == relative(0.0150, 2e-2));
    CHECK(last_error(Method::rk4, limit * 1.01, 1000) > 1e17);
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

TEST_CASE("Crank-Nicolson rings at large z; backward Euler and the exact method stay between 0 and sigma/E at any") {
    const std::vector<double> ringing = relax(Method::crank_nicolson, 15400, 1000);
    CHECK(ringing[0] == relative(1.99974, 1e-5));
    CHECK(ringing[1] == relative(5.19e-4, 1e-2));
    CHECK(std::abs(ringing[999] - 1) == relative(0.77125, 1e-4));
    CHECK(within_load(relax(Method::crank_nicolson, 1.9, 50)));
    CHECK_FALSE(within_load(relax(Method::crank_nicolson, 2.1, 50)));
    for (double z : {1e-3, 0.1, 1.0, 3.0, 100.0, 1e6})
        for (Method m : {Method::backward_euler, Method::exact}) CHECK(within_load(relax(m, z, 50)));
}

TEST_CASE("SDIRK2 overshoots to 1.207 at z = 8.24, though one step of 1e6 lands; Crank-Nicolson's does not") {
    CHECK(relax(Method::sdirk2, 8.24, 1)[0] == relative(1.207, 1e-3));
    CHECK(within_load(relax(Method::sdirk2, 2.41, 50)));
    CHECK_FALSE(within_load(relax(Method::sdirk2, 2.42, 50)));
    for (Method m : {Method::exact, Method::backward_euler, Method::sdirk2}) CHECK(last_error(m, 1e6, 1) < 1e-5);
    CHECK(last_error(Method::crank_nicolson, 1e6, 1) > 0.99);
}

TEST_CASE("baselines converge at their orders, at their asymptotic errors; the exact method has none at any step") {
    const auto worst = [](Method m, double z) {
        const std::vector<double> strain = relax(m, z, int(5 / z));
        double error = 0;
        for (size_t n = 0; n < strain.size(); ++n)
            error = std::max(error, std::abs(strain[n] + std::expm1(-double(n + 1) * z)));
        return error;
    };
    const std::pair<Method, int> orders[] = {
        {Method::euler, 1},          {Method::rk2, 2},   {Method::rk4, 4}, {Method::backward_euler, 1},
        {Method::crank_nicolson, 2}, {Method::sdirk2, 2}};
    for (auto [method, order] : orders) {
        CAPTURE(name(method));
        const double z = order == 4 ? 0.1 : 0.01;
        CHECK(std::log2(worst(method, z) / worst(method, z / 2)) == relative(order, 0.03));
    }
    CHECK(worst(Method::euler, 0.0154) == relative(0.0154 / (2 * std::exp(1)), 0.02));
    CHECK(worst(Method::rk2, 0.0154) == relative(1.5e-5, 0.05));
    CHECK(worst(Method::rk4, 0.154) == relative(2.0e-6, 0.05));
    CHECK(worst(Method::crank_nicolson, 0.154) == relative(7.3e-4, 0.02));
    CHECK(worst(Method::sdirk2, 0.154) == relative(3.6e-4, 0.02));
    for (double z : {1e-3, 0.0154, 0.5, 2.5}) CHECK(worst(Method::exact, z) < 5e-15);
}

TEST_CASE(
    "on a chain an explicit method is bound by the fastest element: stable just below its limit, refused just above, "
    "and growing by that element's amplification where that is allowed") {
    const double tau = 0.004, rk4 = 2.785293563405282;
    for (auto [method, limit] : {std::pair{Method::euler, 2.0}, {Method::rk2, 2.0}, {Method::rk4, rk4}}) {
        CAPTURE(name(method));
        const double below = limit * tau * (1 - 1e-3), above = limit * tau * (1 + 1e-3);
        const Creep stable = last_of(stiff_scene(stiff_chain, method, below, 1000));
        const Creep held = creep_of(stiff_chain, method, below, 1000);
        CHECK(off(stable.strain, held.strain) < 1e-11);
        CHECK(off(stable.rate, held.rate) < 1e-9);
        CHECK(stable.strain < 3.6e-6); // it ends at 3.5e-6

        const auto refused_at = [&](double step) {
            const Scene scene = stiff_scene(stiff_chain, method, step, 1000);
            return refusal(Error::Code::bad_input, [&] { run(scene, Device::cpu(1)); });
        };
        const std::string message = refused_at(above);
        CHECK(message.find("in material.elements") != std::string::npos);
        CHECK(message.find("stable up to dt/tau = 2") != std::string::npos);
        CHECK(refused_at(0.02).find("(here 5 in material.elements)") != std::string::npos);
        // The other elements alone would allow such a step.
        const std::vector<KelvinVoigt> without_fastest = {stiff_chain[1], stiff_chain[2]};
        CHECK(off(last_of(stiff_scene(without_fastest, method, 0.02, 1000)).strain, 1 / 1e6 + 1 / 5e5) < 1e-5);

        Scene unstable = stiff_scene(stiff_chain, method, above, 1000);
        unstable.allow_unstable = true;
        const Creep grown = last_of(unstable), expected = creep_of(stiff_chain, method, above, 1000);
        CHECK(off(grown.strain, expected.strain) < 1e-9);
        unstable.time = {2 * above, 2 * above * 30.5}; // the fastest element soon outgrows all others
        const std::vector<double> strain = run(unstable, Device::cpu(1)).trace(Quantity::strain).mean;
        const size_t n = strain.size() - 1;
        CHECK(off((strain[n] - strain[n - 1]) / (strain[n - 1] - strain[n - 2]),
                  amplification(method, 2 * above / tau)) < 1e-6);
        CHECK(std::abs(strain[n]) > 1e3 * 3.5e-6);
    }
}

TEST_CASE("an implicit method blurs the fast element of a chain at steps far beyond its time, though the slow one is "
          "right; Crank-Nicolson rings there; the exact method does neither") {
    for (double step : {0.01, 0.04, 0.16, 0.64}) { // 2.5 to 160 of the fastest time
        CAPTURE(step);
        const Creep truth = creep_of(stiff_chain, Method::exact, step, 1);
        for (Method method : {Method::backward_euler, Method::crank_nicolson, Method::sdirk2, Method::exact}) {
            CAPTURE(name(method));
            const Creep found = last_of(stiff_scene(stiff_chain, method, step, 1));
            const Creep expected = creep_of(stiff_chain, method, step, 1);
            CHECK(off(found.strain, expected.strain) < 1e-13);
            CHECK(off(found.rate, expected.rate) < 1e-11);
            const double error = std::abs(found.rate / truth.rate - 1);
            if (method == Method::exact) CHECK(error < 1e-12);
            else CHECK(error > 0.4); // none shows half of FA1 rightly
        }
        const Creep blurred = last_of(stiff_scene({stiff_chain[0]}, Method::backward_euler, step, 1));
        const double z = step / 0.004;
        CHECK(off(blurred.rate, blurred.strain / step) < 1e-12); // the mean over the step
        CHECK(blurred.rate > 3 * std::exp(-z) / stiff_chain[0].viscosity);
    }
    // one step of ten of the fastest time: the whole creep of the fast element, spread over the step
    const Creep fast = last_of(stiff_scene({stiff_chain[0]}, Method::backward_euler, 0.04, 1));
    CHECK(fast.rate > 1000 * creep_of({stiff_chain[0]}, Method::exact, 0.04, 1).rate);
    const Creep slow = last_of(stiff_scene({stiff_chain[2]}, Method::backward_euler, 0.04, 1));
    const Creep slow_truth = creep_of({stiff_chain[2]}, Method::exact, 0.04, 1);
    CHECK(off(slow.strain, slow_truth.strain) < 0.02);
    CHECK(off(slow.rate, slow_truth.rate) < 0.001);
    CHECK(last_of(stiff_scene(stiff_chain, Method::crank_nicolson, 0.04, 1)).rate < 0); // the skin creeps all the same
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
