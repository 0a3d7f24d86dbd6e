// SPDX-License-Identifier: MIT
#include "host/core/vulkan/requirements.hpp"

#include "host/core/simd/model.hpp"

#include <algorithm>

namespace dermis::vulkan {

Requirements requirements() {
    Requirements r;
    r.storage_buffers = std::max(PRESS_BINDINGS, REDUCE_BINDINGS);
    r.required_if_offered = {"VK_KHR_portability_subset"};
    r.used_if_enabled = {VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME};
    r.used_if_enabled_instance = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    return r;
}

std::string why_not(const VkPhysicalDeviceLimits& limits) {
    const auto lacks = [](const char* limit, uint32_t value, uint32_t needed) {
        return std::string(limit) + " = " + std::to_string(value) + "; " + std::to_string(needed) + " are needed";
    };
    const uint32_t buffers = requirements().storage_buffers, invocations = std::max({PRESS_X * PRESS_Y, SITES_X});
    if (limits.maxPerStageDescriptorStorageBuffers < buffers)
        return lacks("maxPerStageDescriptorStorageBuffers", limits.maxPerStageDescriptorStorageBuffers, buffers);
    if (limits.maxComputeWorkGroupInvocations < invocations)
        return lacks("maxComputeWorkGroupInvocations", limits.maxComputeWorkGroupInvocations, invocations);
    return "";
}

FloatRules float_rules(PFN_vkGetPhysicalDeviceProperties2 get, VkPhysicalDevice device,
                       const std::vector<std::string>& enabled) {
    if (std::find(enabled.begin(), enabled.end(), VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME) == enabled.end())
        return {};
    VkPhysicalDeviceFloatControlsProperties floats{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    properties.pNext = &floats;
    get(device, &properties);
    return {.rounds_to_even = floats.shaderRoundingModeRTEFloat32 == VK_TRUE,
            .keeps_nans = floats.shaderSignedZeroInfNanPreserveFloat32 == VK_TRUE};
}

bool reads_texels(const VkPhysicalDeviceProperties& device) {
    constexpr VkDeviceSize texel = 4 * sizeof(float);
    const VkPhysicalDeviceLimits& limits = device.limits;
    return device.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU &&
           limits.maxTexelBufferElements >= limits.maxStorageBufferRange / texel &&
           limits.minTexelBufferOffsetAlignment <= limits.minStorageBufferOffsetAlignment;
}

} // namespace dermis::vulkan
