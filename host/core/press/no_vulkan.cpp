// SPDX-License-Identifier: MIT
// The devices of a build with -DDERMIS_VULKAN=OFF.
#include "host/core/press/device.hpp"

namespace dermis {

Device Device::open(const std::string& which) {
    if (which != "cpu" && which != "auto")
        throw Error(Error::Code::no_device, "device",
                    "device = \"" + which + "\": this build of dermis has no Vulkan; allowed: auto, cpu");
    Device device = cpu();
    if (which == "auto") device.impl().info.refused = "no Vulkan device used: this build of dermis has no Vulkan";
    return device;
}

std::vector<DeviceInfo> Device::list() {
    throw Error(Error::Code::no_device, "device", "this build of dermis has no Vulkan");
}

} // namespace dermis
