// SPDX-License-Identifier: MIT
// Workloads W1, W1s and W2: kernels against what the memory gives.
#include "bench/bench.hpp"
#include "bench/frames.hpp"
#include "host/cpu/stream.hpp"
#include "host/embedding/backend.hpp"
#include "host/reduced/moments.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace bench {

using namespace dermis;

namespace {

constexpr double frame_bytes = 44; // L(S), pressure before and now, strain and integral twice, four responses
constexpr double frame_flops = 62;

// The four responses after some frames, to the bit.
using Responses = std::array<std::vector<float>, 4>;

Responses after_frames(const FrameScene& scene, int threads, const simd::Isa& isa) {
    cpu::FramePress frames(scene.streamed, threads, isa);
    Responses r;
    for (auto& map : r) map.resize(scene.cells());
    for (size_t i = 0; i < 6; ++i)
        frames.press(scene.dt, scene.frames[i % 4].data(), scene.frames[(i + 1) % 4].data(),
                     {r[0].data(), r[1].data(), r[2].data(), r[3].data()});
    return r;
}

bool same(const Responses& a, const Responses& b) {
    for (size_t i = 0; i < 4; ++i)
        if (std::memcmp(a[i].data(), b[i].data(), a[i].size() * sizeof(float)) != 0) return false;
    return true;
}

} // namespace

void streamed_frames(Bench& bench) {
    for (int n : bench.quick ? std::vector{512, 2048} : std::vector{512, 2048, 4096}) {
        const FrameScene scene(n);
        const int frames = std::max(1, int(4e7 / n / n));
        const Responses plain = after_frames(scene, 1, simd::plain);
        const std::vector<Floats> out = [&] {
            std::vector<Floats> maps;
            for (int i = 0; i < 4; ++i) maps.emplace_back(scene.cells());
            return maps;
        }();
        std::vector<Measurement> rows;
        std::vector<std::function<double()>> work;
        std::vector<std::unique_ptr<cpu::FramePress>> streams;
        const std::vector<int> threads = bench.cores > 1 ? std::vector{1, bench.cores} : std::vector{1};
        for (int t : threads) { // what memory gives, in the same rounds
            rows.push_back(bench.cpu("copy", n, t));
            work.push_back([memory = std::make_shared<Limits>(t)] { return memory->copy(); });
        }
        const size_t limits = rows.size();
        for (const simd::Isa* isa : simd::isas())
            for (int t : threads)
                for (bool all : {true, false}) {
                    if (!all && isa != &simd::best()) continue;
                    Measurement r = bench.cpu(all ? "W1" : "W1s", n, t);
                    r.backend = std::string("cpu-") + isa->name;
                    r.model = "march";
                    r.precision = "f32";
                    r.bytes_per_cell = all ? frame_bytes : frame_bytes - 12;
                    r.flops_per_cell = all ? frame_flops : frame_flops - 17;
                    r.exact = same(plain, after_frames(scene, t, *isa));
                    if (!r.exact) r.status = "wrong";
                    rows.push_back(r);
                    cpu::FramePress& stream = *streams.emplace_back(std::make_unique<cpu::FramePress>(scene.streamed, t, *isa));
                    float* const kept[2][4] = {{nullptr, nullptr, out[2].data(), nullptr},
                                               {out[0].data(), out[1].data(), out[2].data(), out[3].data()}};
                    work.push_back([&scene, &stream, frames, to = std::to_array(kept[all])]() mutable {
                        float* const response[4] = {to[0], to[1], to[2], to[3]};
                        return seconds_of([&] {
                            for (size_t i = 0; i < size_t(frames); ++i)
                                stream.press(scene.dt, scene.frames[i % 4].data(), scene.frames[(i + 1) % 4].data(),
                                             response);
                        });
                    });
                }
        std::vector<std::unique_ptr<VulkanFrames>> devices;
        std::vector<std::shared_ptr<std::vector<double>>> gpu(rows.size());
        const int fewer = bench.vulkan && bench.vulkan->info().kind == "software" ? std::max(1, frames / 8) : frames;
        for (VulkanFrames::By by : {VulkanFrames::By::press, VulkanFrames::By::cell, VulkanFrames::By::moves}) {
            if (!bench.vulkan) continue;
            Measurement r = bench.on_vulkan("W1", n);
            if (by == VulkanFrames::By::cell) r.backend = "vulkan-cell";
            if (by == VulkanFrames::By::moves) r.backend = "vulkan-moves"; // what no kernel can beat
            r.bytes_per_cell = frame_bytes;
            r.flops_per_cell = by == VulkanFrames::By::moves ? 0 : frame_flops;
            VulkanFrames& device =
                *devices.emplace_back(std::make_unique<VulkanFrames>(scene, vulkan::context_of(*bench.vulkan->impl().backend), by));
            device.press(6);
            r.exact = by == VulkanFrames::By::moves ||
                      same(plain, {device.response(0), device.response(1), device.response(2), device.response(3)});
            if (!r.exact) r.status = "wrong";
            device.press(2); // states and frames are where they began
            rows.push_back(r);
            auto& stamps = *gpu.emplace_back(std::make_shared<std::vector<double>>());
            work.push_back(
                [&device, &stamps, fewer] { return seconds_of([&] { stamps.push_back(device.press(fewer)); }); });
        }
        const std::vector<Timing> timings = bench.paired(work, bench.runs);
        double copy[2] = {};
        for (size_t i = 0; i < limits; ++i) copy[i] = double(Limits::moved()) / timings[i].median / 1e9;
        double on_device = 0;
        if (!devices.empty()) {
            std::vector<double> seconds;
            for (int i = 0; i < 5; ++i) seconds.push_back(devices[0]->copy(4) / 4);
            on_device = 2 * double(scene.cells()) * sizeof(float) / timing_of(seconds).median / 1e9;
        }
        for (size_t i = limits; i < rows.size(); ++i) {
            Measurement& r = rows[i];
            const bool device = gpu.size() > i && gpu[i];
            r.steps = device ? fewer : frames;
            r.wall = timings[i];
            if (device) r.gpu_median = timing_of(*gpu[i]).median;
            r.against("copy", device ? on_device : copy[r.threads == 1 ? 0 : limits - 1]);
            bench.add(r);
        }
        if (devices.empty()) continue;
        Measurement record = bench.on_vulkan("W1-record", n); // what a frame costs the host beside its submission
        record.steps = 1;
        record.wall = bench.paired({[&] {
                                       devices[0]->press(fewer);
                                       return devices[0]->recording();
                                   }},
                                   bench.runs)[0];
        bench.add(record);
    }
}

