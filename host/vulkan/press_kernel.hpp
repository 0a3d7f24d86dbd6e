// SPDX-License-Identifier: MIT
// The kernel `press` over memory of the caller's, one row window after another.
#pragma once

#include "host/vulkan/windows.hpp"

namespace dermis::vulkan {

// The kernel `press` as this device runs it.
Module press_module_for(const DeviceTable&);

class PressKernel {
  public:
    // In a batch the first five, but for the rest curvature, and the responses are those of all pads.
    struct Maps {
        BufferRange pressure_from, pressure_to, rest_curvature, state_from, state_to;
        std::array<BufferRange, RESPONSE_MAPS> response; // any small range for a response that is not asked for
        BufferRange coefficients, material, invalid;     // any range for the first two if the material is uniform
    };
    PressKernel(Pipelines&, const plan::PreparedSkin&, const plan::Variant&, const plan::PressedBox&,
                uint32_t max_bindings);
    void bind(size_t binding, const Maps&);
    // pads: the length of the list, of a batch.
    void record(VkCommandBuffer, size_t binding, const f32::Constants&, uint32_t pads = 1) const noexcept;
    const std::vector<RowWindow>& windows() const { return windows_; }

  private:
    struct Group { // size of a workgroup
        int x, y;
    };
    static Group group_of(const plan::PreparedSkin&, const plan::Variant&);

    const plan::Variant variant_;
    const plan::PressedBox pressed_;
    const int pitch_;
    const Group group_;
    std::vector<RowWindow> windows_;
    Kernel kernel_;
};

} // namespace dermis::vulkan
