// SPDX-License-Identifier: MIT
// What a device must have, asked of ours and of somebody else's alike.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/vulkan/volk.hpp"

namespace dermis::vulkan {

// The limit that is too small; empty where all will do.
std::string why_not(const VkPhysicalDeviceLimits&);

// Whether kernels may declare round-to-nearest-even: the device offers it and the extension is among those enabled.
bool rounds_to_even(PFN_vkGetPhysicalDeviceProperties2, VkPhysicalDevice, const std::vector<std::string>& enabled);

} // namespace dermis::vulkan
