// SPDX-License-Identifier: MIT
// What the simulator computes on its device by itself: pressure before the skin, spikes behind it. No dermis here.
#pragma once

#include "gpu.hpp"

#include <array>

constexpr int in_flight = 3; // frames; frame n has slot n % 3

struct Patch {
    int width, height, pitch; // cells
};

struct Afferents {
    int fa1_first, fa1_count, sa1_first, sa1_count; // floats of a response
};

// As in spikes.comp.
struct Reading {
    float response;
    uint32_t spikes;
};

class Simulator {
  public:
    using Buffers = std::array<Buffer, in_flight>; // of each slot

    // pressures: also to be copied from.
    Simulator(Gpu&, const Patch&, const Afferents&, const Buffers& pressures, const Buffers& responses);

    void record_pressure(VkCommandBuffer, int slot, double now) const;
    void record_spikes(VkCommandBuffer, int slot, double dt) const; // they go on from slot to slot
    void record_readback(VkCommandBuffer, int slot) const;

    // Once the frame is done.
    std::vector<float> pressure(int slot) const; // width*height
    const Reading* readings(int slot) const {
        return static_cast<const Reading*>(readings_[slot].data);
    } // FA1, then SA1

  private:
    const Patch patch_;
    const Afferents afferents_;
    const uint32_t all_; // afferents
    const Shader indenter_, spikes_;
    const Buffers pressures_;
    Buffers seen_, readings_;
    std::array<VkDescriptorSet, in_flight> press_{}, fire_{};
};
