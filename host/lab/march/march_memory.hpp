// SPDX-License-Identifier: MIT
// The device buffers of a march, by name.
#pragma once

#include "host/core/vulkan/context.hpp"
#include "host/core/vulkan/windows.hpp"
#include "host/lab/march/march.hpp"

namespace dermis::vulkan {

class MarchMemory {
  public:
    enum Name {
        rest_curvature,
        pressure0,
        pressure1,
        state0,
        state1,
        responses, // the first of them
        coefficients = responses + RESPONSE_MAPS,
        material,
        invalid,
        names
    };

    explicit MarchMemory(const model::MarchPlan& plan) : plan_(plan), map_(plan.skin.padded_cells() * sizeof(float)) {}

    VkDeviceSize map_bytes() const { return map_; }
    // A buffer that the run does not need is bound all the same, so it has 4 bytes.
    VkDeviceSize bytes_of(int name) const {
        constexpr VkDeviceSize unused = 4;
        const model::Variant& variant = plan_.variant;
        if (name >= responses && name < coefficients)
            return variant.wanted[size_t(name - responses + QUANTITY_SA1)] ? map_ : unused;
        switch (name) {
        case state0:
        case state1: return VkDeviceSize(variant.state().planes()) * map_;
        case pressure1: return variant.framed ? map_ : unused;
        case material: return variant.materials ? map_ : unused;
        case coefficients:
            return variant.tabled() ? (1 + variant.parabolic) * plan_.skin.materials.size() * sizeof(f32::Coefficients)
                                    : unused;
        case invalid: return sizeof(uint32_t);
        default: return map_;
        }
    }

    VkDeviceSize bytes() const { // sum over all buffers
        VkDeviceSize all = 0;
        for (int name = 0; name < names; ++name) all += bytes_of(name);
        return all;
    }

    void allocate(Context& context) {
        for (int name = 0; name < names; ++name)
            buffers_.emplace_back(context, bytes_of(name), Buffer::Location::device);
    }

    // Records the state of a skin at rest. Responses of a wholly pressed grid begin as NaN, so that one which is read
    // before it is written shows.
    void clear(const Context& context, VkCommandBuffer commands) const {
        const model::PressedBox &box = plan_.pressed, all = plan_.skin.whole();
        const bool whole =
            box.first_row == 0 && box.last_row == all.last_row && box.first_tile == 0 && box.last_tile == all.last_tile;
        constexpr uint32_t nan = 0xffffffff;
        for (int name = 0; name < names; ++name)
            context.calls().vkCmdFillBuffer(commands, buffers_[size_t(name)].handle(), 0, VK_WHOLE_SIZE,
                                            whole && name >= responses && name < coefficients ? nan : 0);
    }

    Buffer& operator[](int name) { return buffers_[size_t(name)]; }
    BufferRange range(int name) const { return buffers_[size_t(name)].all(); }
    static Name response(int quantity) { return Name(responses + quantity - QUANTITY_SA1); }

  private:
    const model::MarchPlan plan_;
    const VkDeviceSize map_;
    std::vector<Buffer> buffers_;
};

} // namespace dermis::vulkan
