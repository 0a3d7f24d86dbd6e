// SPDX-License-Identifier: MIT
// Checks the Vulkan handles of an embedding host.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/vulkan/kernel.hpp"

namespace dermis::vulkan {

// Checks the handles and returns the device table that recording uses. Throws Error::bad_input, naming what is missing.
DeviceTable checked(const Handles&);

// The functions that label commands; null where the host has not enabled VK_EXT_debug_utils.
struct Labels {
    PFN_vkCmdBeginDebugUtilsLabelEXT begin = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT end = nullptr;
};
Labels labels_of(const Handles&);

} // namespace dermis::vulkan
