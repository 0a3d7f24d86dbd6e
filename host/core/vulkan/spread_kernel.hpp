// SPDX-License-Identifier: MIT
// The kernels `halve` and `spread` over memory of the caller's: they spread the signals of classes to their depths, and
// answer there.
#pragma once

#include "host/core/model/streamed_skin.hpp"
#include "host/core/vulkan/recording.hpp"

#include <deque>

namespace dermis::vulkan {

class SpreadKernel {
  public:
    struct Maps {
        BufferRange scratch, weights, rest_curvature, response;
        BufferRange pads; // the list of pads of a press; any range for a single skin
    };
    // pads_of_group: the list of pads ends with a workgroup of so many. Throws Error::bad_input for maps beyond the
    // limits of the device.
    SpreadKernel(Pipelines&, const model::StreamedSkin&, const model::ResponseLayout&, size_t pads_of_group,
                 uint32_t max_bindings);
    // Floats that presses work in, zeros at first; `press` writes the signal of a class from signal() on.
    VkDeviceSize scratch_bytes() const { return floats_ * sizeof(float); }
    VkDeviceSize signal(int quantity) const { return VkDeviceSize(signal_[size_t(quantity)]) * sizeof(float); }
    const std::vector<float>& weights() const { return weights_; } // of all levels
    void bind(size_t binding, const Maps&);
    // Records what follows a press of so many pads. own: see PressKernel::record().
    void record(VkCommandBuffer, size_t binding, uint32_t pads, Recording* own) const;
    double work_of_pad() const { return work_; }
    bool copies() const { return !picks_.empty(); } // a press ends with a copy

  private:
    struct Dispatch { // of one class
        const Kernel* kernel;
        f32::SpreadConstants constants;
        double work_of_row;
    };
    f32::NodeMap map_of(const model::SpreadLevel&, int first) const;
    int take(const model::SpreadLevel&);
    int pick(const model::StreamedSkin&, const model::ResponseLayout&, int quantity);
    const Kernel& kernel_of(const Module&, int radius, bool coarser, bool answers);
    void plan(const model::StreamedSkin&, int quantity, int response);
    void add(size_t pass, const Kernel&, const f32::SpreadConstants&, int radius);

    Pipelines& pipelines_;
    const DeviceTable& device_;
    const uint32_t max_bindings_;
    const int stencil_, edges_, pads_;
    std::array<int, 3> group_; // size of a workgroup
    size_t floats_ = 0;
    std::array<int, REDUCED_MAPS> signal_{}; // by quantity
    std::vector<float> weights_;
    std::deque<std::pair<std::vector<uint32_t>, Kernel>> kernels_; // by their specialization
    std::vector<std::vector<Dispatch>> passes_;                    // one after another
    double work_ = 0;
    std::vector<VkBufferCopy> picks_; // of sites, from fields in the scratch memory to the response
    std::vector<std::pair<BufferRange, BufferRange>> bound_; // by binding: both
};

} // namespace dermis::vulkan
