// SPDX-License-Identifier: MIT
#include "host/core/vulkan/instance.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/simd/model.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {
namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";

[[noreturn]] void no_device(const std::string& what) { throw Error(Error::Code::no_device, "", what); }

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    const std::string id = data->pMessageIdName ? data->pMessageIdName : ""; // not every layer's messages begin with it
    static_cast<const InstanceOptions*>(user)->validation(id + ": " + data->pMessage);
    return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info(const InstanceOptions& options) {
    VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    info.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT;
    info.pfnUserCallback = on_message;
    info.pUserData = const_cast<InstanceOptions*>(&options);
    return info;
}

bool offers(const std::vector<VkExtensionProperties>& list, const char* name) {
    return std::any_of(list.begin(), list.end(), [=](auto& e) { return std::strcmp(e.extensionName, name) == 0; });
}

const char* kind_of(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return "software";
    default: return "other";
    }
}

int rank(const PhysicalDevice& p) {
    constexpr VkPhysicalDeviceType order[] = {VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU,
                                              VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU,
                                              VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU, VK_PHYSICAL_DEVICE_TYPE_OTHER};
    return int(std::find(std::begin(order), std::end(order), p.properties.deviceType) - std::begin(order));
}

} // namespace

Requirements requirements() {
    Requirements r;
    r.storage_buffers = std::max(PRESS_BINDINGS, REDUCE_BINDINGS);
    r.required_if_offered = {"VK_KHR_portability_subset"};
    r.used_if_enabled = {VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME};
    r.used_if_enabled_instance = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    return r;
}

std::string why_not(const VkPhysicalDeviceLimits& limits) {
    const auto lacks = [](const char* limit, uint32_t value, uint32_t needed) {
        return std::string(limit) + " = " + std::to_string(value) + "; " + std::to_string(needed) + " are needed";
    };
    const uint32_t buffers = requirements().storage_buffers, invocations = std::max({PRESS_X * PRESS_Y, SITES_X});
    if (limits.maxPerStageDescriptorStorageBuffers < buffers)
        return lacks("maxPerStageDescriptorStorageBuffers", limits.maxPerStageDescriptorStorageBuffers, buffers);
    if (limits.maxComputeWorkGroupInvocations < invocations)
        return lacks("maxComputeWorkGroupInvocations", limits.maxComputeWorkGroupInvocations, invocations);
    return "";
}

