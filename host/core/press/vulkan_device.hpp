// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/press/device.hpp"
#include "host/core/vulkan/instance.hpp"

namespace dermis {

// Device::open with a loader and instance options of the caller's choice. which: not "cpu", which needs no loader.
Device open_device(const std::string& which, const vulkan::Loader&, const vulkan::InstanceOptions& = {});

} // namespace dermis
