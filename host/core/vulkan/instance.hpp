// SPDX-License-Identifier: MIT
// The Vulkan loader, an instance, and the devices that it offers.
#pragma once

#include "dermis/device.hpp"
#include "dermis/vulkan.hpp"
#include "host/core/vulkan/kernel.hpp"

#include <functional>
#include <mutex>

namespace dermis::vulkan {

// The entry point of Vulkan: the system's loader, or one that a test puts in its place. `missing` says why there is
// none.
struct Loader {
    PFN_vkGetInstanceProcAddr get = nullptr;
    std::string missing;
};
Loader system_loader();

// Requirements on a device are the same for the library's own and an embedding host's. Returns the limit that is too
// small, its value and the value needed; empty if every limit suffices.
std::string why_not(const VkPhysicalDeviceLimits&);
// Returns the rules that kernels may declare, because the device offers them and the extension is enabled.
FloatRules float_rules(PFN_vkGetPhysicalDeviceProperties2, VkPhysicalDevice, const std::vector<std::string>& enabled);
// Whether kernels read maps as texel buffers: on a software driver, where that is faster, if its texel buffers can be
// as large, and begin at the same offsets, as its storage buffers.
bool reads_texels(const VkPhysicalDeviceProperties&);

struct InstanceOptions {
    // If set, the validation layer checks synchronization too and gives each warning and error to this function; the
    // constructor of Instance throws where the layer is not installed.
    std::function<void(const std::string&)> validation;
    // See DeviceTable. This much work takes a software driver up to a second on a core, and a GPU some milliseconds.
    // Tests set less.
    double most_work = 2e8;
};

struct PhysicalDevice {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties{};
    VkPhysicalDeviceMemoryProperties memory{};
    uint32_t family = 0;                 // index of a queue family with compute
    std::vector<std::string> extensions; // the extensions that Instance::open enables
    FloatRules floats;                   // see DeviceTable
    DeviceInfo info;
};

// A Vulkan instance. The constructor throws Error::no_device, naming what is missing: loader, driver or device.
class Instance {
  public:
    explicit Instance(const Loader&, const InstanceOptions& = {});
    ~Instance();
    Instance& operator=(Instance&&) = delete; // and no copies

    // Every device, best first: discrete, integrated, virtual, software.
    const std::vector<PhysicalDevice>& devices() const { return devices_; }
    VkInstance handle() const { return handle_; }
    PFN_vkGetInstanceProcAddr get() const { return get_; }
    // Makes a logical device with one queue of the compute family.
    void open(const PhysicalDevice&, DeviceTable&) const;

  private:
    // Opens nothing; if the public constructor fails after that, the destructor closes what it has opened.
    Instance(const InstanceOptions&, PFN_vkGetInstanceProcAddr);
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

// Fills the table with the device's own functions, all found through vkGetInstanceProcAddr. A missing function is null.
void load_calls(PFN_vkGetInstanceProcAddr, VkInstance, DeviceTable&);

// volk keeps instance functions in global variables: a thread locks this mutex while it fills or uses them.
std::mutex& volk_mutex();

} // namespace dermis::vulkan
