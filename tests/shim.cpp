// SPDX-License-Identifier: MIT
#include "tests/shim.hpp"

#include <cstring>
#include <mutex>

namespace test {

Shim shim;

namespace {

const PFN_vkGetInstanceProcAddr real_get = vulkan::system_loader().get;
PFN_vkVoidFunction real_queues, real_properties, real_memory, real_extensions, real_module, real_device_address;

VKAPI_ATTR VkResult VKAPI_CALL no_instance(const VkInstanceCreateInfo*, const VkAllocationCallbacks*, VkInstance*) {
    return VK_ERROR_INCOMPATIBLE_DRIVER;
}

VKAPI_ATTR void VKAPI_CALL queues(VkPhysicalDevice p, uint32_t* count, VkQueueFamilyProperties* families) {
    reinterpret_cast<PFN_vkGetPhysicalDeviceQueueFamilyProperties>(real_queues)(p, count, families);
    for (uint32_t i = 0; families && shim.no_compute && i < *count; ++i)
        families[i].queueFlags &= ~VkQueueFlags(VK_QUEUE_COMPUTE_BIT);
}

VKAPI_ATTR void VKAPI_CALL properties(VkPhysicalDevice p, VkPhysicalDeviceProperties* out) {
    reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(real_properties)(p, out);
    if (shim.few_buffers) out->limits.maxPerStageDescriptorStorageBuffers = 4;
    if (shim.least) {
        out->limits.maxPerStageDescriptorStorageBuffers = 12;
        out->limits.maxComputeWorkGroupInvocations = 128;
        out->limits.maxComputeSharedMemorySize = 16384;
        out->limits.minStorageBufferOffsetAlignment = 256;
        out->limits.maxTexelBufferElements = 65536;
        for (uint32_t& count : out->limits.maxComputeWorkGroupCount) count = 65535;
        for (uint32_t& size : out->limits.maxComputeWorkGroupSize) size = 64;
    }
    if (shim.range) out->limits.maxStorageBufferRange = shim.range;
}

VKAPI_ATTR void VKAPI_CALL memory(VkPhysicalDevice p, VkPhysicalDeviceMemoryProperties* out) {
    reinterpret_cast<PFN_vkGetPhysicalDeviceMemoryProperties>(real_memory)(p, out);
    for (uint32_t i = 0; shim.heap && i < out->memoryHeapCount; ++i) out->memoryHeaps[i].size = shim.heap;
}

VKAPI_ATTR VkResult VKAPI_CALL extensions(VkPhysicalDevice p, const char* layer, uint32_t* count,
                                          VkExtensionProperties* list) {
    const auto real = reinterpret_cast<PFN_vkEnumerateDeviceExtensionProperties>(real_extensions);
    const VkResult result = real(p, layer, count, list);
    if (shim.portability && list && *count > 0) std::strcpy(list[0].extensionName, "VK_KHR_portability_subset");
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL module(VkDevice d, const VkShaderModuleCreateInfo* info, const VkAllocationCallbacks* a,
                                      VkShaderModule* m) {
    std::vector<uint32_t> code(info->pCode, info->pCode + info->codeSize / 4);
    for (uint32_t& word : code)
        if ((shim.miscompile && word == 0x3f800000) || (shim.miscompile_far && word == 0x3faaaaab)) word ^= 1;
    VkShaderModuleCreateInfo changed = *info;
    changed.pCode = code.data();
    return reinterpret_cast<PFN_vkCreateShaderModule>(real_module)(d, &changed, a, m);
}

PFN_vkVoidFunction real_sets, real_barrier;

VKAPI_ATTR VkResult VKAPI_CALL sets(VkDevice d, const VkDescriptorSetAllocateInfo* info, VkDescriptorSet* set) {
    if (shim.sets_left == 0) return VK_ERROR_OUT_OF_HOST_MEMORY;
    shim.sets_left -= shim.sets_left > 0;
    return reinterpret_cast<PFN_vkAllocateDescriptorSets>(real_sets)(d, info, set);
}

VKAPI_ATTR void VKAPI_CALL barrier(VkCommandBuffer c, VkPipelineStageFlags from, VkPipelineStageFlags to,
                                   VkDependencyFlags flags, uint32_t count, const VkMemoryBarrier* memory,
                                   uint32_t buffers, const VkBufferMemoryBarrier* buffer, uint32_t images,
                                   const VkImageMemoryBarrier* image) {
    if (shim.barriers) {
        const VkMemoryBarrier first = count ? *memory : VkMemoryBarrier{};
        shim.barriers->push_back({from, to, first.srcAccessMask, first.dstAccessMask});
    }
    reinterpret_cast<PFN_vkCmdPipelineBarrier>(real_barrier)(c, from, to, flags, count, memory, buffers, buffer, images,
                                                             image);
}

// Whether this call is the one to fail.
bool strikes(const char* name) {
    Fault& f = shim.fault;
    if (f.struck || std::strcmp(name, f.call) != 0 || f.before-- > 0) return false;
    return f.struck = true;
}

// A device function that is written down, and fails where it is to.
template <int which, class Function> struct Logged;
template <int which, class R, class... A> struct Logged<which, R(VKAPI_PTR*)(A...)> {
    static inline R(VKAPI_PTR* real)(A...) = nullptr;
    static inline const char* name = "";
    static VKAPI_ATTR R VKAPI_CALL call(A... a) {
        static std::mutex mutex;
        [[maybe_unused]] bool fails = false;
        {
            const std::lock_guard lock(mutex);
            shim.calls.push_back(name);
            fails = strikes(name);
        }
        if constexpr (std::is_same_v<R, VkResult>)
            if (fails) {
                if (shim.fault.made) (void)real(a...);
                return shim.fault.code;
            }
        return real(a...);
    }
    static bool take(const char* wanted, const char* own, PFN_vkVoidFunction& f) {
        if (std::strcmp(wanted, own) != 0) return false;
        name = own;
        real = reinterpret_cast<R(VKAPI_PTR*)(A...)>(f);
        f = reinterpret_cast<PFN_vkVoidFunction>(call);
        return true;
    }
};

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_address(VkDevice device, const char* name) {
    PFN_vkVoidFunction f = reinterpret_cast<PFN_vkGetDeviceProcAddr>(real_device_address)(device, name);
    if (std::strcmp(name, shim.absent) == 0) return nullptr;
    if (std::strcmp(name, "vkCreateShaderModule") == 0) {
        real_module = f;
        return reinterpret_cast<PFN_vkVoidFunction>(module);
    }
    const auto instead = [&](const char* wanted, PFN_vkVoidFunction& keep, auto* ours) {
        if (std::strcmp(name, wanted) != 0) return;
        keep = f;
        f = reinterpret_cast<PFN_vkVoidFunction>(ours);
    };
    instead("vkAllocateDescriptorSets", real_sets, sets);
    instead("vkCmdPipelineBarrier", real_barrier, barrier);
#define LOGGED(name_) Logged<__LINE__, PFN_##name_>::take(name, #name_, f) ||
    (void)(LOGGED(vkBeginCommandBuffer) LOGGED(vkEndCommandBuffer) LOGGED(vkQueueSubmit) LOGGED(vkWaitForFences)
               LOGGED(vkResetFences) LOGGED(vkCmdBindPipeline) LOGGED(vkCmdBindDescriptorSets)
                   LOGGED(vkCmdPushConstants) LOGGED(vkCmdDispatch) LOGGED(vkCmdPipelineBarrier) LOGGED(vkCmdCopyBuffer)
                       LOGGED(vkCmdUpdateBuffer) LOGGED(vkCmdFillBuffer) LOGGED(vkCmdWriteTimestamp)
                           LOGGED(vkCreateBuffer) LOGGED(vkAllocateMemory) LOGGED(vkCreateComputePipelines)
                               LOGGED(vkAllocateDescriptorSets) LOGGED(vkUpdateDescriptorSets) LOGGED(vkMapMemory)
                                   LOGGED(vkDestroyPipeline) LOGGED(vkDestroyDescriptorPool) LOGGED(vkDestroyBuffer)
                                       LOGGED(vkFreeMemory) LOGGED(vkDestroyDevice) false);
    return f;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_address(VkInstance instance, const char* name) {
    const PFN_vkVoidFunction real = real_get(instance, name);
    const auto instead = [&](PFN_vkVoidFunction& keep, auto* ours) {
        keep = real;
        return reinterpret_cast<PFN_vkVoidFunction>(ours);
    };
    const auto is = [name](const char* other) { return std::strcmp(name, other) == 0; };
    if (is(shim.absent)) return nullptr;
    if (shim.no_driver && is("vkCreateInstance")) return reinterpret_cast<PFN_vkVoidFunction>(no_instance);
    if (is("vkGetPhysicalDeviceQueueFamilyProperties")) return instead(real_queues, queues);
    if (is("vkGetPhysicalDeviceProperties")) return instead(real_properties, properties);
    if (is("vkGetPhysicalDeviceMemoryProperties")) return instead(real_memory, memory);
    if (is("vkEnumerateDeviceExtensionProperties")) return instead(real_extensions, extensions);
    if (is("vkGetDeviceProcAddr")) return instead(real_device_address, device_address);
    return real;
}

} // namespace

vulkan::Loader shimmed() {
    shim = {};
    return {instance_address, ""};
}

vulkan::Loader faulty(bool Shim::*fault) {
    const vulkan::Loader loader = shimmed();
    shim.*fault = true;
    return loader;
}

} // namespace test
