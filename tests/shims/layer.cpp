// SPDX-License-Identifier: MIT
// The layer's functions, between the loader or the next layer above and the driver or the next one below.
#include "tests/shims/shims.hpp"

#include "host/core/simd/model.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <string_view>

#include <vulkan/vk_layer.h>

#define EXPORTED extern "C" __attribute__((visibility("default")))

namespace shims {
namespace {

using Functions = std::map<std::string_view, PFN_vkVoidFunction>; // nothing is allocated to find one
const Functions& instance_functions();
const Functions& device_functions();

// Finds the functions of the next layer that have the same names as these. That is done while the chain is made: later
// the loader answers with the chain's top.
template <class Get, class Handle> Functions below(Get get, Handle handle, const Functions& names) {
    Functions found;
    for (const auto& [name, own] : names) found[name] = get(handle, name.data());
    return found;
}

struct InstanceBelow {
    VkInstance handle;
    PFN_vkGetInstanceProcAddr get;
    Functions functions;
};

struct DeviceBelow {
    VkPhysicalDevice physical;
    PFN_vkGetDeviceProcAddr get;
    Functions functions;
    VkPhysicalDeviceLimits limits; // as they seem to be
};

std::recursive_mutex mutex;
std::map<void*, InstanceBelow> instances;
std::map<void*, DeviceBelow> devices;
Memory memories;
std::map<VkShaderModule, bool> variable_groups;
// The sizes that a program has asked for where the layer has made a workgroup another one.
std::map<VkPipeline, uint32_t> group_of, rows_of, pads_of;
std::map<VkCommandBuffer, VkPipeline> bound;

// Instance, physical devices of it, or a device, its queues and command buffers share the first word.
template <class Handle> void* key(Handle handle) { return *reinterpret_cast<void**>(handle); }
template <class Handle> const InstanceBelow& instance_of(Handle handle) {
    const std::lock_guard lock(mutex);
    return instances.at(key(handle));
}
template <class Handle> const DeviceBelow& device_of(Handle handle) {
    const std::lock_guard lock(mutex);
    return devices.at(key(handle));
}
#define BELOW(handle, name) reinterpret_cast<PFN_##name>(handle##_of(handle).functions.at(#name))

// Finds the link to the next layer among what the loader has chained to an Info.
template <class Link, class Info> Link* link_of(const Info* info, VkStructureType type) {
    auto* next = reinterpret_cast<Link*>(const_cast<void*>(info->pNext));
    while (next && !(next->sType == type && next->function == VK_LAYER_LINK_INFO))
        next = reinterpret_cast<Link*>(const_cast<void*>(next->pNext));
    if (!next) broken("the loader has given the layer no link to the next one");
    return next;
}

VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* a,
                                               VkInstance* made) {
    auto* link = link_of<VkLayerInstanceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    const PFN_vkGetInstanceProcAddr get = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(get(nullptr, "vkCreateInstance"));
    const VkResult result = create(info, a, made);
    if (result == VK_SUCCESS) {
        const std::lock_guard lock(mutex);
        instances[key(*made)] = {*made, get, below(get, *made, instance_functions())};
    }
    return result;
}

VKAPI_ATTR void VKAPI_CALL destroy_instance(VkInstance instance, const VkAllocationCallbacks* a) {
    if (!instance) return;
    BELOW(instance, vkDestroyInstance)(instance, a);
}

VKAPI_ATTR void VKAPI_CALL properties(VkPhysicalDevice instance, VkPhysicalDeviceProperties* out) {
    BELOW(instance, vkGetPhysicalDeviceProperties)(instance, out);
    change(*out);
}

VKAPI_ATTR void VKAPI_CALL properties2(VkPhysicalDevice instance, VkPhysicalDeviceProperties2* out) {
    BELOW(instance, vkGetPhysicalDeviceProperties2)(instance, out);
    change(out->properties);
    for (auto* next = static_cast<VkBaseOutStructure*>(out->pNext); next; next = next->pNext) {
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES)
            change(*reinterpret_cast<VkPhysicalDeviceSubgroupProperties*>(next));
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES)
            change(*reinterpret_cast<VkPhysicalDeviceFloatControlsProperties*>(next));
    }
}

