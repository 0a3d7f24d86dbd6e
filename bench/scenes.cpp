// SPDX-License-Identifier: MIT
// Workloads that are whole scenes.
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
        for (int i = 0; i < n * n && !uniform;
             ++i) // different materials have no closed form, so that cells are stepped
            hand.material.modulus_map.edit().push_back(20e3 * (1 + (i / 512) % 4));
        hand.time = {0.01, 0.5};
        Scene sites = in(hand, Model::sites, Precision::f64);
        sites.sites = dermis::population(hand.grid);
        sites.output.traces.clear();
        for (const Scene& s : {sites, in(hand, Model::march, Precision::f32)}) {
            Contender c = ran(bench, Device::cpu(), "population", s, 50);
            c.row.method = uniform ? "exact" : "exact-materials";
            c.row.receptors = static_cast<long long>(s.sites.size());
            bench.measure({std::move(c)}, std::min(bench.runs, 3));
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
        std::vector<std::pair<Device, int>> marched; // and their numbers of steps
        if (n == 512) marched.push_back({Device::cpu(bench.cores), 1000});
        if (n == 512 && bench.vulkan) marched.push_back({*bench.vulkan, 100});
        for (const auto& [device, steps] : marched) {
            Scene march = in(s, Model::march, Precision::f32);
            march.time.duration = 0.01 * steps;
            bench.measure({ran(bench, device, "held-map", march, steps)}, std::min(bench.runs, 3));
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
        attempt("population-frames", [&] {
            measure_presses(bench, "population-frames", {*bench.vulkan}, {hand_of_sites(n)}, fixed(software ? 2 : 20),
                            bench.runs);
        });
    }
}

} // namespace bench
