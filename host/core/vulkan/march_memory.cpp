// SPDX-License-Identifier: MIT
#include "host/core/vulkan/march_memory.hpp"

namespace dermis::vulkan {

// A buffer that the run does not need is bound all the same, so it has 4 bytes.
VkDeviceSize MarchMemory::bytes_of(int name) const {
    constexpr VkDeviceSize unused = 4;
    const plan::Variant& variant = plan_.variant;
    if (name >= responses && name < curvature)
        return variant.wanted[size_t(name - responses + QUANTITY_SA1)] ? map_ : unused;
    switch (name) {
    case state0:
    case state1: return VkDeviceSize(variant.state().planes()) * map_;
    case surface:
    case curvature:
    case deformation: return plan_.derives ? map_ : unused;
    case pressure1: return variant.framed ? map_ : unused;
    case material: return variant.materials ? map_ : unused;
    case coefficients:
        return variant.tabled() ? (1 + variant.bent) * plan_.skin.materials.size() * sizeof(f32::Coefficients) : unused;
    case invalid: return sizeof(uint32_t);
    default: return map_;
    }
}

VkDeviceSize MarchMemory::bytes() const {
    VkDeviceSize all = 0;
    for (int name = 0; name < names; ++name) all += bytes_of(name);
    return all;
}

void MarchMemory::allocate(Context& context) {
    for (int name = 0; name < names; ++name) buffers_.emplace_back(context, bytes_of(name), Buffer::Location::device);
}

void MarchMemory::clear(const Context& context, VkCommandBuffer commands) const {
    const plan::PressedBox &box = plan_.pressed, all = plan_.skin.whole();
    const bool whole =
        box.first_row == 0 && box.last_row == all.last_row && box.first_tile == 0 && box.last_tile == all.last_tile;
    constexpr uint32_t nan = 0xffffffff;
    for (int name = 0; name < names; ++name)
        context.calls().vkCmdFillBuffer(commands, buffers_[size_t(name)].handle(), 0, VK_WHOLE_SIZE,
                                        whole && name >= responses && name <= deformation ? nan : 0);
}

} // namespace dermis::vulkan
