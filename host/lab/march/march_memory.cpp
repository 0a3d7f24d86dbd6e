// SPDX-License-Identifier: MIT
#include "host/lab/march/results.hpp"

namespace dermis::vulkan {

MarchMemory::MarchMemory(const plan::PreparedSkin& skin, const plan::Schedule& schedule, const plan::Variant& variant)
    : skin_(skin), schedule_(schedule), variant_(variant), map_(skin.padded_cells() * sizeof(float)) {}

// A buffer that the run does not need is bound all the same, so it has 4 bytes.
VkDeviceSize MarchMemory::bytes_of(int name) const {
    constexpr VkDeviceSize unused = 4;
    if (name >= responses && name < curvature)
        return variant_.wanted[size_t(name - responses + QUANTITY_SA1)] ? map_ : unused;
    switch (name) {
    case state0:
    case state1: return VkDeviceSize(variant_.state().planes()) * map_;
    case surface:
    case curvature:
    case deformation: return schedule_.derives ? map_ : unused;
    case pressure1: return variant_.framed ? map_ : unused;
    case material: return variant_.materials ? map_ : unused;
    case coefficients:
        return variant_.tabled() ? (1 + variant_.bent) * skin_.materials.size() * sizeof(f32::Coefficients) : unused;
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
    const plan::PressedBox& box = schedule_.pressed;
    const bool whole =
        box.first_row == 0 && box.last_row == skin_.height() && box.first_tile == 0 && box.last_tile == skin_.tiles;
    constexpr uint32_t nan = 0xffffffff;
    for (int name = 0; name < names; ++name)
        context.calls().vkCmdFillBuffer(commands, buffers_[size_t(name)].handle(), 0, VK_WHOLE_SIZE,
                                        whole && name >= responses && name <= deformation ? nan : 0);
}

} // namespace dermis::vulkan
