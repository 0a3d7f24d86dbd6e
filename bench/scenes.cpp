// SPDX-License-Identifier: MIT
// Workloads that are whole scenes, and error against time.
#include "bench/skins.hpp"
#include "host/lab/reduced/moments.hpp"

#include <algorithm>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace bench {

using namespace dermis;

namespace {

// Runs a scene. The seconds are those of its steps, or of the whole run.
Contender ran(const Bench& bench, const Device& device, const char* workload, const Scene& s, long long steps,
              bool whole = false) {
    Measurement r = row_of(bench.on(device, workload, s.grid.width), name(*s.model), name(*s.precision), steps);
    return {r, [s, device, whole] {
                double seconds = 0;
                const double all = seconds_of([&] { seconds = run(s, device).seconds; });
                return whole ? all : seconds;
            }};
}

Scene in(Scene s, Model model, Precision precision) {
    s.model = model;
    s.precision = precision;
    return s;
}

// Waves under a line of pressure, as maps.
Scene waves_of(int n) {
    Scene s;
    s.grid = {n, n, {}};
    s.surface.kind = Surface::Kind::wave;
    s.surface.noise = 0;
    s.load.kind = Load::Kind::linear;
    s.load.radius = n;
    return with_maps(s);
}

} // namespace

void study(Bench& bench) {
    std::vector<Contender> all;
    for (const auto& [model, precision] : {std::pair{Model::moments, Precision::f64}, {Model::march, Precision::f32}}) {
        std::vector<Scene> nine;
        for (Surface::Kind surface : {Surface::Kind::flat, Surface::Kind::wave, Surface::Kind::spiral})
            for (Load::Kind load : {Load::Kind::circular, Load::Kind::point, Load::Kind::linear}) {
                Scene s;
                s.surface.kind = surface;
                s.load.kind = load;
                s.output.probes = {{75, 75}, {85, 85}, {60, 80}, {37, 37}, {112, 112}};
                nine.push_back(model == Model::march ? in(with_maps(s), model, precision) : with_maps(s));
            }
        all.push_back({row_of(bench.cpu("study", 150, bench.cores), name(model), name(precision), 9 * 1000), [nine] {
                           return seconds_of([&] {
                               for (const Scene& s : nine) run(s, Device::cpu());
                           });
                       }});
    }
    const int steps = bench.quick ? 100 : 1000; // of one scene, which stands for all nine
    Measurement like = row_of(bench.cpu("study", 150, 1), "", "f64", steps);
    like.stencil = "published";
    for (Contender& c : bench.of_peers(fmt::format("study {}", steps), like, 1)) {
        c.row.model = std::exchange(c.row.method, "euler");
        all.push_back(std::move(c));
    }
    bench.measure(std::move(all), bench.runs);
}

