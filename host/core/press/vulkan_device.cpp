// SPDX-License-Identifier: MIT
#include "host/core/press/vulkan_device.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/opening.hpp"
#include "host/core/embedding/backend.hpp"
#include "host/core/embedding/check.hpp"

#include <algorithm>
#include <cctype>

namespace dermis {
namespace {

using vulkan::PhysicalDevice;

std::string lower(std::string s) {
    std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return s;
}

[[noreturn]] void no_device(const std::string& which, const std::string& why) {
    throw Error(Error::Code::no_device, "device", "device = \"" + which + "\": " + why);
}

Device open_vulkan(const std::shared_ptr<const vulkan::Instance>& instance, const PhysicalDevice& physical) {
    auto impl = std::make_shared<Device::Impl>();
    impl->info = physical.info;
    impl->backend = std::make_shared<vulkan::VulkanBackend>(std::make_shared<vulkan::Context>(instance, physical));
    const DefaultFloats guard;
    const auto exact = [&](bool sites) { return impl->backend->exact(SampleStream({.sites = sites}).skin()); };
    impl->info.exact = exact(false) && exact(true);
    return Device(impl);
}

// The first device that works and computes the CPU path's bits. Where there is none, `why` gives each one's reason.
std::optional<Device> first_exact(const std::shared_ptr<const vulkan::Instance>& instance, bool hardware_only,
                                  std::string& why) {
    for (const PhysicalDevice& p : instance->devices()) {
        std::string reason = p.info.refused;
        if (reason.empty() && hardware_only && p.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU)
            reason = "a software driver, slower than the CPU path";
        if (reason.empty()) {
            try {
                Device device = open_vulkan(instance, p);
                if (device.info().exact) return device;
                reason = "its bits differ from the CPU path's; ask for it by name to use it all the same";
            } catch (const Error& e) {
                if (e.code() == Error::Code::no_memory) throw;
                reason = e.what();
            }
        }
        why += (why.empty() ? "" : "; ") + p.info.name + ": " + reason;
    }
    return {};
}

const PhysicalDevice& named(const std::vector<PhysicalDevice>& devices, const std::string& which) {
    std::string names;
    const bool number = !which.empty() && which.size() < 6 &&
                        std::all_of(which.begin(), which.end(), [](unsigned char c) { return std::isdigit(c); });
    for (size_t i = 0; i < devices.size(); ++i) {
        const std::string& name = devices[i].info.name;
        const auto in = [part = lower(which)](const std::string& text) {
            return part.find_first_not_of(' ') != part.npos && text.find(part) != text.npos; // no blanks alone
        };
        if (number ? size_t(std::stoi(which)) == i
                   : in(lower(name)) || (which.size() >= 8 && in("gpu-" + devices[i].info.uuid)))
            return devices[i];
        names += ", " + std::to_string(i) + " or part of \"" + name + "\" or of " + devices[i].info.uuid;
    }
    throw Error(Error::Code::bad_input, "device",
                "device = \"" + which +
                    "\": no such device; allowed: auto (a GPU if there is one, else the CPU path), cpu, "
                    "vulkan (the best Vulkan device, a GPU if there is one)" +
                    names);
}

} // namespace

Device open_device(const std::string& which, const vulkan::Loader& loader, const vulkan::InstanceOptions& options) {
    const auto words = [&] { return "device \"" + which + "\" and its test"; };
    return scene::guarded(words, [&] {
        const Opening opening;
        std::string why;
        try {
            const auto instance = std::make_shared<const vulkan::Instance>(loader, options);
            if (which == "auto" || which == "vulkan") {
                if (auto device = first_exact(instance, which == "auto", why)) {
                    device->impl().asked = which == "vulkan";
                    return *device;
                }
            } else {
                const PhysicalDevice& p = named(instance->devices(), which);
                if (!p.info.refused.empty()) no_device(which, p.info.name + ": " + p.info.refused);
                Device device = open_vulkan(instance, p);
                device.impl().asked = device.impl().named = true;
                return device;
            }
        } catch (const Error& e) {
            if (e.code() == Error::Code::no_memory || (which != "auto" && e.parameter() == "device")) throw;
            why = e.what();
        }
        if (which != "auto") no_device(which, why);
        Device device = Device::cpu();
        device.impl().info.refused = "no Vulkan device used: " + why;
        return device;
    });
}

Device Device::open(const std::string& which) {
    return which == "cpu" ? cpu() : open_device(which, vulkan::system_loader()); // nothing of Vulkan is loaded in vain
}

std::vector<DeviceInfo> Device::list() {
    return scene::guarded("the list of devices", [&] {
        const Opening opening;
        const vulkan::Instance instance(vulkan::system_loader());
        std::vector<DeviceInfo> list;
        for (const PhysicalDevice& p : instance.devices()) list.push_back(p.info);
        return list;
    });
}

} // namespace dermis
