// SPDX-License-Identifier: MIT
// Workloads that are whole scenes, and error against time.
#include "bench/bench.hpp"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

namespace bench {

using namespace dermis;

void study(Bench& bench) {
    std::vector<Scene> nine;
    for (Surface::Kind surface : {Surface::Kind::flat, Surface::Kind::wave, Surface::Kind::spiral})
        for (Load::Kind load : {Load::Kind::circular, Load::Kind::point, Load::Kind::linear}) {
            Scene s;
            s.surface.kind = surface;
            s.load.kind = load;
            s.output.probes = {{75, 75}, {85, 85}, {60, 80}, {37, 37}, {112, 112}};
            nine.push_back(with_maps(s));
        }
    const Device cpu = Device::cpu();
    std::vector<Measurement> rows;
    std::vector<std::function<double()>> work;
    for (bool marched : {false, true}) {
        for (Scene& s : nine)
            if (marched) s.model = Model::march, s.precision = Precision::f32;
        Measurement& r = rows.emplace_back(bench.cpu("study", 150, bench.cores));
        r.model = marched ? "march" : "moments";
        r.precision = marched ? "f32" : "f64";
        r.steps = 9 * 1000;
        work.push_back([nine, cpu] {
            return seconds_of([&] {
                for (const Scene& s : nine) run(s, cpu);
            });
        });
    }
    const int steps = bench.quick ? 100 : 1000; // of one scene, which stands for all nine
    for (const Peers::Peer& peer : bench.peers->prepare(fmt::format("study {}", steps))) {
        Measurement& r = rows.emplace_back(bench.of_peer(peer, "study", 150));
        r.model = peer.method;
        r.method = "euler";
        r.precision = "f64";
        r.stencil = "published";
        r.steps = steps;
        work.push_back([&bench, peer] { return bench.peers->seconds(peer, 1); });
    }
    const std::vector<Timing> timings = bench.paired(work, bench.runs);
    for (size_t i = 0; i < rows.size(); ++i) {
        rows[i].wall = timings[i];
        bench.add(rows[i]);
    }
}

void population(Bench& bench) {
    const int n = bench.quick ? 1024 : 4096;
    for (bool uniform : {true, false}) {
        Scene hand; // 50 um cells
        hand.grid = {n, n, 50e-6};
        hand.surface.relief = 5e-5;
        hand.material = {.modulus = 20e3, .viscosity = 1e3, .thickness = 1e-3, .curvature_length = 1e-5};
        hand.load.intensity = 1e4;
        hand = with_maps(hand);
        if (!uniform) { // different materials have no closed form, so that cells are stepped
            std::vector<double>& modulus = hand.material.modulus_map.edit();
            for (int i = 0; i < n * n; ++i) modulus.push_back(20e3 * (1 + (i / 512) % 4));
        }
        hand.time = {0.01, 0.5};
        Scene field = hand;
        field.precision = Precision::f32;
        field.model = Model::march;
        hand.sites = dermis::population(hand.grid);
        hand.output.traces.clear();
        for (bool sites : {true, false}) {
            Measurement r = bench.cpu("population", n, bench.cores);
            r.model = sites ? "sites" : "march";
            r.precision = sites ? "f64" : "f32";
            r.method = uniform ? "exact" : "exact-materials";
            r.receptors = sites ? static_cast<long long>(hand.sites.size()) : 0;
            r.steps = 50;
            r.wall = bench.paired({[&] { return run(sites ? hand : field, Device::cpu()).seconds; }},
                                  std::min(bench.runs, 3))[0];
            bench.add(r);
        }
    }
}

// Compares the kernel `sites` on a population with the kernel `press` on every cell, frame by frame.
void streamed_population(Bench& bench) {
    const int n = bench.quick ? 512 : 2048;
    SkinDescription hand;
    hand.grid = {n, n, 50e-6};
    hand.surface.relief = 5e-5;
    hand.material = {.modulus = 20e3, .viscosity = 1e3, .thickness = 1e-3, .curvature_length = 1e-5};
    SkinDescription every = hand;
    hand.sites = dermis::population(hand.grid);
    SkinOptions plain;
    plain.precision = Precision::f32;
    const std::vector<float> frame(size_t(n) * size_t(n), 1e4f);
    for (bool device : {false, true}) {
        if (device && !bench.vulkan) continue;
        std::vector<std::shared_ptr<Skin>> skins;
        std::vector<std::function<double()>> work;
        constexpr int presses = 5;
        for (const SkinDescription* d : {&hand, &every}) {
            skins.push_back(std::make_shared<Skin>(device ? *bench.vulkan : Device::cpu(), *d, plain));
            work.push_back([&frame, skin = skins.back()] {
                return seconds_of([&] {
                    for (int i = 0; i < presses; ++i) skin->press(frame, 0.001);
                });
            });
        }
        const std::vector<Timing> timings = bench.paired(work, bench.runs);
        for (int fields = 0; fields < 2; ++fields) {
            Measurement r =
                device ? bench.on_vulkan("population-frames", n) : bench.cpu("population-frames", n, bench.cores);
            r.model = fields ? "march" : "sites";
            r.precision = "f32";
            r.receptors = fields ? 0 : static_cast<long long>(hand.sites.size());
            r.steps = presses;
            r.wall = timings[size_t(fields)];
            bench.add(r);
        }
    }
}

void materials(Bench& bench) {
    Scene s;
    const int n = bench.quick ? 512 : 2048;
    s.grid = {n, n, {}};
    s.surface.kind = Surface::Kind::wave;
    s.surface.noise = 0;
    s = with_maps(s);
    std::vector<Material> hundred;
    for (int i = 0; i < 100; ++i) hundred.push_back({.modulus = 1 + 0.01 * i, .viscosity = 1});
    const auto timings = bench.paired({[&] { return seconds_of([&] { run(s, Device::cpu()); }); },
                                       [&] { return seconds_of([&] { run(s, hundred, Device::cpu()); }); }},
                                      std::min(bench.runs, 5));
    for (int all = 0; all < 2; ++all) {
        Measurement r = bench.cpu(all ? "materials-100" : "materials-1", n, bench.cores);
        r.model = "moments";
        r.precision = "f64";
        r.steps = 1000;
        r.wall = timings[size_t(all)];
        bench.add(r);
    }
}

namespace {

constexpr double end = 2.56; // s

// A smooth and periodic scene with a known Laplacian of the continuum: waves of `wave` cells along each axis.
struct Smooth {
    int n;
    double k;
    explicit Smooth(int cells, int wave) : n(cells), k(2 * std::numbers::pi / wave) {}
    double surface(int x, int y) const { return std::sin(k * x) * std::sin(k * y); }
    double pressure(int x, int y) const { return 1 + 0.5 * std::cos(k * x) * std::cos(k * y); }
    std::vector<double> map(double (Smooth::*of)(int, int) const) const {
        std::vector<double> m;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) m.push_back((this->*of)(x, y));
        return m;
    }
    Scene scene() const {
        Scene s;
        s.grid = {n, n, {}};
        s.edges = Edges::periodic;
        s.surface.kind = Surface::Kind::map;
        s.surface.map = map(&Smooth::surface);
        s.load.kind = Load::Kind::map;
        s.load.map = map(&Smooth::pressure);
        s.material.modulus = 1.54;
        s.material.viscosity = 1;
        s.time.duration = end;
        return s;
    }
};

// The greatest error over cells and three instants, divided by the greatest value. Strain and responses are compared
// with closed forms in time on the scene's own grid, curvature with the continuum's.
std::array<double, 6> errors_of(const Smooth& smooth, Scene s, const Device& device) {
    const std::vector<Quantity> all = {Quantity::strain, Quantity::sa1, Quantity::sa2,
                                       Quantity::fa1,    Quantity::fa2, Quantity::curvature};
    const double E = *s.material.modulus, eta = *s.material.viscosity, times[] = {end / 4, end / 2, 3 * end / 4};
    for (double t : times) s.output.fields.push_back({t, all});
    if (s.model == Model::moments) s.model = Model::maps;
    const Result r = run(s, device);
    Scene unit = s; // its rest curvature is L(p), by the same stencil
    unit.surface.map = s.load.map;
    const SceneMaps m = maps(s);
    const Map Lp = maps(unit).rest_curvature;
    std::array<double, 6> worst{}, largest{};
    for (const Field& f : r.fields) {
        const double decay = std::exp(-E / eta * f.at), g = -std::expm1(-E / eta * f.at) / E;
        const double scalar[] = {g, g, (f.at - eta * g) / E, decay / eta, -E / eta * decay / eta};
        const auto q = size_t(f.quantity);
        for (int y = 0; y < smooth.n; ++y)
            for (int x = 0; x < smooth.n; ++x) {
                const size_t i = size_t(y) * size_t(smooth.n) + size_t(x);
                const double p = m.pressure[i], C = m.rest_curvature[i] - g * Lp[i];
                const double k2 = 2 * smooth.k * smooth.k;
                double exact = 0;
                if (f.quantity == Quantity::curvature)
                    exact = -k2 * smooth.surface(x, y) + g * k2 * (smooth.pressure(x, y) - 1);
                else exact = p * scalar[q] * (f.quantity == Quantity::strain ? 1 : 1 + C);
                worst[q] = std::max(worst[q], std::abs(f.values[i] - exact));
                largest[q] = std::max(largest[q], std::abs(exact));
            }
    }
    for (size_t q = 0; q < 6; ++q) worst[q] /= largest[q];
    return worst;
}

struct Series {
    Model model = Model::march;
    Precision precision = Precision::f32;
    Method method = Method::exact;
    Stencil stencil = Stencil::five_point;
    double least_step = 0; // s
};

std::vector<Series> accuracy_series(const Bench& bench) {
    const double least = bench.quick ? 0.02 : 0.0025, longest = 0.64;
    std::vector<Series> all;
    for (Method m : {Method::euler, Method::crank_nicolson, Method::rk4, Method::exact})
        for (Precision p : {Precision::f32, Precision::f64})
            all.push_back({.precision = p, .method = m, .least_step = least});
    all.push_back({.precision = Precision::f32_compensated, .least_step = least});
    all.push_back({.stencil = Stencil::fourth_order, .least_step = longest});
    all.push_back({.model = Model::moments, .precision = Precision::f64, .least_step = least});
    return all;
}

void add_accuracy(Bench& bench, const Smooth& smooth, const Device& cpu, const Series& series, double step) {
    Scene s = smooth.scene();
    s.material.viscosity = 0.25; // dt/tau goes up to 3.9, where some methods are unstable
    s.model = series.model;
    s.precision = series.precision;
    s.method = series.method;
    s.stencil = series.stencil;
    s.time.step = step;
    Measurement r = bench.cpu("accuracy", smooth.n, bench.cores);
    r.model = name(series.model);
    r.precision = name(series.precision);
    r.method = name(series.method);
    r.stencil = series.stencil == Stencil::five_point ? "five-point" : "fourth-order";
    r.dt_over_tau = step * *s.material.modulus / *s.material.viscosity;
    r.steps = static_cast<long long>(std::llround(end / step));
    const auto whole = [&] { return seconds_of([&] { run(s, cpu); }); }; // maps too: a closed form has little else
    const auto measure = [&] {
        r.errors = errors_of(smooth, s, cpu);
        r.wall = bench.paired({whole}, std::min(bench.runs, 5))[0];
    };
    try {
        measure();
    } catch (const Error&) { // refused as unstable: its error is charted all the same
        r.status = "unstable";
        s.allow_unstable = true;
        measure();
    }
    bench.add(r);
}

} // namespace

void accuracy(Bench& bench) {
    const Smooth smooth(bench.quick ? 64 : 192, 16);
    const Device cpu = Device::cpu();
    for (const Series& series : accuracy_series(bench))
        for (double step = 0.64; step >= series.least_step; step /= 2) add_accuracy(bench, smooth, cpu, series, step);
}

} // namespace bench
