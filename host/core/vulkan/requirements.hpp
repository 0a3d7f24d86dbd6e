// SPDX-License-Identifier: MIT
// The requirements on a device, the same for the library's own and an embedding host's.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/vulkan/modules.hpp"
#include "host/core/vulkan/volk.hpp"

namespace dermis::vulkan {

// The limit that is too small, its value and the value needed; empty where every limit suffices.
std::string why_not(const VkPhysicalDeviceLimits&);

// The rules that kernels may declare: the device offers them and the extension is enabled.
FloatRules float_rules(PFN_vkGetPhysicalDeviceProperties2, VkPhysicalDevice, const std::vector<std::string>& enabled);

// Whether kernels read maps as texel buffers: on a software driver, where that is faster, if its texel buffers can be
// as large, and begin at the same offsets, as its storage buffers.
bool reads_texels(const VkPhysicalDeviceProperties&);

} // namespace dermis::vulkan
