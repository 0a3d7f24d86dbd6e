// SPDX-License-Identifier: MIT
// The device buffers of a march, by name.
#pragma once

#include "host/core/model/stream.hpp"
#include "host/core/vulkan/context.hpp"
#include "host/core/vulkan/windows.hpp"

namespace dermis::vulkan {

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

    explicit MarchMemory(const plan::MarchPlan& plan) : plan_(plan), map_(plan.skin.padded_cells() * sizeof(float)) {}

    VkDeviceSize map_bytes() const { return map_; }
    VkDeviceSize bytes_of(int name) const;
    VkDeviceSize bytes() const; // sum over all buffers
    void allocate(Context&);
    // Records the state of a skin at rest. Responses of a wholly pressed grid begin as NaN, so that one which is read
    // before it is written shows.
    void clear(const Context&, VkCommandBuffer) const;

    Buffer& operator[](int name) { return buffers_[size_t(name)]; }
    BufferRange range(int name) const { return buffers_[size_t(name)].all(); }
    static Name response(int quantity) { return Name(responses + quantity - QUANTITY_SA1); }

  private:
    const plan::MarchPlan plan_;
    const VkDeviceSize map_;
    std::vector<Buffer> buffers_;
};

} // namespace dermis::vulkan
