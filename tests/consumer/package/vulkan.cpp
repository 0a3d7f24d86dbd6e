// SPDX-License-Identifier: MIT
// A program that uses Vulkan itself, through libvulkan or its own volk, before, while and after dermis does.
#include <dermis/dermis.hpp>

#ifdef OWN_VOLK
#define VOLK_IMPLEMENTATION
#include <volk.h>
#else
#include <vulkan/vulkan.h>
#endif

#include <cstdio>
#include <cstdlib>

namespace {

void need(bool ok, const char* what) {
    if (ok) return;
    std::fprintf(stderr, "not so: %s\n", what);
    std::exit(1);
}

template <class... F> std::vector<void (*)()> list(F... f) { return {reinterpret_cast<void (*)()>(f)...}; }

// What calls go through; with volk these are variables.
std::vector<void (*)()> functions() {
    return list(vkGetInstanceProcAddr, vkEnumerateInstanceVersion, vkCreateInstance, vkDestroyInstance,
                vkEnumeratePhysicalDevices, vkGetPhysicalDeviceProperties, vkCreateDevice, vkGetDeviceProcAddr,
                vkCreateBuffer, vkAllocateMemory, vkCmdDispatch, vkQueueSubmit, vkWaitForFences);
}

} // namespace

int main() {
#ifdef OWN_VOLK
    need(volkInitialize() == VK_SUCCESS, "volkInitialize finds a loader");
#endif
    uint32_t version = 0;
    need(vkEnumerateInstanceVersion(&version) == VK_SUCCESS && version >= VK_API_VERSION_1_1,
         "the loader has a version");
    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pApplicationInfo = &application;
    VkInstance instance = VK_NULL_HANDLE;
    need(vkCreateInstance(&info, nullptr, &instance) == VK_SUCCESS, "an instance can be made");
#ifdef OWN_VOLK
    volkLoadInstance(instance);
#endif
    const auto before = functions();
    for (auto f : before) need(f, "every function is there");
    uint32_t devices = 0;
    need(vkEnumeratePhysicalDevices(instance, &devices, nullptr) == VK_SUCCESS && devices > 0, "there is a device");

    dermis::Scene scene;
    scene.grid.width = 60;
    scene.grid.height = 40;
    scene.time.duration = 0.2;
    dermis::RunOptions options;
    options.check = true;
    const dermis::Result r = dermis::run(scene, dermis::Device::open("vulkan"), options);
    need(r.device.vulkan && r.dispatches > 0, "dermis ran on a Vulkan device");
    need(r.cells_compared > 0 && r.cells_different == 0, "with the bits of the CPU");

    need(functions() == before, "the functions are what they were");
#ifdef OWN_VOLK
    need(volkGetLoadedInstance() == instance, "volk has the program's instance");
#endif
    uint32_t still = 0;
    need(vkEnumeratePhysicalDevices(instance, &still, nullptr) == VK_SUCCESS && still == devices,
         "the instance still works");
    vkDestroyInstance(instance, nullptr);
    std::printf("%s: %lld cells compared\n", r.device.name.c_str(), r.cells_compared);
}
