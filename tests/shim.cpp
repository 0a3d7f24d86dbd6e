// SPDX-License-Identifier: MIT
#include "tests/shim.hpp"

#include "tests/allocations.hpp"
#include "tests/vulkan_calls.hpp"

#include <cstring>
#include <mutex>
#include <tuple>

namespace test {

Shim shim;

namespace {

const PFN_vkGetInstanceProcAddr real_get = vulkan::system_loader().get;
PFN_vkVoidFunction real_queues, real_properties, real_ids, real_devices, real_memory, real_extensions, real_module,
    real_device_address;

VKAPI_ATTR VkResult VKAPI_CALL no_instance(const VkInstanceCreateInfo*, const VkAllocationCallbacks*, VkInstance*) {
    return VK_ERROR_INCOMPATIBLE_DRIVER;
}

VKAPI_ATTR void VKAPI_CALL queues(VkPhysicalDevice p, uint32_t* count, VkQueueFamilyProperties* families) {
    const InDriver driver;
    reinterpret_cast<PFN_vkGetPhysicalDeviceQueueFamilyProperties>(real_queues)(p, count, families);
    for (uint32_t i = 0; families && shim.no_compute && i < *count; ++i)
        families[i].queueFlags &= ~VkQueueFlags(VK_QUEUE_COMPUTE_BIT);
}

VKAPI_ATTR void VKAPI_CALL properties(VkPhysicalDevice p, VkPhysicalDeviceProperties* out) {
    const InDriver driver;
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

VKAPI_ATTR VkResult VKAPI_CALL devices(VkInstance instance, uint32_t* count, VkPhysicalDevice* list) {
    const auto real = reinterpret_cast<PFN_vkEnumeratePhysicalDevices>(real_devices);
    if (!shim.twins) return real(instance, count, list);
    uint32_t one = 1;
    if (list) (void)real(instance, &one, list), list[1] = list[0];
    *count = 2;
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL ids(VkPhysicalDevice p, VkPhysicalDeviceProperties2* out) {
    const InDriver driver;
    static uint8_t twin = 0;
    reinterpret_cast<PFN_vkGetPhysicalDeviceProperties2>(real_ids)(p, out);
    auto* id = static_cast<VkPhysicalDeviceIDProperties*>(out->pNext);
    if (!shim.twins || !id || id->sType != VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES) return;
    id->deviceUUID[15] = twin = uint8_t(1 + twin % 2);
}

VKAPI_ATTR void VKAPI_CALL memory(VkPhysicalDevice p, VkPhysicalDeviceMemoryProperties* out) {
    const InDriver driver;
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

PFN_vkVoidFunction real_sets, real_barrier, real_dispatch, real_submit, real_copy, real_pipeline, real_set,
    real_constants, real_end;

// A dispatch that waits for a barrier, with the pipeline, the descriptor set and the constants that were bound for it.
struct Dispatch {
    VkPipeline pipeline = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkDescriptorSet set = VK_NULL_HANDLE;
    std::vector<char> constants;
    uint32_t x = 0, y = 0, z = 0;
};
Dispatch next;
std::vector<Dispatch> waiting; // in the order of recording; empty unless shim.reversed

// Records the dispatches since the last barrier, the last one first: Vulkan lets them run in any order.
void record_waiting(VkCommandBuffer c) {
    constexpr VkPipelineBindPoint compute = VK_PIPELINE_BIND_POINT_COMPUTE;
    for (auto d = waiting.rbegin(); d != waiting.rend(); ++d) {
        reinterpret_cast<PFN_vkCmdBindPipeline>(real_pipeline)(c, compute, d->pipeline);
        reinterpret_cast<PFN_vkCmdBindDescriptorSets>(real_set)(c, compute, d->layout, 0, 1, &d->set, 0, nullptr);
        reinterpret_cast<PFN_vkCmdPushConstants>(real_constants)(c, d->layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                                                                 uint32_t(d->constants.size()), d->constants.data());
        reinterpret_cast<PFN_vkCmdDispatch>(real_dispatch)(c, d->x, d->y, d->z);
    }
    waiting.clear();
}

VKAPI_ATTR void VKAPI_CALL bind_pipeline(VkCommandBuffer c, VkPipelineBindPoint point, VkPipeline p) {
    next.pipeline = p;
    if (!shim.reversed) reinterpret_cast<PFN_vkCmdBindPipeline>(real_pipeline)(c, point, p);
}

VKAPI_ATTR void VKAPI_CALL bind_set(VkCommandBuffer c, VkPipelineBindPoint point, VkPipelineLayout layout,
                                    uint32_t first, uint32_t count, const VkDescriptorSet* sets, uint32_t offsets,
                                    const uint32_t* offset) {
    next.set = *sets;
    const auto real = reinterpret_cast<PFN_vkCmdBindDescriptorSets>(real_set);
    if (!shim.reversed) real(c, point, layout, first, count, sets, offsets, offset);
}

VKAPI_ATTR void VKAPI_CALL constants(VkCommandBuffer c, VkPipelineLayout layout, VkShaderStageFlags stages,
                                     uint32_t offset, uint32_t bytes, const void* values) {
    next.layout = layout;
    next.constants.assign(static_cast<const char*>(values), static_cast<const char*>(values) + bytes);
    const auto real = reinterpret_cast<PFN_vkCmdPushConstants>(real_constants);
    if (!shim.reversed) real(c, layout, stages, offset, bytes, values);
}

VKAPI_ATTR VkResult VKAPI_CALL end(VkCommandBuffer c) {
    record_waiting(c);
    return reinterpret_cast<PFN_vkEndCommandBuffer>(real_end)(c);
}

VKAPI_ATTR VkResult VKAPI_CALL sets(VkDevice d, const VkDescriptorSetAllocateInfo* info, VkDescriptorSet* set) {
    if (shim.sets_left == 0) return VK_ERROR_OUT_OF_HOST_MEMORY;
    shim.sets_left -= shim.sets_left > 0;
    return reinterpret_cast<PFN_vkAllocateDescriptorSets>(real_sets)(d, info, set);
}

VKAPI_ATTR void VKAPI_CALL barrier(VkCommandBuffer c, VkPipelineStageFlags from, VkPipelineStageFlags to,
                                   VkDependencyFlags flags, uint32_t count, const VkMemoryBarrier* memory,
                                   uint32_t buffers, const VkBufferMemoryBarrier* buffer, uint32_t images,
                                   const VkImageMemoryBarrier* image) {
    record_waiting(c);
    if (shim.barriers) {
        const VkMemoryBarrier first = count ? *memory : VkMemoryBarrier{};
        shim.barriers->push_back({from, to, first.srcAccessMask, first.dstAccessMask});
    }
    reinterpret_cast<PFN_vkCmdPipelineBarrier>(real_barrier)(c, from, to, flags, count, memory, buffers, buffer, images,
                                                             image);
}

VKAPI_ATTR void VKAPI_CALL copy(VkCommandBuffer c, VkBuffer from, VkBuffer to, uint32_t count,
                                const VkBufferCopy* regions) {
    for (uint32_t i = 0; i < count; ++i) shim.copied += regions[i].size;
    reinterpret_cast<PFN_vkCmdCopyBuffer>(real_copy)(c, from, to, count, regions);
}

VKAPI_ATTR void VKAPI_CALL dispatch(VkCommandBuffer c, uint32_t x, uint32_t y, uint32_t z) {
    shim.groups += uint64_t(x) * y * z;
    next.x = x, next.y = y, next.z = z;
    if (shim.reversed) waiting.push_back(next);
    else reinterpret_cast<PFN_vkCmdDispatch>(real_dispatch)(c, x, y, z);
}

VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue q, uint32_t count, const VkSubmitInfo* info, VkFence fence) {
    const uint64_t groups = std::exchange(shim.groups, 0);
    if (shim.submissions) shim.submissions->push_back(groups);
    return reinterpret_cast<PFN_vkQueueSubmit>(real_submit)(q, count, info, fence);
}

bool begins(const char* name, const char* with) { return std::strncmp(name, with, std::strlen(with)) == 0; }

bool makes(const char* name) { return begins(name, "vkCreate") || begins(name, "vkAllocate"); }

// Whether Vulkan says that a call which fails has done nothing: it made no object, or lacked memory for a submission.
bool does_nothing(const char* name, VkResult code) {
    const bool memory = code == VK_ERROR_OUT_OF_HOST_MEMORY || code == VK_ERROR_OUT_OF_DEVICE_MEMORY;
    return makes(name) || (memory && std::strcmp(name, "vkQueueSubmit") == 0);
}

// Whether a call that fails loses its device, so that none follows it. A wait that is over before its time does not.
bool loses(const char* name, VkResult code) {
    return (std::strcmp(name, "vkWaitForFences") == 0 && code != VK_TIMEOUT) ||
           std::strcmp(name, "vkResetFences") == 0 ||
           (std::strcmp(name, "vkQueueSubmit") == 0 && !does_nothing(name, code));
}

// Whether this call fails.
bool strikes(const char* name) {
    Fault& f = shim.fault;
    if (std::strcmp(f.call, any_call) != 0 && std::strcmp(name, f.call) != 0) return false;
    if (f.struck) return f.sticky || --f.times > 0;
    if ((f.made && does_nothing(name, f.code)) || (f.sticky && loses(name, f.code))) return false;
    if (f.before-- > 0) return false;
    f.struck = name;
    return true;
}

template <class T> uint64_t number(T* handle) { return uint64_t(reinterpret_cast<uintptr_t>(handle)); }

template <class... A> auto last_of(A... a) { return std::get<sizeof...(A) - 1>(std::tuple(a...)); }
template <class First, class... A> First first_of(First first, A...) { return first; }

// Whether an argument is a place for handles.
template <class T, class To = std::remove_pointer_t<T>>
inline constexpr bool takes_handle =
    std::is_pointer_v<T>&& std::is_pointer_v<To> && !std::is_const_v<To> && !std::is_same_v<To, void*>;

// Where the last argument takes a handle, it has an undefined value after a failure, but for those functions of which
// Vulkan says that it is null.
template <class... A> void leave_undefined(const char* name, A... a) {
    using Last = decltype(last_of(a...));
    if constexpr (takes_handle<Last>) {
        const bool null = begins(name, "vkAllocateDescriptor") || begins(name, "vkAllocateCommand") ||
                          begins(name, "vkCreateComputePipelines");
        if (makes(name))
            *last_of(a...) = reinterpret_cast<std::remove_pointer_t<Last>>(uintptr_t(null ? 0 : 0xdead'dead'dead));
    }
}

// Writes into the ledger what the library was told.
template <class... A> void enter(Ledger& ledger, const char* name, VkResult result, A... a) {
    using First = decltype(first_of(a...));
    using Last = decltype(last_of(a...));
    const auto is = [name](const char* other) { return std::strcmp(name, other) == 0; };
    const bool done = result == VK_SUCCESS;
    uint64_t owner = 0;
    if constexpr (std::is_pointer_v<First>) owner = number(first_of(a...));
    if constexpr (std::is_same_v<std::tuple<A...>, std::tuple<VkDevice, uint32_t, const VkFence*, VkBool32, uint64_t>>)
        if (result != VK_TIMEOUT) ledger.waited(owner, number(*std::get<2>(std::tuple(a...))), done);
    if (is("vkResetFences") && !done) ledger.lose(owner);
    if constexpr (std::is_same_v<Last, VkFence>)
        if (result != VK_ERROR_OUT_OF_HOST_MEMORY && result != VK_ERROR_OUT_OF_DEVICE_MEMORY)
            ledger.submitted(number(last_of(a...)), done);
    if constexpr (std::is_same_v<Last, VkPhysicalDevice*>)
        for (uint32_t i = 0; last_of(a...) && done && i < *std::get<1>(std::tuple(a...)); ++i)
            ledger.found_device(number(last_of(a...)[i]), owner);
    // What a pool has given goes with the pool.
    if constexpr (takes_handle<Last>)
        if (done && (begins(name, "vkCreate") || is("vkAllocateMemory")))
            ledger.made(name, is("vkCreateInstance") ? 0 : owner, number(*last_of(a...)));
}

std::mutex log_mutex;

// A function that is written down, and fails where it is to.
template <int which, class Function> struct Logged;
template <int which, class R, class... A> struct Logged<which, R(VKAPI_PTR*)(A...)> {
    static inline R(VKAPI_PTR* real)(A...) = nullptr;
    static inline const char* name = "";
    static VKAPI_ATTR R VKAPI_CALL call(A... a) {
        const InDriver driver;
        const LeftToDriver leaks; // what a lost device has allocated
        std::unique_lock lock(log_mutex);
        shim.calls.push_back(name);
        if constexpr (std::is_same_v<R, VkResult>) {
            const bool fails = strikes(name);
            const Fault fault = shim.fault;
            lock.unlock();
            VkResult result = VK_SUCCESS;
            if (!fails || (fault.made && !does_nothing(name, fault.code))) result = real(a...);
            else leave_undefined(name, a...);
            if (fails) result = fault.code;
            lock.lock();
            if (shim.ledger) enter(*shim.ledger, name, result, a...);
            return result;
        } else {
            if constexpr (std::is_same_v<decltype(last_of(a...)), const VkAllocationCallbacks*>)
                if (shim.ledger && !shim.ledger->ended(name, number(std::get<sizeof...(A) - 2>(std::tuple(a...)))))
                    return;
            lock.unlock();
            real(a...);
        }
    }
    static bool take(const char* wanted, const char* own, PFN_vkVoidFunction& f) {
        if (!f || std::strcmp(wanted, own) != 0) return false;
        name = own;
        real = reinterpret_cast<R(VKAPI_PTR*)(A...)>(f);
        f = reinterpret_cast<PFN_vkVoidFunction>(call);
        return true;
    }
};

#define LOGGED(name_) Logged<__COUNTER__, PFN_##name_>::take(name, #name_, f) ||

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_address(VkDevice device, const char* name) {
    const InDriver driver;
    PFN_vkVoidFunction f = reinterpret_cast<PFN_vkGetDeviceProcAddr>(real_device_address)(device, name);
    if (std::strcmp(name, shim.absent) == 0) return nullptr;
    const auto instead = [&](const char* wanted, PFN_vkVoidFunction& keep, auto* ours) {
        if (std::strcmp(name, wanted) != 0) return;
        keep = f;
        f = reinterpret_cast<PFN_vkVoidFunction>(ours);
    };
    instead("vkCreateShaderModule", real_module, module);
    instead("vkAllocateDescriptorSets", real_sets, sets);
    instead("vkCmdPipelineBarrier", real_barrier, barrier);
    instead("vkCmdCopyBuffer", real_copy, copy);
    instead("vkCmdDispatch", real_dispatch, dispatch);
    instead("vkCmdBindPipeline", real_pipeline, bind_pipeline);
    instead("vkCmdBindDescriptorSets", real_set, bind_set);
    instead("vkCmdPushConstants", real_constants, constants);
    instead("vkEndCommandBuffer", real_end, end);
    instead("vkQueueSubmit", real_submit, submit);
    (void)(FAILABLE_DEVICE_CALLS(LOGGED) ENDING_CALLS(LOGGED) RECORDING_CALLS(LOGGED) false);
    return f;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_address(VkInstance instance, const char* name) {
    const InDriver driver;
    PFN_vkVoidFunction f = real_get(instance, name);
    const auto instead = [&](const char* wanted, PFN_vkVoidFunction& keep, auto* ours) {
        if (std::strcmp(name, wanted) != 0) return;
        keep = f;
        f = reinterpret_cast<PFN_vkVoidFunction>(ours);
    };
    if (std::strcmp(name, shim.absent) == 0) return nullptr;
    if (shim.no_driver && std::strcmp(name, "vkCreateInstance") == 0)
        return reinterpret_cast<PFN_vkVoidFunction>(no_instance);
    instead("vkGetPhysicalDeviceQueueFamilyProperties", real_queues, queues);
    instead("vkGetPhysicalDeviceProperties", real_properties, properties);
    instead("vkGetPhysicalDeviceProperties2", real_ids, ids);
    instead("vkEnumeratePhysicalDevices", real_devices, devices);
    instead("vkGetPhysicalDeviceMemoryProperties", real_memory, memory);
    instead("vkEnumerateDeviceExtensionProperties", real_extensions, extensions);
    instead("vkGetDeviceProcAddr", real_device_address, device_address);
    (void)(FAILABLE_INSTANCE_CALLS(LOGGED) ENDING_INSTANCE_CALLS(LOGGED) false);
    return f;
}

} // namespace

vulkan::Loader shimmed() {
    shim = {};
    waiting.clear(); // of a recording that was given up
    return {instance_address, ""};
}

vulkan::Loader faulty(bool Shim::*fault) {
    const vulkan::Loader loader = shimmed();
    shim.*fault = true;
    return loader;
}

} // namespace test
