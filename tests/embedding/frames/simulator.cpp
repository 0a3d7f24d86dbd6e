// SPDX-License-Identifier: MIT
#include "simulator.hpp"

#include "indenter_spv.h"
#include "spikes_spv.h"

#include <cmath>

namespace {

// As in indenter.comp and spikes.comp.
struct Indenter {
    Patch patch;
    float x, y, radius, peak;
};
struct Spikes {
    Afferents afferents;
    float fa1_gain, sa1_gain, dt;
};

} // namespace

Simulator::Simulator(Gpu& gpu, const Patch& patch, const Afferents& afferents, const Buffers& pressures,
                     const Buffers& responses)
    : patch_(patch), afferents_(afferents), all_(uint32_t(afferents.fa1_count + afferents.sa1_count)),
      indenter_(gpu.shader(indenter_spv, sizeof indenter_spv, 1, sizeof(Indenter))),
      spikes_(gpu.shader(spikes_spv, sizeof spikes_spv, 3, sizeof(Spikes))), pressures_(pressures) {
    const VkBufferUsageFlags storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const Buffer charges = gpu.buffer(all_ * sizeof(float), storage, Gpu::Place::device);
    for (int i = 0; i < in_flight; ++i) {
        seen_[i] = gpu.buffer(pressures[i].bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Gpu::Place::host);
        readings_[i] = gpu.buffer(all_ * sizeof(Reading), storage, Gpu::Place::host);
        press_[i] = gpu.bind(indenter_, {pressures[i]});
        fire_[i] = gpu.bind(spikes_, {responses[i], charges, readings_[i]});
    }
}

void Simulator::record_pressure(VkCommandBuffer commands, int slot, double now) const {
    const float peak = 2e4f * std::abs(float(std::sin(5 * now))); // Pa
    const Indenter push{patch_, float(60 + 100 * now), float(patch_.height) / 2, 40, peak};
    Gpu::dispatch(commands, indenter_, press_[slot], push, uint32_t(patch_.width + 15) / 16,
                  uint32_t(patch_.height + 3) / 4);
}

void Simulator::record_spikes(VkCommandBuffer commands, int slot, double dt) const {
    Gpu::dispatch(commands, spikes_, fire_[slot], Spikes{afferents_, 50, 500, float(dt)}, (all_ + 63) / 64);
}

void Simulator::record_readback(VkCommandBuffer commands, int slot) const {
    Gpu::barrier(commands, shaders, copies | host_reads);
    const VkBufferCopy all{0, 0, pressures_[slot].bytes};
    vkCmdCopyBuffer(commands, pressures_[slot].handle, seen_[slot].handle, 1, &all);
    Gpu::barrier(commands, copies, host_reads);
}

std::vector<float> Simulator::pressure(int slot) const {
    std::vector<float> cells;
    for (int y = 0; y < patch_.height; ++y) {
        const float* row = static_cast<const float*>(seen_[slot].data) + y * patch_.pitch;
        cells.insert(cells.end(), row, row + patch_.width);
    }
    return cells;
}
