// SPDX-License-Identifier: MIT
// What a march has on a device: its buffers, and a ring of result slots.
#pragma once

#include "host/core/vulkan/recording.hpp"
#include "host/core/vulkan/windows.hpp"
#include "host/lab/march/stepper.hpp"

namespace dermis::vulkan {

// The device buffers of a march, by name.
class MarchMemory {
  public:
    enum Name {
        rest_curvature,
        surface,
        pressure0,
        pressure1,
        state0,
        state1,
        responses, // the first of them
        curvature = responses + RESPONSE_MAPS,
        deformation,
        coefficients,
        material,
        invalid,
        names
    };

    MarchMemory(const plan::PreparedSkin&, const plan::Schedule&, const plan::Variant&);

    VkDeviceSize map_bytes() const { return map_; }
    VkDeviceSize bytes_of(int name) const;
    VkDeviceSize bytes() const; // sum over all buffers
    void allocate(Context&);
    // Records the state of a skin at rest. Responses of a wholly pressed grid begin as NaN, so that one which is read
    // before it is written shows.
    void clear(const Context&, VkCommandBuffer) const;

    Buffer& operator[](int name) { return buffers_[size_t(name)]; }
    BufferRange range(int name) const { return buffers_[size_t(name)].all(); }
    // Of curvature and deformation too, which stand behind the responses in both lists.
    static Name response(int quantity) { return Name(responses + quantity - QUANTITY_SA1); }

  private:
    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    const plan::Variant variant_;
    const VkDeviceSize map_;
    std::vector<Buffer> buffers_;
};

// A ring of result slots: the device reduces each responding step into a slot, and the host reads the slots after a
// submission.
class Results {
  public:
    // Chooses the number of slots.
    Results(Context&, const plan::PreparedSkin&, const plan::Schedule&);

    size_t slots() const { return slots_; }
    VkDeviceSize bytes() const { return slots_ * slot_bytes_; }
    // Makes buffers and kernel. memory: allocated before; windows: the row windows of the kernel `press`.
    void allocate(Context&, const plan::Variant&, const MarchMemory& memory, const std::vector<RowWindow>& windows);
    void clear(const Context&, VkCommandBuffer) const;

    // Records the reduction of the wanted maps at the end of a step that wrote state 0 or 1. Returns the number of
    // dispatches.
    int record(Recording&, const plan::Step&, int state);
    bool full() const { return steps_.size() == slots_; }
    // Gives the sink a sample of each step recorded since the last call, after the submission.
    void hand_over(const plan::Stepper::Sink&);

  private:
    enum Map { state0, state1, responses, maps = responses + RESPONSE_MAPS }; // the maps that are reduced
    size_t probes() const { return schedule_.points.size(); }
    size_t tiles() const { return size_t(skin_.height()) * size_t(skin_.tiles); }

    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    VkDeviceSize slot_bytes_;
    size_t slots_ = 1;
    int planes_ = 1; // number of planes of a state
    std::vector<RowWindow> windows_;
    std::unique_ptr<Buffer> summaries_, probe_cells_;
    std::unique_ptr<Kernel> reduce_;
    std::vector<plan::Step> steps_; // the steps that have a slot, in order
};

} // namespace dermis::vulkan
