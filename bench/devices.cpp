// SPDX-License-Identifier: MIT
// A device by the number of cells: a press, beside the same memory moved alone, a march of traces, and receptors.
#include "bench/bench.hpp"
#include "host/core/embedding/backend.hpp"

#include <fmt/format.h>

namespace bench {

using namespace dermis;

namespace {

// Means and extremes of all five quantities.
void add_march(Bench& bench, int n, int steps) {
    Scene s;
    s.grid = {n, n, {}};
    s.load.kind = Load::Kind::linear;
    s.load.radius = n;
    s = with_maps(s);
    s.model = Model::march;
    s.precision = Precision::f32;
    s.time.duration = (steps + 1) * s.time.step; // the first output is at 0
    Measurement r = bench.on_vulkan("march-uniform", n);
    r.steps = steps;
    r.wall = bench.paired({[&] { return run(s, *bench.vulkan).seconds; }}, 3)[0];
    bench.add(r);
}

// Receptors of a fingertip, frame by frame: pressure in, responses out.
void add_sites(Bench& bench, int n, int presses) {
    SkinDescription hand;
    hand.grid = {n, n, 50e-6};
    hand.surface.relief = 5e-5;
    hand.material = {.modulus = 20e3, .viscosity = 1e3, .thickness = 1e-3, .curvature_length = 1e-5};
    hand.sites = population(hand.grid);
    SkinOptions options;
    options.precision = Precision::f32;
    Skin skin(*bench.vulkan, hand, options);
    const std::vector<float> frame(size_t(n) * size_t(n), 1e4f);
    Measurement r = bench.on_vulkan("population-frames", n);
    r.model = "sites";
    r.receptors = static_cast<long long>(hand.sites.size());
    r.steps = presses;
    r.wall = bench.paired({[&] {
                              return seconds_of([&] {
                                  for (int i = 0; i < presses; ++i) skin.press(frame, 0.001);
                              });
                          }},
                          bench.runs)[0];
    bench.add(r);
}

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
    limit("kernels declare round-to-nearest-even", used.rounds);
    limit("kernels read maps as texel buffers", used.texels);
}

} // namespace

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