VKAPI_ATTR void VKAPI_CALL memory(VkPhysicalDevice instance, VkPhysicalDeviceMemoryProperties* out) {
    BELOW(instance, vkGetPhysicalDeviceMemoryProperties)(instance, out);
    change(*out);
}

VKAPI_ATTR void VKAPI_CALL memory2(VkPhysicalDevice instance, VkPhysicalDeviceMemoryProperties2* out) {
    BELOW(instance, vkGetPhysicalDeviceMemoryProperties2)(instance, out);
    change(out->memoryProperties);
}

VKAPI_ATTR void VKAPI_CALL queues(VkPhysicalDevice instance, uint32_t* count, VkQueueFamilyProperties* out) {
    BELOW(instance, vkGetPhysicalDeviceQueueFamilyProperties)(instance, count, out);
    for (uint32_t i = 0; out && i < *count; ++i) change(out[i]);
}

VKAPI_ATTR void VKAPI_CALL queues2(VkPhysicalDevice instance, uint32_t* count, VkQueueFamilyProperties2* out) {
    BELOW(instance, vkGetPhysicalDeviceQueueFamilyProperties2)(instance, count, out);
    for (uint32_t i = 0; out && i < *count; ++i) change(out[i].queueFamilyProperties);
}

VKAPI_ATTR VkResult VKAPI_CALL extensions(VkPhysicalDevice instance, const char* layer, uint32_t* count,
                                          VkExtensionProperties* out) {
    if (layer && std::strcmp(layer, "VK_LAYER_DERMIS_shim") == 0) return *count = 0, VK_SUCCESS;
    const auto all = BELOW(instance, vkEnumerateDeviceExtensionProperties);
    if (!is(Kind::least)) return all(instance, layer, count, out);
    uint32_t n = 0;
    all(instance, layer, &n, nullptr);
    std::vector<VkExtensionProperties> list(n);
    all(instance, layer, &n, list.data());
    std::erase_if(list, [](auto& e) { return std::strcmp(e.extensionName, "VK_KHR_shader_float_controls") == 0; });
    const uint32_t room = out ? *count : 0;
    *count = out ? std::min(room, uint32_t(list.size())) : uint32_t(list.size());
    if (out) std::copy_n(list.begin(), *count, out);
    return out && room < list.size() ? VK_INCOMPLETE : VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice instance, const VkDeviceCreateInfo* info,
                                             const VkAllocationCallbacks* a, VkDevice* made) {
    auto* link = link_of<VkLayerDeviceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    const PFN_vkGetInstanceProcAddr get_instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    const PFN_vkGetDeviceProcAddr get = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create =
        reinterpret_cast<PFN_vkCreateDevice>(get_instance(instance_of(instance).handle, "vkCreateDevice"));
    VkPhysicalDeviceFeatures features = info->pEnabledFeatures ? *info->pEnabledFeatures : VkPhysicalDeviceFeatures{};
    VkDeviceCreateInfo wanted = *info;
    if (is(Kind::contracting)) { // it computes in double
        features.shaderFloat64 = VK_TRUE;
        wanted.pEnabledFeatures = &features;
    }
    const VkResult result = create(instance, &wanted, a, made);
    if (result == VK_SUCCESS) {
        VkPhysicalDeviceProperties p{};
        properties(instance, &p);
        const std::lock_guard lock(mutex);
        devices[key(*made)] = {instance, get, below(get, *made, device_functions()), p.limits};
    }
    return result;
}

VKAPI_ATTR void VKAPI_CALL destroy_device(VkDevice device, const VkAllocationCallbacks* a) {
    if (!device) return;
    BELOW(device, vkDestroyDevice)(device, a);
}

VKAPI_ATTR VkResult VKAPI_CALL allocate(VkDevice device, const VkMemoryAllocateInfo* info,
                                        const VkAllocationCallbacks* a, VkDeviceMemory* made) {
    if (!Memory::changed()) return BELOW(device, vkAllocateMemory)(device, info, a, made);
    VkPhysicalDeviceMemoryProperties real{}, seeming{};
    const VkPhysicalDevice instance = device_of(device).physical;
    BELOW(instance, vkGetPhysicalDeviceMemoryProperties)(instance, &real);
    seeming = real;
    change(seeming);
    VkMemoryAllocateInfo wanted = *info;
    wanted.memoryTypeIndex = Memory::real_type(real);
    const VkResult result = BELOW(device, vkAllocateMemory)(device, &wanted, a, made);
    const std::lock_guard lock(mutex);
    if (result == VK_SUCCESS)
        memories.allocated(*made, seeming.memoryTypes[info->memoryTypeIndex].propertyFlags, info->allocationSize);
    return result;
}

