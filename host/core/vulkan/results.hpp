// SPDX-License-Identifier: MIT
// A ring of result slots: the device reduces each responding step into a slot, and the host reads the slots after a
// submission.
#pragma once

#include "host/core/vulkan/march_memory.hpp"
#include "host/core/vulkan/recording.hpp"

namespace dermis::vulkan {

class Results {
  public:
    // Chooses the number of slots.
    Results(Context&, const plan::MarchPlan&);

    size_t slots() const { return slots_; }
    VkDeviceSize bytes() const { return slots_ * slot_bytes_; }
    // Makes buffers and kernel. memory: allocated before; windows: the row windows of the kernel `press`.
    void allocate(Context&, const MarchMemory& memory, const std::vector<RowWindow>& windows);
    void clear(const Context&, VkCommandBuffer) const;

    // Records the reduction of the wanted maps at the end of a step that wrote state 0 or 1. Returns the number of
    // dispatches.
    int record(Recording&, plan::Sample&, int state);
    // Fills the sample of each step recorded since the last call, after the submission.
    void hand_over();

  private:
    enum Map { state0, state1, responses, maps = responses + RESPONSE_MAPS }; // the maps that are reduced
    size_t probes() const { return plan_.points.size(); }
    size_t tiles() const { return size_t(plan_.skin.height()) * size_t(plan_.skin.tiles); }

    const plan::MarchPlan plan_;
    VkDeviceSize slot_bytes_;
    size_t slots_ = 1;
    std::vector<RowWindow> windows_;
    std::unique_ptr<Buffer> summaries_, probe_cells_;
    std::unique_ptr<Kernel> reduce_;
    std::vector<plan::Sample*> samples_; // of the steps that have a slot, in order
};

} // namespace dermis::vulkan
