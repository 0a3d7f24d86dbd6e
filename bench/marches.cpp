// SPDX-License-Identifier: MIT
// Marches of traces by materials and precision, beside a native peer.
#include "bench/bench.hpp"
#include "bench/native.hpp"
#include "bench/skins.hpp"

#include <algorithm>

namespace bench {

using namespace dermis;

namespace {

struct Contender {
    const char* workload;
    Spread spread;
    Precision precision = Precision::f32;
    int steps; // of a run; fewer where a step takes longer
};

constexpr Contender contenders[] = {
    {.workload = "march-uniform", .spread = Spread::uniform, .steps = 100},
    {.workload = "march-uniform", .spread = Spread::uniform, .precision = Precision::f32_compensated, .steps = 100},
    {.workload = "march-uniform", .spread = Spread::uniform, .precision = Precision::f64, .steps = 100},
    {.workload = "march-patches-4", .spread = Spread::patches, .steps = 100},
    {.workload = "march-random-4", .spread = Spread::random, .steps = 100},
    {.workload = "march-random-1000", .spread = Spread::thousand, .steps = 100},
    {.workload = "march-each", .spread = Spread::each, .steps = 60}};

double modulus_of(size_t material) { return 1.54 * (1 + 0.1 * double(material % 8) + 1e-3 * double(material)); }

// A load that rises for longer than any run: held loads have no new coefficients in any step.
Scene scene_of(int n) {
    Scene s;
    s.grid = {n, n, {}};
    s.surface.kind = Surface::Kind::wave;
    s.surface.noise = 0;
    s.load.kind = Load::Kind::linear;
    s.load.radius = n;
    s = with_maps(s);
    s.load.envelope.kind = Envelope::Kind::ramp;
    s.load.envelope.rise = 20;
    s.model = Model::march;
    return s;
}

Scene with_contender(Scene s, const Contender& c, int steps) {
    const auto n = size_t(s.grid.width);
    std::vector<double> moduli;
    for (size_t m : materials_of(c.spread, n))
        moduli.push_back(c.spread == Spread::each ? 1.54 * (1 + double(m) / double(n * n)) : modulus_of(m));
    s.material.modulus_map = moduli;
    s.precision = c.precision;
    s.time.duration = (steps + 1) * s.time.step; // the first output is at 0
    return s;
}

// Materials of the native march: the library's, at most native::most_materials.
std::shared_ptr<NativeMarch> native_of(const Scene& s, const Contender& c, int threads) {
    const auto n = size_t(s.grid.width);
    const SceneMaps m = maps(s);
    NativeMarch::Skin skin{.n = s.grid.width,
                           .pressure = {m.pressure.begin(), m.pressure.end()},
                           .rest = {m.rest_curvature.begin(), m.rest_curvature.end()}};
    for (size_t k : materials_of(c.spread, n)) skin.material.push_back(int(k));
    for (size_t k = 0; k < (c.spread == Spread::uniform ? 1 : 4); ++k)
        skin.step_of_material.push_back(
            native::exact_step<float>(modulus_of(k), s.material.viscosity.value_or(1), s.time.step));
    return std::make_shared<NativeMarch>(std::move(skin), threads);
}

std::vector<native::Envelope> envelope_of(const Scene& s, int steps) {
    std::vector<native::Envelope> all;
    const double rise = s.time.step / s.load.envelope.rise;
    for (int i = 0; i < steps; ++i) all.push_back({.start = float(i * rise), .rise = float(rise)});
    return all;
}

// The greatest error of the native march's traces by the greatest value of each quantity, against the library in
// double.
std::array<double, 6> errors_of_native(const Contender& c, int threads) {
    constexpr int n = 512, steps = 20;
    Contender in_double = c;
    in_double.precision = Precision::f64;
    const Scene s = with_contender(scene_of(n), in_double, steps);
    const Result r = run(s, Device::cpu());
    const std::vector<native::Statistics> found = native_of(s, c, threads)->run(envelope_of(s, steps));
    std::array<double, 6> errors{NAN, NAN, NAN, NAN, NAN, NAN};
    for (size_t q = 0; q < 5; ++q) {
        const Trace& t = r.traces[q];
        double worst = 0, largest = 0;
        for (size_t i = 0; i < found.size(); ++i) {
            const native::Statistics& f = found[i];
            const double off[] = {f.sum[q] / (n * n) - t.mean[i + 1], double(f.least[q]) - t.min[i + 1],
                                  double(f.greatest[q]) - t.max[i + 1]};
            for (double x : off) worst = std::isfinite(x) ? std::max(worst, std::abs(x)) : INFINITY;
            largest = std::max({largest, std::abs(t.min[i + 1]), std::abs(t.max[i + 1])});
        }
        errors[q] = worst / largest;
    }
    return errors;
}

Measurement row_of(const Bench& bench, const Contender& c, int n) {
    Measurement r = bench.cpu(c.workload, n, bench.cores);
    r.model = "march";
    r.precision = name(c.precision);
    r.steps = c.steps;
    return r;
}

Measurement native_row(const Bench& bench, const Contender& c, int n, int steps) {
    Measurement r = row_of(bench, c, n);
    r.backend = r.driver = "native";
    r.exact = false;
    r.steps = steps;
    r.errors = errors_of_native(c, bench.cores);
    for (size_t q = 0; q < 5; ++q)
        if (!(r.errors[q] <= peer_error)) r.status = "wrong";
    return r;
}

} // namespace

void marches(Bench& bench) {
    const int n = bench.quick ? 512 : 2048, native_steps = 100;
    const Scene base = scene_of(n);
    std::vector<Measurement> rows;
    std::vector<std::function<double()>> work;
    for (const Contender& c : contenders) {
        const bool each = c.spread == Spread::each; // takes seconds to prepare on a whole grid
        rows.push_back(row_of(bench, c, each ? n / 2 : n));
        work.push_back(
            [s = with_contender(each ? scene_of(n / 2) : base, c, c.steps)] { return run(s, Device::cpu()).seconds; });
        if (c.precision != Precision::f32 || (c.spread != Spread::uniform && c.spread != Spread::patches)) continue;
        rows.push_back(native_row(bench, c, n, native_steps));
        work.push_back([march = native_of(base, c, bench.cores), steps = envelope_of(base, native_steps)] {
            return seconds_of([&] { march->run(steps); });
        });
    }
    const std::vector<Timing> timings = bench.paired(work, std::min(bench.runs, 3));
    for (size_t i = 0; i < rows.size(); ++i) {
        rows[i].wall = timings[i];
        bench.add(rows[i]);
    }
}

} // namespace bench
