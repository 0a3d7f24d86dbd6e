// SPDX-License-Identifier: MIT
// Frames of a skin of one element and of several in series, in the same rounds.
#include "bench/bench.hpp"
#include "bench/frames.hpp"
#include "bench/skins.hpp"
#include "host/core/cpu/stream.hpp"
#include "host/core/embedding/backend.hpp"

#include <deque>

namespace bench {

using namespace dermis;

namespace {

// A skin's frames, and what steps them.
struct Contender {
    Contender(int n, int elements, bool spring) : scene(n, chain_of(elements, spring)) {
        for (int i = 0; i < 4; ++i) responses.emplace_back(scene.cells());
    }
    const FrameScene scene;
    std::vector<Floats> responses;
    std::unique_ptr<cpu::FramePress> cpu;
    std::unique_ptr<VulkanFrames> device;
    size_t frame = 0;

    void press() {
        float* to[RESPONSE_MAPS];
        for (size_t i = 0; i < RESPONSE_MAPS; ++i) to[i] = responses[i].data();
        cpu->press({scene.dt}, scene.frames[frame % 4].data(), scene.frames[(frame + 1) % 4].data(), to);
        ++frame;
    }
};

} // namespace

void chains(Bench& bench) {
    const int n = bench.quick ? 1024 : 2048, presses = 4;
    for (bool on_device : {false, true}) {
        if (on_device && !bench.vulkan) continue;
        std::deque<Contender> contenders;
        std::vector<Measurement> rows;
        std::vector<std::function<double()>> work;
        for (const auto& [elements, spring] : {std::pair{1, false}, {2, false}, {3, false}, {3, true}, {8, false}}) {
            Contender& c = contenders.emplace_back(n, elements, spring);
            if (on_device)
                c.device = std::make_unique<VulkanFrames>(c.scene, vulkan::context_of(*bench.vulkan->impl().backend),
                                                          VulkanFrames::Shader::press);
            else c.cpu = std::make_unique<cpu::FramePress>(c.scene.streamed, bench.cores);
            Measurement& r =
                rows.emplace_back(on_device ? bench.on_vulkan("chains", n) : bench.cpu("chains", n, bench.cores));
            r.model = "march";
            r.method = "exact-" + std::to_string(elements) + (spring ? "-spring" : "");
            r.precision = "f32";
            r.steps = presses;
            r.bytes_per_cell = 36 + 8 * elements + (spring ? 8 : 0); // of each element, the integral, the spring's rate
            work.push_back([&c] {
                return seconds_of([&] {
                    if (c.device) c.device->press(presses);
                    for (int i = 0; !c.device && i < presses; ++i) c.press();
                });
            });
        }
        const std::vector<Timing> timings = bench.paired(work, 3 * bench.runs);
        for (size_t i = 0; i < rows.size(); ++i) {
            rows[i].wall = timings[i];
            bench.add(rows[i]);
        }
    }
}

} // namespace bench
