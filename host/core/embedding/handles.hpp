// SPDX-License-Identifier: MIT
// Checks the Vulkan handles of an embedding host.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/vulkan/instance.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {

[[noreturn]] inline void lacks(const char* parameter, const std::string& what) {
    throw Error(Error::Code::bad_input, parameter, what);
}

template <class Function> Function function(const Handles& h, const char* name) {
    const auto f = reinterpret_cast<Function>(h.get_instance_proc_addr(h.instance, name));
    if (!f) lacks("get_instance_proc_addr", std::string("get_instance_proc_addr finds no ") + name);
    return f;
}

inline bool enabled(const Handles& h, const char* extension) {
    return std::find(h.extensions.begin(), h.extensions.end(), extension) != h.extensions.end();
}

inline void check_given(const Handles& h) {
    for (const auto& [parameter, there] : {std::pair{"instance", h.instance != nullptr},
                                           {"physical", h.physical != nullptr},
                                           {"device", h.device != nullptr},
                                           {"get_instance_proc_addr", h.get_instance_proc_addr != nullptr}})
        if (!there) scene::refuse(parameter, "null", "a handle of the host's own device");
}

inline void check_version(const Handles& h, const VkPhysicalDeviceProperties& properties) {
    const auto version = [](uint32_t v) {
        return std::to_string(VK_API_VERSION_MAJOR(v)) + "." + std::to_string(VK_API_VERSION_MINOR(v));
    };
    const uint32_t least = requirements().api_version;
    for (uint32_t v : {h.api_version, properties.apiVersion})
        if (v < least)
            scene::refuse("api_version", version(v), "at least " + version(least) + ", of instance and device");
}

inline void check_extensions(const Handles& h) {
    const auto enumerate =
        function<PFN_vkEnumerateDeviceExtensionProperties>(h, "vkEnumerateDeviceExtensionProperties");
    const auto offered = listed<VkExtensionProperties>(
        "vkEnumerateDeviceExtensionProperties", [&](auto... list) { return enumerate(h.physical, nullptr, list...); });
    for (const char* name : requirements().required_if_offered)
        for (const VkExtensionProperties& e : offered)
            if (std::strcmp(e.extensionName, name) == 0 && !enabled(h, name))
                scene::refuse("extensions", std::string("without ") + name, "with it, because this device offers it");
}

// The functions that set-up or recording calls.
#define CALLS(each)                                                                                                    \
    each(vkAllocateDescriptorSets) each(vkCmdBindDescriptorSets) each(vkCmdBindPipeline) each(vkCmdDispatch)           \
        each(vkCmdPipelineBarrier) each(vkCmdPushConstants) each(vkCmdUpdateBuffer) each(vkCmdWriteTimestamp)          \
            each(vkCreateBufferView) each(vkCreateComputePipelines) each(vkCreateDescriptorPool)                       \
                each(vkCreateDescriptorSetLayout) each(vkCreatePipelineLayout) each(vkCreateShaderModule)              \
                    each(vkDestroyBufferView) each(vkDestroyDescriptorPool) each(vkDestroyDescriptorSetLayout)         \
                        each(vkDestroyPipeline) each(vkDestroyPipelineLayout) each(vkDestroyShaderModule)              \
                            each(vkGetBufferMemoryRequirements) each(vkUpdateDescriptorSets)

// Throws where one of them is missing.
inline void check_calls(const VolkDeviceTable& vk) {
#define NAMED(f) {#f, reinterpret_cast<PFN_vkVoidFunction>(vk.f)},
    const std::pair<const char*, PFN_vkVoidFunction> calls[] = {CALLS(NAMED)};
#undef NAMED
    for (const auto& [name, found] : calls)
        if (!found) lacks("get_instance_proc_addr", std::string("get_instance_proc_addr finds no ") + name);
}

// Checks the handles and returns the device table that recording uses. Throws Error::bad_input, naming what is missing.
inline DeviceTable checked(const Handles& h) {
    check_given(h);
    VkPhysicalDeviceProperties properties{};
    function<PFN_vkGetPhysicalDeviceProperties>(h, "vkGetPhysicalDeviceProperties")(h.physical, &properties);
    check_version(h, properties);
    if (const std::string limit = why_not(properties.limits); !limit.empty())
        lacks("physical", std::string(properties.deviceName) + ": " + limit);
    check_extensions(h);
    DeviceTable table;
    table.device = h.device;
    table.limits = properties.limits;
    table.allocator = h.allocator;
    table.cache = h.cache;
    std::vector<std::string> extensions = h.extensions;
    if (std::min(h.api_version, properties.apiVersion) >= VK_API_VERSION_1_2) // which includes the extension
        extensions.push_back(VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME);
    table.floats = float_rules(function<PFN_vkGetPhysicalDeviceProperties2>(h, "vkGetPhysicalDeviceProperties2"),
                               h.physical, extensions);
    table.texels = reads_texels(properties);
    function<PFN_vkGetDeviceProcAddr>(h, "vkGetDeviceProcAddr");
    load_calls(h.get_instance_proc_addr, h.instance, table);
    check_calls(table.calls);
    return table;
}

// The functions that label commands; null where the host has not enabled VK_EXT_debug_utils.
struct Labels {
    PFN_vkCmdBeginDebugUtilsLabelEXT begin = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT end = nullptr;
};
inline Labels labels_of(const Handles& h) {
    if (!enabled(h, VK_EXT_DEBUG_UTILS_EXTENSION_NAME)) return {};
    return {function<PFN_vkCmdBeginDebugUtilsLabelEXT>(h, "vkCmdBeginDebugUtilsLabelEXT"),
            function<PFN_vkCmdEndDebugUtilsLabelEXT>(h, "vkCmdEndDebugUtilsLabelEXT")};
}

} // namespace dermis::vulkan
