// SPDX-License-Identifier: MIT
// The backend of a Device, and whether it computes the CPU path's bits.
#pragma once

#include "host/core/model/stream.hpp"

namespace dermis {

struct Device::Impl {
    DeviceInfo info;
    std::shared_ptr<model::Backend> backend;
    bool asked = false;   // by name, number or as "vulkan": every run that this device can compute stays on it
    bool named = false;   // asked for by name or number: it is used even if its bits differ
    bool put_off = false; // this CPU path stands for "auto"; a march in float runs on best() instead
    std::optional<Device> best_if_open;

    // Throws Error::no_device where the bits differ and the device was not named.
    void need_exact() const;
    // Opens "auto", once.
    const Device& best();
};

// Stands for "auto", but opens no Vulkan device before a run marches in float: to open a loader and a driver takes
// longer than a run of the other models.
Device open_when_marching();

} // namespace dermis