VKAPI_ATTR void VKAPI_CALL free_memory(VkDevice device, VkDeviceMemory m, const VkAllocationCallbacks* a) {
    BELOW(device, vkFreeMemory)(device, m, a);
    const std::lock_guard lock(mutex);
    if (Memory::changed()) memories.freed(m);
}

VKAPI_ATTR VkResult VKAPI_CALL map(VkDevice device, VkDeviceMemory m, VkDeviceSize offset, VkDeviceSize bytes,
                                   VkMemoryMapFlags flags, void** data) {
    const VkResult result = BELOW(device, vkMapMemory)(device, m, offset, bytes, flags, data);
    const std::lock_guard lock(mutex);
    if (result == VK_SUCCESS && Memory::changed()) *data = memories.mapped(m, offset, bytes, *data);
    return result;
}

VKAPI_ATTR void VKAPI_CALL unmap(VkDevice device, VkDeviceMemory m) {
    BELOW(device, vkUnmapMemory)(device, m);
    const std::lock_guard lock(mutex);
    if (Memory::changed()) memories.unmapped(m);
}

// The driver's memory is coherent: there is nothing to do below.
VkResult copy(VkDevice device, uint32_t count, const VkMappedMemoryRange* ranges, bool to_device) {
    const std::lock_guard lock(mutex);
    for (uint32_t i = 0; Memory::changed() && i < count; ++i)
        memories.copy(ranges[i], device_of(device).limits.nonCoherentAtomSize, to_device);
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL flush(VkDevice device, uint32_t count, const VkMappedMemoryRange* ranges) {
    return copy(device, count, ranges, true);
}

VKAPI_ATTR VkResult VKAPI_CALL invalidate(VkDevice device, uint32_t count, const VkMappedMemoryRange* ranges) {
    return copy(device, count, ranges, false);
}

VKAPI_ATTR void VKAPI_CALL requirements(VkDevice device, VkBuffer buffer, VkMemoryRequirements* out) {
    BELOW(device, vkGetBufferMemoryRequirements)(device, buffer, out);
    change(*out);
}

VKAPI_ATTR void VKAPI_CALL requirements2(VkDevice device, const VkBufferMemoryRequirementsInfo2* info,
                                         VkMemoryRequirements2* out) {
    BELOW(device, vkGetBufferMemoryRequirements2)(device, info, out);
    change(out->memoryRequirements);
}

// The next three hold a program to the limits, because software drivers do not.
VKAPI_ATTR VkResult VKAPI_CALL set_layout(VkDevice device, const VkDescriptorSetLayoutCreateInfo* info,
                                          const VkAllocationCallbacks* a, VkDescriptorSetLayout* made) {
    uint32_t buffers = 0;
    for (uint32_t i = 0; i < info->bindingCount; ++i)
        if (info->pBindings[i].descriptorType == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER)
            buffers += info->pBindings[i].descriptorCount;
    if (buffers > device_of(device).limits.maxPerStageDescriptorStorageBuffers)
        broken("a shader has " + std::to_string(buffers) + " storage buffers, more than the limit");
    return BELOW(device, vkCreateDescriptorSetLayout)(device, info, a, made);
}

VKAPI_ATTR VkResult VKAPI_CALL view(VkDevice device, const VkBufferViewCreateInfo* info, const VkAllocationCallbacks* a,
                                    VkBufferView* made) {
    const VkPhysicalDeviceLimits limits = device_of(device).limits;
    if (info->offset % limits.minTexelBufferOffsetAlignment != 0)
        broken("a view of texels begins at " + std::to_string(info->offset) + ", at no multiple of the alignment");
    if (info->range / 16 > limits.maxTexelBufferElements) broken("a view has more texels than the limit");
    return BELOW(device, vkCreateBufferView)(device, info, a, made);
}

VKAPI_ATTR void VKAPI_CALL update(VkDevice device, uint32_t count, const VkWriteDescriptorSet* writes, uint32_t copies,
                                  const VkCopyDescriptorSet* copied) {
    const VkPhysicalDeviceLimits limits = device_of(device).limits;
    for (uint32_t i = 0; i < count; ++i)
        for (uint32_t k = 0; k < writes[i].descriptorCount; ++k) {
            if (writes[i].descriptorType != VK_DESCRIPTOR_TYPE_STORAGE_BUFFER) continue;
            const VkDescriptorBufferInfo& range = writes[i].pBufferInfo[k];
            if (range.offset % limits.minStorageBufferOffsetAlignment != 0)
                broken("a buffer is bound at " + std::to_string(range.offset) + ", at no multiple of the alignment");
            if (range.range > limits.maxStorageBufferRange)
                broken(std::to_string(range.range) + " bytes of a buffer are bound, more than the limit");
        }
    BELOW(device, vkUpdateDescriptorSets)(device, count, writes, copies, copied);
}

VKAPI_ATTR VkResult VKAPI_CALL module(VkDevice device, const VkShaderModuleCreateInfo* info,
                                      const VkAllocationCallbacks* a, VkShaderModule* made) {
    const std::vector<uint32_t> code = change(info->pCode, info->codeSize / 4);
    VkShaderModuleCreateInfo wanted = *info;
    wanted.pCode = code.data();
    wanted.codeSize = code.size() * 4;
    const VkResult result = BELOW(device, vkCreateShaderModule)(device, &wanted, a, made);
    const std::lock_guard lock(mutex);
    if (result == VK_SUCCESS) variable_groups[*made] = has_variable_groups(info->pCode, info->codeSize / 4);
    return result;
}

// The library makes one pipeline at a time; several at once would keep their workgroups.
VKAPI_ATTR VkResult VKAPI_CALL pipeline(VkDevice device, VkPipelineCache cache, uint32_t count,
                                        const VkComputePipelineCreateInfo* info, const VkAllocationCallbacks* a,
                                        VkPipeline* made) {
    const auto create = BELOW(device, vkCreateComputePipelines);
    const std::lock_guard lock(mutex);
    if (!is(Kind::groups) || count != 1 || !variable_groups[info->stage.module])
        return create(device, cache, count, info, a, made);
    const VkSpecializationInfo& given = *info->stage.pSpecializationInfo;
    std::vector<uint32_t> values(given.dataSize / 4);
    std::memcpy(values.data(), given.pData, given.dataSize);
    const uint32_t x = values[VARIANT_GROUP_X], y = values[VARIANT_GROUP_Y], z = values[VARIANT_GROUP_Z];
    values[VARIANT_GROUP_X] = chosen().number;
    values[VARIANT_GROUP_Y] = 1;
    uint32_t pads = z; // as many of them as leave a workgroup with 128 invocations at most
    while (pads > 1 && (z % pads != 0 || pads * chosen().number > 128)) --pads;
    values[VARIANT_GROUP_Z] = pads;
    VkSpecializationInfo special = given;
    special.pData = values.data();
    VkComputePipelineCreateInfo wanted = *info;
    wanted.stage.pSpecializationInfo = &special;
    const VkResult result = create(device, cache, 1, &wanted, a, made);
    if (result == VK_SUCCESS) group_of[*made] = x, rows_of[*made] = y, pads_of[*made] = z / pads;
    return result;
}

VKAPI_ATTR void VKAPI_CALL destroy_pipeline(VkDevice device, VkPipeline p, const VkAllocationCallbacks* a) {
    BELOW(device, vkDestroyPipeline)(device, p, a);
    const std::lock_guard lock(mutex);
    group_of.erase(p);
}

VKAPI_ATTR void VKAPI_CALL bind_pipeline(VkCommandBuffer device, VkPipelineBindPoint point, VkPipeline p) {
    BELOW(device, vkCmdBindPipeline)(device, point, p);
    const std::lock_guard lock(mutex);
    bound[device] = p;
}

VKAPI_ATTR void VKAPI_CALL dispatch(VkCommandBuffer device, uint32_t x, uint32_t y, uint32_t z) {
    const uint32_t* most = device_of(device).limits.maxComputeWorkGroupCount;
    {
        const std::lock_guard lock(mutex);
        const VkPipeline p = bound[device];
        if (group_of.count(p)) {
            const uint32_t along = (x * group_of[p] + chosen().number - 1) / chosen().number;
            if (along <= most[0]) x = along;
            else y *= group_of[p] / chosen().number; // a kernel that reads a list counts its groups along both axes
            y *= rows_of[p];
            z *= pads_of[p];
        }
    }
    if (x > most[0] || y > most[1] || z > most[2]) broken("a dispatch has more workgroups than the limit");
    BELOW(device, vkCmdDispatch)(device, x, y, z);
}

template <class F> PFN_vkVoidFunction plain(F* f) { return reinterpret_cast<PFN_vkVoidFunction>(f); }

const Functions& device_functions() {
    static const Functions own = {{"vkDestroyDevice", plain(destroy_device)},
                                  {"vkAllocateMemory", plain(allocate)},
                                  {"vkFreeMemory", plain(free_memory)},
                                  {"vkMapMemory", plain(map)},
                                  {"vkUnmapMemory", plain(unmap)},
                                  {"vkFlushMappedMemoryRanges", plain(flush)},
                                  {"vkInvalidateMappedMemoryRanges", plain(invalidate)},
                                  {"vkGetBufferMemoryRequirements", plain(requirements)},
                                  {"vkGetBufferMemoryRequirements2", plain(requirements2)},
                                  {"vkCreateDescriptorSetLayout", plain(set_layout)},
                                  {"vkCreateBufferView", plain(view)},
                                  {"vkUpdateDescriptorSets", plain(update)},
                                  {"vkCreateShaderModule", plain(module)},
                                  {"vkCreateComputePipelines", plain(pipeline)},
                                  {"vkDestroyPipeline", plain(destroy_pipeline)},
                                  {"vkCmdBindPipeline", plain(bind_pipeline)},
                                  {"vkCmdDispatch", plain(dispatch)}};
    return own;
}

const Functions& instance_functions() {
    static const Functions own = {{"vkCreateInstance", plain(create_instance)},
                                  {"vkDestroyInstance", plain(destroy_instance)},
                                  {"vkCreateDevice", plain(create_device)},
                                  {"vkEnumerateDeviceExtensionProperties", plain(extensions)},
                                  {"vkGetPhysicalDeviceProperties", plain(properties)},
                                  {"vkGetPhysicalDeviceProperties2", plain(properties2)},
                                  {"vkGetPhysicalDeviceProperties2KHR", plain(properties2)},
                                  {"vkGetPhysicalDeviceMemoryProperties", plain(memory)},
                                  {"vkGetPhysicalDeviceMemoryProperties2", plain(memory2)},
                                  {"vkGetPhysicalDeviceMemoryProperties2KHR", plain(memory2)},
                                  {"vkGetPhysicalDeviceQueueFamilyProperties", plain(queues)},
                                  {"vkGetPhysicalDeviceQueueFamilyProperties2", plain(queues2)},
                                  {"vkGetPhysicalDeviceQueueFamilyProperties2KHR", plain(queues2)}};
    return own;
}

// Returns the layer's own function of this name, or null.
PFN_vkVoidFunction found(const Functions& functions, const char* name) {
    const auto own = functions.find(name);
    return own == functions.end() ? nullptr : own->second;
}

} // namespace
} // namespace shims

EXPORTED VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vkGetDeviceProcAddr(VkDevice device, const char* name) {
    if (std::strcmp(name, "vkGetDeviceProcAddr") == 0) return shims::plain(vkGetDeviceProcAddr);
    if (const PFN_vkVoidFunction own = shims::found(shims::device_functions(), name)) return own;
    return shims::device_of(device).get(device, name);
}

EXPORTED VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL vkGetInstanceProcAddr(VkInstance instance, const char* name) {
    if (std::strcmp(name, "vkGetInstanceProcAddr") == 0) return shims::plain(vkGetInstanceProcAddr);
    if (std::strcmp(name, "vkGetDeviceProcAddr") == 0) return shims::plain(vkGetDeviceProcAddr);
    if (const PFN_vkVoidFunction own = shims::found(shims::instance_functions(), name)) return own;
    if (const PFN_vkVoidFunction own = shims::found(shims::device_functions(), name)) return own;
    return instance ? shims::instance_of(instance).get(instance, name) : nullptr;
}