void population(Bench& bench) {
    const int n = bench.quick ? 1024 : 4096;
    for (bool uniform : {true, false}) {
        const SkinDescription skin = rectangle(n, n, 50e-6);
        Scene hand;
        hand.grid = skin.grid;
        hand.surface = skin.surface;
        hand.material = skin.material;
        hand.load.intensity = 1e4;
        hand = with_maps(hand);
        if (!uniform) { // different materials have no closed form, so that cells are stepped
            std::vector<double>& modulus = hand.material.modulus_map.edit();
            for (int i = 0; i < n * n; ++i) modulus.push_back(20e3 * (1 + (i / 512) % 4));
        }
        hand.time = {0.01, 0.5};
        Scene sites = hand;
        sites.sites = dermis::population(hand.grid);
        sites.output.traces.clear();
        for (const Scene& s : {sites, in(hand, Model::march, Precision::f32)}) {
            Measurement r = bench.cpu("population", n, bench.cores);
            r = s.model ? row_of(r, "march", "f32", 50) : row_of(r, "sites", "f64", 50);
            r.method = uniform ? "exact" : "exact-materials";
            r.receptors = static_cast<long long>(s.sites.size());
            bench.measure(
                r, [&s] { return run(s, Device::cpu()).seconds; }, std::min(bench.runs, 3));
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
    const auto row = [&](const char* workload) {
        return row_of(bench.cpu(workload, n, bench.cores), "moments", "f64", 1000);
    };
    bench.measure({{row("materials-1"), [&] { return seconds_of([&] { run(s, Device::cpu()); }); }},
                   {row("materials-100"), [&] { return seconds_of([&] { run(s, hundred, Device::cpu()); }); }}},
                  std::min(bench.runs, 5));
}

void constant_map(Bench& bench) {
    for (int n : bench.quick ? std::vector{512, 2048} : std::vector{512, 2048, 4096}) {
        Scene s = waves_of(n);
        s.output.extremes = false;
        const model::PreparedRun prepared = model::prepare_run(s);
        for (int threads : {1, bench.cores}) {
            double last = 0;
            const auto moments = [&] {
                const auto& [skin, schedule] = prepared;
                const auto stepper =
                    reduced::separable(skin, schedule, reduced::moments_of(skin, schedule, false, threads), false,
                                       [&](auto&, const model::Sample& sample) { last += sample.totals[1].mean; });
                model::Timeline timeline(schedule, skin);
                for (model::Step step; timeline.next(step);) stepper->press(step);
            };
            const Measurement r =
                row_of(bench.cpu("held-map", n, threads), "moments", "f64", prepared.schedule.outputs);
            bench.measure(
                r, [&] { return seconds_of(moments); }, bench.quick ? 5 : 15);
            if (!std::isfinite(last)) throw std::runtime_error("held-map: a mean is not finite");
        }
        if (n > 512) continue;
        std::vector<Device> devices;
        devices.push_back(Device::cpu(bench.cores));
        if (bench.vulkan) devices.push_back(*bench.vulkan);
        for (const Device& device : devices) {
            Scene marched = in(s, Model::march, Precision::f32);
            marched.time.duration = device.info().vulkan ? 1 : 10;
            const int steps = device.info().vulkan ? 100 : 1000;
            bench.measure({ran(bench, device, "held-map", marched, steps)}, std::min(bench.runs, 3));
        }
    }
}

namespace {

struct March {
    const char* workload;
    Spread spread;
    Precision precision = Precision::f32;
};

constexpr March all_marches[] = {{"march-uniform", Spread::uniform},
                                 {"march-uniform", Spread::uniform, Precision::f32_compensated},
                                 {"march-uniform", Spread::uniform, Precision::f64},
                                 {"march-patches-4", Spread::patches},
                                 {"march-random-4", Spread::random},
                                 {"march-random-1000", Spread::thousand},
                                 {"march-each", Spread::each}};

} // namespace

void marches(Bench& bench) {
    std::vector<Contender> all;
    for (const March& m : all_marches) {
        const bool each = m.spread == Spread::each; // takes seconds to prepare on a whole grid
        const int n = (bench.quick ? 512 : 2048) / (each ? 2 : 1), steps = each ? 60 : 100;
        Scene s = in(waves_of(n), Model::march, m.precision);
        s.load.envelope.kind = Envelope::Kind::ramp;
        s.load.envelope.rise = 20; // longer than any run: held loads have no new coefficients in any step
        s.time.duration = (steps + 1) * s.time.step; // the first output is at 0
        std::vector<double> moduli;
        for (size_t k : materials_of(m.spread, size_t(n)))
            moduli.push_back(1.54 *
                             (each ? 1 + double(k) / double(n) / n : 1 + 0.1 * double(k % 8) + 1e-3 * double(k)));
        s.material.modulus_map = moduli;
        all.push_back(ran(bench, Device::cpu(), m.workload, s, steps));
    }
    bench.measure(std::move(all), std::min(bench.runs, 3));
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
    Scene s = in(smooth.scene(), series.model, series.precision);
    s.material.viscosity = 0.25; // dt/tau goes up to 3.9, where some methods are unstable
    s.method = series.method;
    s.stencil = series.stencil;
    s.time.step = step;
    Contender c =
        ran(bench, cpu, "accuracy", s, std::llround(end / step), true); // maps too: a closed form has little else
    c.row.method = name(series.method);
    c.row.stencil = series.stencil == Stencil::five_point ? "five-point" : "fourth-order";
    c.row.dt_over_tau = step * *s.material.modulus / *s.material.viscosity;
    try {
        c.row.errors = errors_of(smooth, s, cpu);
    } catch (const Error&) { // refused as unstable: its error is charted all the same
        c.row.status = "unstable";
        s.allow_unstable = true;
        c.row.errors = errors_of(smooth, s, cpu);
        c.work = ran(bench, cpu, "accuracy", s, c.row.steps, true).work;
    }
    bench.measure({std::move(c)}, std::min(bench.runs, 5));
}

} // namespace

void accuracy(Bench& bench) {
    const Smooth smooth(bench.quick ? 64 : 192, 16);
    const Device cpu = Device::cpu();
    for (const Series& series : accuracy_series(bench))
        for (double step = 0.64; step >= series.least_step; step /= 2) add_accuracy(bench, smooth, cpu, series, step);
}

namespace {

// The version of a device, and every limit on which depends whether and how kernels run on it.
void print_limits(vulkan::Context& context) {
    const VkPhysicalDeviceProperties& p = context.physical().properties;
    const VkPhysicalDeviceLimits& l = p.limits;
    const vulkan::DeviceTable& used = context.pipelines().device();
    const auto version = [](uint32_t v) {
        return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(v), VK_API_VERSION_MINOR(v), VK_API_VERSION_PATCH(v));
    };
    fmt::print("Vulkan {}, driver version {} ({:#x}), vendor {:#x}, device {:#x}\n", version(p.apiVersion),
               version(p.driverVersion), p.driverVersion, p.vendorID, p.deviceID);
    const auto limit = [](const char* name, auto value) { fmt::print("{} = {}\n", name, value); };
    limit("maxPerStageDescriptorStorageBuffers", l.maxPerStageDescriptorStorageBuffers);
    limit("maxComputeWorkGroupInvocations", l.maxComputeWorkGroupInvocations);
    limit("maxComputeWorkGroupCount[0]", l.maxComputeWorkGroupCount[0]);
    limit("maxComputeWorkGroupCount[1]", l.maxComputeWorkGroupCount[1]);
    limit("maxStorageBufferRange", l.maxStorageBufferRange);
    limit("minStorageBufferOffsetAlignment", l.minStorageBufferOffsetAlignment);
    limit("maxTexelBufferElements", l.maxTexelBufferElements);
    limit("minTexelBufferOffsetAlignment", l.minTexelBufferOffsetAlignment);
    limit("maxPushConstantsSize", l.maxPushConstantsSize);
    limit("timestampPeriod", l.timestampPeriod);
    limit("bytes of device memory", context.heap_bytes());
    limit("kernels declare round-to-nearest-even", used.floats.rounds_to_even);
    limit("kernels declare that NaN and infinity are kept", used.floats.keeps_nans);
    limit("kernels read maps as texel buffers", used.texels);
}

// Means and extremes of all five quantities.
void add_march(Bench& bench, int n, int steps) {
    Scene s;
    s.grid = {n, n, {}};
    s.load.kind = Load::Kind::linear;
    s.load.radius = n;
    s = in(with_maps(s), Model::march, Precision::f32);
    s.time.duration = (steps + 1) * s.time.step; // the first output is at 0
    bench.measure({ran(bench, *bench.vulkan, "march-uniform", s, steps)}, 3);
}

// Receptors of a fingertip, frame by frame: pressure in, responses out.
void add_sites(Bench& bench, int n, int presses) {
    Press p{.model = "sites", .skin = rectangle(n, n, 50e-6), .method = "exact"};
    p.skin.sites = dermis::population(p.skin.grid);
    bench.measure({pressed(bench, *bench.vulkan, "population-frames", p, presses, frames_of(p, 1, 1e4f), 1)},
                  bench.runs);
}

} // namespace

// A device by the number of cells: a press, beside the same memory moved alone, a march of traces, and receptors.
void device_growth(Bench& bench) {
    if (!bench.vulkan) throw Error(Error::Code::no_device, "", "--only device: there is no Vulkan device");
    const DeviceInfo& info = bench.vulkan->info();
    fmt::print("{}, {}, {}\n", info.name, info.kind, info.driver);
    print_limits(*vulkan::context_of(*bench.vulkan->impl().backend));
    const bool software = info.kind == "software";
    for (int n : bench.quick ? std::vector{512, 1024, 2048} : std::vector{512, 1024, 2048, 4096, 8192}) {
        const auto attempt = [n](const char* what, const auto& measure) {
            try {
                measure();
            } catch (const Error& e) { // such as memory that the device does not have
                fmt::print("{:20} {} x {}: {}\n", what, n, n, e.what());
            }
        };
        attempt("press", [&] { streamed_frames_on_device(bench, n); });
        attempt("march-uniform", [&] { add_march(bench, n, software ? 5 : 100); });
        attempt("population-frames", [&] { add_sites(bench, n, software ? 2 : 20); });
    }
}

} // namespace bench
