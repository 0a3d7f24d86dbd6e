// SPDX-License-Identifier: MIT
// The devices that press skins and run scenes.
#pragma once

#include <dermis/description.hpp>

namespace dermis {

struct DeviceInfo {
    std::string name;   // "cpu", or what the driver calls the device
    std::string kind;   // "cpu path", "discrete GPU", "integrated GPU", "virtual GPU", "software", "other"
    std::string driver; // name and version; empty for the CPU path
    // 32 hexadecimal digits in groups, as `vulkaninfo` and `nvidia-smi -L` print them, by which devices of one name
    // differ; empty for the CPU path and for Vulkan 1.0.
    std::string uuid;
    bool vulkan = false;
    bool exact = true;   // whether a self-test gave the bits of the CPU path; false in list(), which tests nothing
    std::string refused; // why the device cannot be used; of a CPU path from "auto" why no Vulkan device is used
};

// Once work that was submitted to a Vulkan device fails, the device is lost: every later use of the Device, of its
// copies and of skins on it throws Error::device, which names the call that failed. Objects that the driver may still
// be using are then never destroyed. Device::open() makes a new one. Waits for submitted work, a second or less on most
// devices, have no timeout: no clock can tell a device that hangs from a slow or a stopped one.
// exit() waits for the calls of other threads that use a Vulkan device, and for submitted work, before it destroys
// static objects; each later use throws Error::device, and destructors leave the device alone. While another thread is
// in open() or list(), neither exit() nor fork() may be called; Python's exit waits.
// After a fork the child process can use neither the Vulkan devices nor the threads of the parent's devices: a press or
// a run that needs them throws Error::device and never waits, and destructors leave them alone. If the parent has
// called open() or list() for Vulkan, then in its child open() throws Error::no_device, list() Error::device, and
// "auto" is the CPU path. Devices of the CPU and skins on them that the child makes work. The child should end by
// _exit(), as Python's multiprocessing does: in exit() NVIDIA's driver (580.159) stops the device of the parent.
class DERMIS_API Device {
  public:
    // threads: 0 = one per core that the process may use (by its affinity and its control groups); 1 = only the calling
    // thread; at most 1024.
    static Device cpu(int threads = 0);
    // Opens a device. which:
    //   "auto"        a hardware GPU if there is one, else the CPU path; info().refused then says in one line why no
    //                 Vulkan device is used
    //   "cpu"         the CPU path
    //   "vulkan"      the best Vulkan device, software devices included
    //   a number      an index of list()
    //   other text    a part of a Vulkan device's name, or of its uuid, 8 characters or more: the first device that has
    //                 it
    // A build without Vulkan (-DDERMIS_VULKAN=OFF) has "auto" and "cpu" alone.
    // Throws Error::bad_input for a number or a text that no device of list() has; Error::no_device where there is no
    // loader or driver, and where the device is refused. A device that gives other bits than the CPU path in a
    // self-test is refused, unless it was asked for by number, name or uuid. Opening a device tests the basic kernels
    // of presses; the first skin or march of another kind tests its kernels, and the device is refused then.
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
