// SPDX-License-Identifier: MIT
// Which device computes, and whether its bits are the CPU path's.
#pragma once

#include "host/plan/marcher.hpp"
#include "host/vulkan/march.hpp"

#include <cstdint>

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

std::unique_ptr<plan::Marcher> march(const Device&, const plan::Plan&, plan::Marcher::Sink);

// Each kernel on small grids in every variant, on the device and on the CPU path.
struct SelfTest {
    struct Kernel {
        const char* name;
        uint64_t hash = 14695981039346656037u; // of the device's values
        long long values = 0, different = 0;
    };
    Kernel kernels[3] = {{"press"}, {"fields"}, {"reduce"}};
    bool exact() const { return kernels[0].different + kernels[1].different + kernels[2].different == 0; }
};
SelfTest self_test(const Device&, bool every_variant = true);

} // namespace dermis
