// SPDX-License-Identifier: MIT
// A ring of results: each responding step is reduced on the device into a slot, and full slots are handed over.
#pragma once

#include "host/plan/stepper.hpp"
#include "host/vulkan/march_memory.hpp"

namespace dermis::vulkan {

class Results {
  public:
    // As many slots as are good for a submission of this grid.
    Results(Context&, const plan::PreparedSkin&, const plan::Schedule&);

    size_t slots() const { return slots_; }
    VkDeviceSize bytes() const { return slots_ * slot_bytes_; }
    // Buffers and kernel; `memory` is allocated. windows: those of the kernel `press`.
    void allocate(Context&, const plan::Variant&, const MarchMemory& memory, const std::vector<RowWindow>& windows);
    void clear(const Context&, VkCommandBuffer) const;

    // Reduces what is wanted at the end of a step; `state` is 0 or 1. Returns the dispatches.
    int record(VkCommandBuffer, const plan::Step&, int state);
    bool full() const { return kept_.size() == slots_; }
    // After the submission: a sample for each step recorded since the last time.
    void hand_over(const plan::Stepper::Sink&);

  private:
    enum Map { state0, state1, sa1, sa2, fa1, fa2, maps }; // what is reduced
    size_t probes() const { return schedule_.points.size(); }
    size_t tiles() const { return size_t(skin_.height()) * size_t(skin_.tiles); }

    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    VkDeviceSize slot_bytes_;
    size_t slots_ = 1;
    int planes_ = 1; // of a state
    std::vector<RowWindow> windows_;
    std::unique_ptr<Buffer> summaries_, probe_cells_;
    std::unique_ptr<Kernel> reduce_;
    std::vector<plan::Step> kept_; // whose results stand in the ring
};

} // namespace dermis::vulkan