FloatRules float_rules(PFN_vkGetPhysicalDeviceProperties2 get, VkPhysicalDevice device,
                       const std::vector<std::string>& enabled) {
    if (std::find(enabled.begin(), enabled.end(), VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME) == enabled.end())
        return {};
    VkPhysicalDeviceFloatControlsProperties floats{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FLOAT_CONTROLS_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    properties.pNext = &floats;
    get(device, &properties);
    return {.rounds_to_even = floats.shaderRoundingModeRTEFloat32 == VK_TRUE,
            .keeps_nans = floats.shaderSignedZeroInfNanPreserveFloat32 == VK_TRUE};
}

bool reads_texels(const VkPhysicalDeviceProperties& device) {
    constexpr VkDeviceSize texel = 4 * sizeof(float);
    const VkPhysicalDeviceLimits& limits = device.limits;
    return device.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU &&
           limits.maxTexelBufferElements >= limits.maxStorageBufferRange / texel &&
           limits.minTexelBufferOffsetAlignment <= limits.minStorageBufferOffsetAlignment;
}

std::mutex& volk_mutex() {
    static std::mutex mutex;
    return mutex;
}

void load_calls(PFN_vkGetInstanceProcAddr get, VkInstance instance, DeviceTable& table) {
    const std::lock_guard lock(volk_mutex());
    volkInitializeCustom(get);
    volkLoadInstanceOnly(instance);
    volkLoadDeviceTable(&table.calls, table.device);
}

Loader system_loader() {
    const std::lock_guard lock(volk_mutex());
    // volk knows the library's name on each system, and never closes it: a loader must outlive its drivers' threads.
    if (volkInitialize() != VK_SUCCESS) return {nullptr, "no Vulkan loader (libvulkan.so.1 is not installed)"};
    return {vkGetInstanceProcAddr, {}};
}

Instance::Instance(const InstanceOptions& options, PFN_vkGetInstanceProcAddr get) : options_(options), get_(get) {}

Instance::Instance(const Loader& loader, const InstanceOptions& options) : Instance(options, loader.get) {
    if (!loader.get) no_device(loader.missing);
    const DefaultFloats guard; // a software driver's threads inherit the floating-point environment
    // Drivers stay loaded, and a child that is forked has none of their threads: NVIDIA's spins for ever in a new
    // instance, and lavapipe's cache of shaders waits.
    static const simd::Process loading;
    if (!loading.calls()) loading.refuse("a Vulkan driver was");
    const Use use("a Vulkan driver");
    const std::lock_guard lock(volk_mutex());
    volkInitializeCustom(loader.get);
    if (!vkCreateInstance || !vkEnumerateInstanceExtensionProperties)
        no_device("the Vulkan loader lacks vkCreateInstance");

    const auto extensions = listed<VkExtensionProperties>("vkEnumerateInstanceExtensionProperties", [](auto... list) {
        return vkEnumerateInstanceExtensionProperties(nullptr, list...);
    });
    std::vector<const char*> enabled;
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.pApplicationName = application.pEngineName = "dermis";
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    if (offers(extensions, VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
        enabled.push_back(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
        info.flags |= VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
    }
    const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronization;
    VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(options_);
    if (options_.validation) {
        enabled.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &validation_layer;
        features.pNext = &messenger;
        info.pNext = &features;
    }
    info.enabledExtensionCount = uint32_t(enabled.size());
    info.ppEnabledExtensionNames = enabled.data();
    const VkResult created = vkCreateInstance(&info, nullptr, &handle_);
    if (created == VK_ERROR_INCOMPATIBLE_DRIVER)
        no_device("the Vulkan loader finds no driver (on Debian: mesa-vulkan-drivers) that it can load; "
                  "VK_LOADER_DEBUG=error names the driver and the cause, such as a library that NVIDIA's driver lacks "
                  "(on Debian: libegl1)");
    if (created == VK_ERROR_LAYER_NOT_PRESENT)
        no_device(std::string("the layer ") + validation_layer + " is not installed");
    check(created, "vkCreateInstance");
    volkLoadInstanceOnly(handle_);
    destroy_ = vkDestroyInstance;
    destroy_messenger_ = vkDestroyDebugUtilsMessengerEXT;
    if (options_.validation)
        check_made(vkCreateDebugUtilsMessengerEXT(handle_, &messenger, nullptr, &messenger_),
                   "vkCreateDebugUtilsMessengerEXT", messenger_);
    find_devices();
    if (!end_before_drivers()) throw std::bad_alloc();
}

Instance::~Instance() {
    const Use use;
    if (!use) return;
    if (messenger_) destroy_messenger_(handle_, messenger_, nullptr);
    if (destroy_) destroy_(handle_, nullptr);
}

void Instance::find_devices() {
    const auto handles = listed<VkPhysicalDevice>(
        "vkEnumeratePhysicalDevices", [&](auto... list) { return vkEnumeratePhysicalDevices(handle_, list...); });
    if (handles.empty()) no_device("the Vulkan loader finds no device");
    for (VkPhysicalDevice handle : handles) {
        PhysicalDevice p;
        p.handle = handle;
        describe(p);
        devices_.push_back(p);
    }
    std::stable_sort(devices_.begin(), devices_.end(), [](auto& a, auto& b) { return rank(a) < rank(b); });
}

// Fills in name, kind, driver and limits, and the reason where the kernels cannot run on the device.
void Instance::describe(PhysicalDevice& p) const {
    VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceIDProperties id{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    vkGetPhysicalDeviceProperties(p.handle, &p.properties);
    if (p.properties.apiVersion >= VK_API_VERSION_1_1) {
        properties.pNext = &id;
        if (p.properties.apiVersion >= VK_API_VERSION_1_2) id.pNext = &driver;
        vkGetPhysicalDeviceProperties2(p.handle, &properties);
        for (uint8_t byte : id.deviceUUID) {
            if (const size_t n = p.info.uuid.size(); n == 8 || n == 13 || n == 18 || n == 23) p.info.uuid += '-';
            for (int digit : {byte >> 4, byte & 15}) p.info.uuid += "0123456789abcdef"[digit];
        }
    }
    vkGetPhysicalDeviceMemoryProperties(p.handle, &p.memory);
    p.info.name = p.properties.deviceName;
    p.info.kind = kind_of(p.properties.deviceType);
    p.info.driver = std::string(driver.driverName) + (driver.driverInfo[0] ? " " : "") + driver.driverInfo;
    p.info.vulkan = true;
    p.info.exact = false; // not known before a self-test

    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(p.handle, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(p.handle, &count, families.data());
    const auto compute = std::find_if(families.begin(), families.end(),
                                      [](auto& f) { return f.queueFlags & VK_QUEUE_COMPUTE_BIT && f.queueCount > 0; });
    p.family = uint32_t(compute - families.begin());

    const VkPhysicalDeviceLimits& limits = p.properties.limits;
    if (p.properties.apiVersion < VK_API_VERSION_1_1) p.info.refused = "Vulkan 1.0; 1.1 is needed";
    else if (compute == families.end()) p.info.refused = "no compute queue";
    else p.info.refused = why_not(limits);
    if (!p.info.refused.empty()) return;
    try {
        const auto extensions =
            listed<VkExtensionProperties>("vkEnumerateDeviceExtensionProperties", [&](auto... list) {
                return vkEnumerateDeviceExtensionProperties(p.handle, nullptr, list...);
            });
        const Requirements needs = requirements();
        for (const auto& list : {needs.required_if_offered, needs.used_if_enabled})
            for (const char* name : list)
                if (offers(extensions, name)) p.extensions.emplace_back(name);
    } catch (const Error& e) {
        p.info.refused = e.what();
        return;
    }
    p.floats = float_rules(vkGetPhysicalDeviceProperties2, p.handle, p.extensions);
}

void Instance::open(const PhysicalDevice& p, DeviceTable& table) const {
    const DefaultFloats guard;
    const auto create = reinterpret_cast<PFN_vkCreateDevice>(get_(handle_, "vkCreateDevice"));
    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = p.family;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    std::vector<const char*> extensions;
    for (const std::string& name : p.extensions) extensions.push_back(name.c_str());
    info.enabledExtensionCount = uint32_t(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    check(create(p.handle, &info, nullptr, &table.device), "vkCreateDevice");
    load_calls(get_, handle_, table);
    table.limits = p.properties.limits;
    table.floats = p.floats;
    table.texels = reads_texels(p.properties);
    table.most_work = options_.most_work;
}

} // namespace dermis::vulkan
