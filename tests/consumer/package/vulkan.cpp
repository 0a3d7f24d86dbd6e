// SPDX-License-Identifier: MIT
// A program that uses Vulkan itself, through libvulkan or its own volk, before, while and after dermis does.
#ifdef OWN_VOLK
#define VOLK_IMPLEMENTATION
#include <volk.h> // first, see dermis/vulkan.hpp
#else
#include <vulkan/vulkan.h>
#endif

#include <dermis/dermis.hpp>
#include <dermis/vulkan.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>

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

uint32_t compute_family(VkPhysicalDevice physical) {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    uint32_t family = 0;
    while (family < count && !(families[family].queueFlags & VK_QUEUE_COMPUTE_BIT)) ++family;
    need(family < count, "a queue family computes");
    return family;
}

// The index of a memory type that a buffer may have and the host can write.
uint32_t memory_type(VkPhysicalDevice physical, uint32_t allowed) {
    constexpr VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(physical, &memory);
    uint32_t type = 0;
    while (type < memory.memoryTypeCount &&
           !(allowed >> type & 1 && (memory.memoryTypes[type].propertyFlags & host) == host))
        ++type;
    need(type < memory.memoryTypeCount, "the host can write some memory");
    return type;
}

// Those that dermis would have and the device offers.
std::vector<const char*> extensions_of(VkPhysicalDevice physical) {
    uint32_t count = 0;
    const dermis::vulkan::Requirements needs = dermis::vulkan::requirements();
    vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> offered(count);
    vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, offered.data());
    std::vector<const char*> extensions;
    for (const auto& list : {needs.required_if_offered, needs.used_if_enabled})
        for (const char* name : list)
            for (const VkExtensionProperties& e : offered)
                if (std::strcmp(e.extensionName, name) == 0) extensions.push_back(name);
    return extensions;
}

VkDevice make_device(VkPhysicalDevice physical, uint32_t family, const std::vector<const char*>& extensions) {
    const float priority = 1;
    const VkDeviceQueueCreateInfo queues{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                         .queueFamilyIndex = family,
                                         .queueCount = 1,
                                         .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                  .queueCreateInfoCount = 1,
                                  .pQueueCreateInfos = &queues,
                                  .enabledExtensionCount = uint32_t(extensions.size()),
                                  .ppEnabledExtensionNames = extensions.data()};
    VkDevice device = VK_NULL_HANDLE;
    need(vkCreateDevice(physical, &info, nullptr, &device) == VK_SUCCESS, "a device can be made");
    return device;
}

// A program on this program's own device, and its recorded check.
void record(VkInstance instance) {
    uint32_t count = 1;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    vkEnumeratePhysicalDevices(instance, &count, &physical);
    const uint32_t family = compute_family(physical);
    const std::vector<const char*> extensions = extensions_of(physical);
    const VkDevice device = make_device(physical, family, extensions);
    {
        dermis::vulkan::SkinProgram program({.instance = instance,
                                             .physical = physical,
                                             .device = device,
                                             .get_instance_proc_addr = vkGetInstanceProcAddr,
                                             .extensions = {extensions.begin(), extensions.end()}},
                                            dermis::SkinDescription(), 1);
        const dermis::vulkan::Memory& check = program.memory().check;

        const VkBufferCreateInfo buffer_info{
            .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = check.bytes, .usage = check.usage};
        VkBuffer buffer = VK_NULL_HANDLE;
        need(vkCreateBuffer(device, &buffer_info, nullptr, &buffer) == VK_SUCCESS, "a buffer can be made");
        VkMemoryRequirements requirements;
        vkGetBufferMemoryRequirements(device, buffer, &requirements);
        const VkMemoryAllocateInfo allocation{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                              .allocationSize = requirements.size,
                                              .memoryTypeIndex = memory_type(physical, requirements.memoryTypeBits)};
        VkDeviceMemory memory = VK_NULL_HANDLE;
        need(vkAllocateMemory(device, &allocation, nullptr, &memory) == VK_SUCCESS, "memory can be had");
        vkBindBufferMemory(device, buffer, memory, 0);
        void* bytes = nullptr;
        need(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, &bytes) == VK_SUCCESS, "memory can be mapped");
        std::memcpy(bytes, check.initial.data(), check.initial.size());
        program.bind_check({buffer, 0, check.bytes});

        const VkCommandPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                                .queueFamilyIndex = family};
        VkCommandPool pool = VK_NULL_HANDLE;
        vkCreateCommandPool(device, &pool_info, nullptr, &pool);
        const VkCommandBufferAllocateInfo commands_info{
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = pool, .commandBufferCount = 1};
        VkCommandBuffer commands = VK_NULL_HANDLE;
        vkAllocateCommandBuffers(device, &commands_info, &commands);
        const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        vkBeginCommandBuffer(commands, &begin);
        need(program.record_check(commands), "a check is bound");
        vkEndCommandBuffer(commands);
        VkQueue queue = VK_NULL_HANDLE;
        vkGetDeviceQueue(device, family, 0, &queue);
        const VkSubmitInfo submit{
            .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
        need(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE) == VK_SUCCESS, "commands can be submitted");
        vkQueueWaitIdle(queue);
        need(program.check_passed(bytes, program.memory().check.bytes), "the recorded check passes");
        vkDestroyCommandPool(device, pool, nullptr);
        vkDestroyBuffer(device, buffer, nullptr);
        vkFreeMemory(device, memory, nullptr);
    }
    vkDestroyDevice(device, nullptr);
}

} // namespace

int main() {
#ifdef OWN_VOLK
    need(volkInitialize() == VK_SUCCESS, "volkInitialize finds a loader");
#endif
    uint32_t version = 0;
    need(vkEnumerateInstanceVersion(&version) == VK_SUCCESS && version >= VK_API_VERSION_1_1,
         "the loader has a version");
    const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_1};
    const VkInstanceCreateInfo info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
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
    dermis::RunOptions options{.check = true};
    const dermis::Result r = dermis::run(scene, dermis::Device::open("vulkan"), options);
    need(r.device.vulkan && r.dispatches > 0, "dermis ran on a Vulkan device");
    need(r.cells_compared > 0 && r.cells_different == 0, "with the bits of the CPU");

    record(instance);
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
