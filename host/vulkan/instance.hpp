// SPDX-License-Identifier: MIT
// The loader, an instance, and what devices it offers.
#pragma once

#include "dermis/dermis.hpp"
#include "host/vulkan/kernel.hpp"

#include <mutex>

namespace dermis::vulkan {

// Where Vulkan comes from: the system's loader, or what a test puts in its place. `missing` says why there is none.
struct Loader {
    PFN_vkGetInstanceProcAddr get = nullptr;
    std::string missing;
};
Loader system_loader();

struct InstanceOptions {
    // Validation with synchronization validation; each message of warning or error goes here. Throws where the layer is
    // not installed.
    std::function<void(const std::string&)> validation;
};

struct PhysicalDevice {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties{};
    VkPhysicalDeviceMemoryProperties memory{};
    uint32_t family = 0;                 // a queue family that computes
    std::vector<std::string> extensions; // to enable
    bool rounds = false;                 // see DeviceTable
    std::string uuid;                    // hexadecimal
    DeviceInfo info;
};

// Throws Error::no_device naming what is missing: loader, driver.
class Instance {
  public:
    explicit Instance(const Loader&, const InstanceOptions& = {});
    ~Instance();
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;

    // Every device, best first: discrete, integrated, virtual, software.
    const std::vector<PhysicalDevice>& devices() const { return devices_; }
    VkInstance handle() const { return handle_; }
    PFN_vkGetInstanceProcAddr get() const { return get_; }
    // A logical device with one queue of the compute family.
    void open(const PhysicalDevice&, DeviceTable&) const;

  private:
    void find_devices();
    void describe(PhysicalDevice&) const;

    InstanceOptions options_;
    VkInstance handle_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    PFN_vkDestroyInstance destroy_ = nullptr;
    PFN_vkDestroyDebugUtilsMessengerEXT destroy_messenger_ = nullptr;
    PFN_vkGetInstanceProcAddr get_ = nullptr;
    std::vector<PhysicalDevice> devices_;
};

// The device's own functions, through nothing but this. Throws nothing; what is not there is null.
void load_calls(PFN_vkGetInstanceProcAddr, VkInstance, DeviceTable&);

// volk keeps instance functions in variables of the whole process: whoever fills or uses them holds this.
std::mutex& volk_mutex();

} // namespace dermis::vulkan
