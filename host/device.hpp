// SPDX-License-Identifier: MIT
// Which backend computes, and whether its bits are the CPU path's.
#pragma once

#include "host/plan/backend.hpp"
#include "host/vulkan/instance.hpp"

namespace dermis {

struct Device::Impl {
    DeviceInfo info;
    std::shared_ptr<plan::Backend> backend;
    bool asked = false;  // for by name or as Vulkan: then it is this device that works
    bool named = false;  // by its name or number: differing bits are then no reason to refuse
    bool tested = false; // in every variant; opening a Vulkan device tests the plain one alone

    // Throws Error::no_device where the bits differ and the device was not named.
    void need_exact() const;
    // Tests every variant, once, if this one is not the plain one; then as need_exact().
    void need_exact(const plan::Variant&);
};

// Device::open with a loader of the caller's choice and validation.
Device open_device(const std::string& which, const vulkan::Loader&, const vulkan::InstanceOptions& = {});

// The model `march` on a device.
std::unique_ptr<plan::Stepper> march(const Device&, const plan::PreparedSkin&, const plan::Schedule&, Precision,
                                     plan::Stepper::Sink);

} // namespace dermis
