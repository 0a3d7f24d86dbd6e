// SPDX-License-Identifier: MIT
// The kernel `press` over memory of the caller's, one row window after another.
#pragma once

#include "host/core/vulkan/recording.hpp"
#include "host/core/vulkan/windows.hpp"

namespace dermis::vulkan {

// The kernel `press` as this device runs it. signals: the variant that makes these.
Module press_module_for(const DeviceTable&, bool signals = false);

class PressKernel {
  public:
    // In a batch, pressures, states and responses are the pads' one after another; the other ranges are shared by all
    // pads.
    struct Maps {
        BufferRange pressure_from, pressure_to, rest_curvature, state_from, state_to;
        std::array<BufferRange, RESPONSE_MAPS> response; // any small range for a response that is not asked for
        BufferRange coefficients, material, invalid;     // any range for the first two if the material is uniform
    };
    PressKernel(Pipelines&, const model::PreparedSkin&, const model::Variant&, const model::PressedBox&,
                uint32_t max_bindings);
    void bind(size_t binding, const Maps&);
    size_t pads_of_group() const { return size_t(group_.z); }
    // pads: the number of pads to press; their list is filled up to whole workgroups with entries of no pad. own: the
    // library's recording of this command buffer, to which the work of each window is added; null where the command
    // buffer is a host's.
    void record(VkCommandBuffer, size_t binding, const f32::Constants&, uint32_t pads, Recording* own) const;
    double work_of_pad() const { return work_of(windows_.front()) * double(windows_.size()); } // the most
    const std::vector<RowWindow>& windows() const { return windows_; }

  private:
    struct Group { // size of a workgroup
        int x, y, z;
    };
    static Group group_of(const model::PreparedSkin&, const model::Variant&, const model::PressedBox&);
    double work_of(const RowWindow& window) const {
        return double(numbers_of_press(variant_)) * columns_ * window.rows();
    }

    const model::Variant variant_;
    const int pitch_, columns_; // columns_: the number of columns that are pressed
    const Group group_;
    std::vector<RowWindow> windows_;
    Kernel kernel_;
};

} // namespace dermis::vulkan
