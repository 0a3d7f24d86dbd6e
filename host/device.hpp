// SPDX-License-Identifier: MIT
// Which device computes, and whether its bits are the CPU path's.
#pragma once

#include "host/plan/stepper.hpp"
#include "host/vulkan/stepper.hpp"

namespace dermis {

struct Device::Impl {
    DeviceInfo info;
    int threads = 0;                          // CPU path
    bool asked = false;                       // for by name or as Vulkan: then it is this device that works
    std::shared_ptr<vulkan::Context> context; // null: the CPU path
    bool named = false;                       // by its name or number: differing bits are then no reason to refuse
    bool tested = false;                      // in every variant; opening a device tests the plain one alone
};

// Device::open with a loader of the caller's choice and validation.
Device open_device(const std::string& which, const vulkan::Loader&, const vulkan::InstanceOptions& = {});

std::unique_ptr<plan::Stepper> march(const Device&, const plan::Plan&, plan::Stepper::Sink);

} // namespace dermis
