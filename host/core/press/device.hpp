// SPDX-License-Identifier: MIT
// The backend of a Device, and whether it computes the CPU path's bits.
#pragma once

#include "host/core/model/stream.hpp"
#include "host/core/vulkan/instance.hpp"

namespace dermis {

struct Device::Impl {
    DeviceInfo info;
    std::shared_ptr<plan::Backend> backend;
    bool asked = false;   // for by name or as "vulkan": every run that this device can compute stays on it
    bool named = false;   // asked for by name or number: it is used though its bits differ
    bool tested = false;  // in every variant; opening a Vulkan device tests only the plain one
    bool put_off = false; // the CPU path stands for "auto" until a march in float is taken, which best() computes
    std::optional<Device> best_if_open;

    // Throws Error::no_device where the bits differ and the device was not named.
    void need_exact() const;
    // Tests every variant once, where this one is not the plain one; then throws as need_exact() does.
    void need_exact(const plan::Variant&);
    // Opens "auto", once.
    const Device& best();
};

// Is "auto", but opens no Vulkan device before a run marches in float: a loader and a driver take longer to open than
// the other models to run.
Device open_when_marching();

// Device::open with a loader of the caller's choice and validation.
Device open_device(const std::string& which, const vulkan::Loader&, const vulkan::InstanceOptions& = {});

// The model `march` on a device.
std::unique_ptr<plan::Stepper> march(const Device&, const plan::PreparedSkin&, const plan::Schedule&, Precision,
                                     plan::Stepper::Sink);

} // namespace dermis
