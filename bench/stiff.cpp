// SPDX-License-Identifier: MIT
// Error against step and time on a stiff chain of elements, 4 ms beside 1.4 s.
#include "bench/bench.hpp"
#include "bench/cvode.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace bench {

using namespace dermis;

namespace {

constexpr double end = 2.56, longest_step = 0.64, fastest = 0.004; // s
constexpr double peer_interval = 0.01;                             // s between outputs of a peer with steps of its own
constexpr int width = 16, cells = width * width;

// Retardation times of 4 ms, 70 ms and 1.4 s.
std::vector<KelvinVoigt> chain() { return {{2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}}; }

std::vector<double> pressure() {
    std::vector<double> p;
    for (int i = 0; i < cells; ++i) p.push_back(1e4 * (0.5 + 0.5 * i / cells));
    return p;
}

// Every cell has a receptor of its strain and one of its rate: without a curvature length, SA1 and FA1 are these.
Scene scene_of(Method method, double step) {
    Scene s;
    s.grid = {width, width, 1e-3};
    s.surface.kind = Surface::Kind::flat;
    s.surface.relief = 5e-5;
    s.material.elements = chain();
    s.material.thickness = 1e-3;
    s.material.curvature_length = 0;
    s.load.kind = Load::Kind::map;
    s.load.map = pressure();
    s.time = {step, end + step / 2}; // the last output is at the end
    for (int i = 0; i < cells; ++i)
        for (Quantity q : {Quantity::sa1, Quantity::fa1}) s.sites.push_back({q, {i % width, i / width}});
    s.output.traces.clear();
    s.model = Model::sites;
    s.method = method;
    return s;
}

// The greatest error over cells and outputs by the greatest value of strain and FA1, against the closed form of a held
// load. responses: strain and rate of each cell at each output, the first at time 0.
std::array<double, 6> errors_of(const std::vector<double>& responses, double interval) {
    const std::vector<double> p = pressure();
    std::array<long double, 2> worst{}, largest{};
    for (size_t n = 1; n * 2 * cells < responses.size(); ++n) {
        long double exact[2] = {0, 0};
        for (const KelvinVoigt& e : chain()) {
            const long double z = (long double)(n)*interval * e.modulus / e.viscosity;
            exact[0] += -std::expm1(-z) / e.modulus;
            exact[1] += std::exp(-z) / e.viscosity;
        }
        for (size_t i = 0; i < cells; ++i)
            for (size_t q = 0; q < 2; ++q) {
                const long double off = responses[(n * cells + i) * 2 + q] - p[i] * exact[q];
                worst[q] = std::isfinite(off) ? std::max(worst[q], std::abs(off)) : INFINITY;
                largest[q] = std::max(largest[q], p[i] * exact[q]);
            }
    }
    std::array<double, 6> errors{NAN, NAN, NAN, NAN, NAN, NAN};
    errors[size_t(Quantity::strain)] = double(worst[0] / largest[0]);
    errors[size_t(Quantity::fa1)] = double(worst[1] / largest[1]);
    return errors;
}

// A row without its time, and the work that measures it.
struct Contender {
    Measurement row;
    std::function<double()> seconds; // empty: not installed
};

// One thread takes all cells, as the peer does.
Contender of_method(const Bench& bench, Method method, double step) {
    const Device cpu = Device::cpu(1);
    Scene s = scene_of(method, step);
    Measurement r = bench.cpu("stiff", width, 1);
    r.model = "sites";
    r.precision = "f64";
    r.method = name(method);
    r.stencil = "";
    r.dt_over_tau = step / fastest;
    r.steps = std::llround(end / step);
    r.receptors = 2 * cells;
    try {
        r.errors = errors_of(run(s, cpu).responses, step);
    } catch (const Error&) { // refused as unstable: its error is charted all the same
        r.status = "unstable";
        s.allow_unstable = true;
        r.errors = errors_of(run(s, cpu).responses, step);
    }
    return {r, [s, cpu] { return run(s, cpu).seconds; }};
}

Contender of_cvode(const Bench& bench, double tolerance) {
    const CreepProblem problem{.chain = chain(),
                               .pressure = pressure(),
                               .interval = peer_interval,
                               .outputs = int(std::lround(end / peer_interval))};
    Measurement r = bench.cpu("stiff", width, 1);
    r.backend = r.driver = "cvode";
    r.driver_version = cvode_version();
    r.exact = false;
    r.model = "bdf";
    r.precision = "f64";
    r.method = r.stencil = "";
    r.receptors = 2 * cells;
    const std::optional<CvodeRun> first = cvode(problem, tolerance);
    if (!first) {
        r.status = not_installed;
        return {r, {}};
    }
    r.method = fmt::format("rtol={:g}", tolerance);
    r.steps = first->steps;
    r.dt_over_tau = end / double(first->steps) / fastest;
    r.errors = errors_of(first->responses, peer_interval);
    return {r, [problem, tolerance] { return cvode(problem, tolerance)->seconds; }};
}

std::vector<Contender> contenders_of(const Bench& bench) {
    const double least = bench.quick ? 0.002 : 0.0003;
    std::vector<Contender> all;
    for (Method m : {Method::exact, Method::euler, Method::rk2, Method::rk4, Method::backward_euler,
                     Method::crank_nicolson, Method::sdirk2})
        for (double step = longest_step; step >= least; step /= 2) all.push_back(of_method(bench, m, step));
    for (double tolerance = 1e-2; tolerance > 3e-13; tolerance /= 10) {
        all.push_back(of_cvode(bench, tolerance));
        if (!all.back().seconds) break; // one row says so
    }
    return all;
}

} // namespace

void stiff(Bench& bench) {
    std::vector<Contender> contenders = contenders_of(bench);
    std::vector<std::function<double()>> work;
    for (const Contender& c : contenders)
        if (c.seconds) work.push_back(c.seconds);
    const std::vector<Timing> timings = bench.paired(work, bench.runs);
    auto timing = timings.begin();
    for (Contender& c : contenders) {
        if (c.seconds) c.row.wall = *timing++;
        bench.add(c.row);
    }
}

} // namespace bench
