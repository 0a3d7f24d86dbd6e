// SPDX-License-Identifier: MIT
// A host's own Vulkan handles, checked.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/vulkan/kernel.hpp"

namespace dermis::vulkan {

// What recording needs of the device, after everything about the handles has been looked at. Throws Error::bad_input
// naming what is missing.
DeviceTable checked(const Handles&);

// Labels in the command buffer; null where the host has not enabled them.
struct Labels {
    PFN_vkCmdBeginDebugUtilsLabelEXT begin = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT end = nullptr;
};
Labels labels_of(const Handles&);

} // namespace dermis::vulkan