void constant_map(Bench& bench) {
    for (int n : bench.quick ? std::vector{512, 2048} : std::vector{512, 2048, 4096}) {
        Scene s;
        s.grid = {n, n, {}};
        s.surface.kind = Surface::Kind::wave;
        s.surface.noise = 0;
        s.load.kind = Load::Kind::linear;
        s.load.radius = n;
        s.output.extremes = false;
        s = with_maps(s);
        const plan::PreparedRun run_of = plan::prepare_run(s);
        for (int t : {1, bench.cores}) {
            Measurement r = bench.cpu("W2", n, t);
            r.model = "moments";
            r.precision = "f64";
            r.steps = run_of.schedule.outputs;
            r.bytes_per_cell = 16 / double(r.steps); // surface and pressure, once
            double last = 0;
            r.wall = bench.paired({[&] {
                                      return seconds_of([&] {
                                          const auto& [skin, schedule] = run_of;
                                          const auto stepper = reduced::separable(
                                              skin, schedule, reduced::moments_of(skin, schedule, false, t), false,
                                              [&](auto&, const plan::Sample& sample) {
                                                  last += sample.totals[1].mean;
                                              });
                                          plan::Timeline timeline(schedule, skin);
                                          for (plan::Step step; timeline.next(step);) stepper->press(step);
                                      });
                                  }},
                                  bench.runs)[0];
            if (!std::isfinite(last)) r.status = "wrong";
            r.against("read", bench.read_GBs[t == 1 ? 0 : 1]);
            bench.add(r);
        }
        if (n > 512) continue;
        for (bool vulkan : {false, true}) {
            if (vulkan && !bench.vulkan) continue;
            Measurement r = vulkan ? bench.on_vulkan("W2", n) : bench.cpu("W2", n, bench.cores);
            r.model = "march";
            r.precision = "f32";
            Scene marched = s;
            marched.model = Model::march;
            marched.precision = Precision::f32;
            marched.time.duration = vulkan ? 1 : 10;
            r.steps = vulkan ? 100 : 1000;
            r.wall = bench.paired({[&] { return run(marched, vulkan ? *bench.vulkan : Device::cpu()).seconds; }},
                                  std::min(bench.runs, 3))[0];
            bench.add(r);
        }
    }
}

} // namespace bench
