// SPDX-License-Identifier: MIT
// The devices that press skins and run scenes.
#pragma once

#include <dermis/description.hpp>

namespace dermis {

struct DeviceInfo {
    std::string name;   // "cpu", or what the driver calls the device
    std::string kind;   // "cpu path", "discrete GPU", "integrated GPU", "virtual GPU", "software", "other"
    std::string driver; // name and version; empty for the CPU path
    bool vulkan = false;
    bool exact = true;   // a self-test gave the bits of the CPU path
    std::string refused; // the reason why the device cannot be used; empty if it can
};

// A Vulkan device is lost once work submitted to it fails. Every later use of it, by copies and skins too, throws
// Error::device naming the call that failed, and what the driver may still use is left to it. Device::open() makes
// another one. A wait for submitted work, of a second or less on most devices, lasts until the driver ends it: no time
// of a clock tells a device that hangs from one that is slow or stopped.
// A process that is forked uses neither its parent's Vulkan devices nor its CPU devices' threads: a press or a run
// there throws Error::device and never waits, and destructors leave both alone. What it opens and makes itself works.
class DERMIS_API Device {
  public:
    // threads: 0 = one per core that the process may use, by its affinity and its control groups; 1 = only the calling
    // thread.
    static Device cpu(int threads = 0);
    // which: "auto", a hardware GPU if there is one, else the CPU path (info().refused then says in one line why no
    // Vulkan device is used); "cpu"; "vulkan", the best Vulkan device, software included; a number, an index of list();
    // anything else, a part of a Vulkan device's name. Throws Error::no_device. A device whose bits differ from the CPU
    // path's in a self-test is refused unless asked for by number or name. Opening tests the plain kernels of presses.
    // The first run that marches tests the kernels of a march, and the first run that needs another stencil, edge rule,
    // precision, frames or materials tests every variant; a device whose bits differ there is refused then.
    static Device open(const std::string& which);
    // Lists every Vulkan device, usable or not. Throws Error::no_device if there is no loader or no driver.
    static std::vector<DeviceInfo> list();

    const DeviceInfo& info() const noexcept;

    struct DERMIS_HIDDEN Impl;
    explicit Device(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
    Impl& impl() const noexcept { return *impl_; }

  private:
    std::shared_ptr<Impl> impl_;
};

} // namespace dermis
