// SPDX-License-Identifier: MIT
#include "gpu.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";

void check(VkResult result, const char* call) {
    if (result != VK_SUCCESS) throw std::runtime_error(std::string(call) + ": " + std::to_string(result));
}

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* messages) {
    ++*static_cast<int*>(messages);
    std::fprintf(stderr, "%s\n", data->pMessage);
    return VK_FALSE;
}

// Those of `wanted` that the device offers.
std::vector<const char*> offered(const std::vector<const char*>& wanted, VkPhysicalDevice physical) {
    uint32_t count = 0;
    check(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr),
          "vkEnumerateDeviceExtensionProperties");
    std::vector<VkExtensionProperties> list(count);
    check(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, list.data()),
          "vkEnumerateDeviceExtensionProperties");
    std::vector<const char*> both;
    for (const char* name : wanted)
        if (std::any_of(list.begin(), list.end(), [&](auto& e) { return std::strcmp(e.extensionName, name) == 0; }))
            both.push_back(name);
    return both;
}

template <class Function> Function function(VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

} // namespace

Gpu::Gpu(const Wanted& wanted, int& messages)
    : messages_(messages), api_version_(std::max(wanted.api_version, VK_API_VERSION_1_2)) {
    try {
        create_instance();
        create_device(wanted);
        create_pools();
    } catch (...) {
        destroy();
        throw;
    }
}

Gpu::~Gpu() { destroy(); }

void Gpu::create_instance() {
    const VkDebugUtilsMessengerCreateInfoEXT messenger{
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity =
            VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = &messages_};
    const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT validation{.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                             .pNext = &messenger, // for the instance's own creation and destruction
                                             .enabledValidationFeatureCount = 1,
                                             .pEnabledValidationFeatures = &synchronization};
    const VkApplicationInfo application{
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "frames", .apiVersion = api_version_};
    const std::vector<const char*> enabled{VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                           VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    extensions_.assign(enabled.begin(), enabled.end());
    const VkInstanceCreateInfo instance{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                        .pNext = &validation,
                                        .pApplicationInfo = &application,
                                        .enabledLayerCount = 1,
                                        .ppEnabledLayerNames = &validation_layer,
                                        .enabledExtensionCount = uint32_t(enabled.size()),
                                        .ppEnabledExtensionNames = enabled.data()};
    check(vkCreateInstance(&instance, nullptr, &instance_), "vkCreateInstance with validation");
    check(function<PFN_vkCreateDebugUtilsMessengerEXT>(instance_, "vkCreateDebugUtilsMessengerEXT")(
              instance_, &messenger, nullptr, &messenger_),
          "vkCreateDebugUtilsMessengerEXT");
}

void Gpu::create_device(const Wanted& wanted) {
    uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(instance_, &count, nullptr), "vkEnumeratePhysicalDevices");
    std::vector<VkPhysicalDevice> found(count);
    check(vkEnumeratePhysicalDevices(instance_, &count, found.data()), "vkEnumeratePhysicalDevices");
    if (std::none_of(found.begin(), found.end(), [&](VkPhysicalDevice p) { return choose(p, wanted); }))
        throw std::runtime_error("no device with a queue for compute, timestamps and timeline semaphores");

    const float priority = 1;
    const VkDeviceQueueCreateInfo queue{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                        .queueFamilyIndex = family_,
                                        .queueCount = 1,
                                        .pQueuePriorities = &priority};
    const VkPhysicalDeviceTimelineSemaphoreFeatures timelines{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES, .timelineSemaphore = VK_TRUE};
    const std::vector<const char*> enabled = offered(wanted.device_extensions, physical_);
    extensions_.insert(extensions_.end(), enabled.begin(), enabled.end());
    const VkDeviceCreateInfo device{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                    .pNext = &timelines,
                                    .queueCreateInfoCount = 1,
                                    .pQueueCreateInfos = &queue,
                                    .enabledExtensionCount = uint32_t(enabled.size()),
                                    .ppEnabledExtensionNames = enabled.data()};
    check(vkCreateDevice(physical_, &device, nullptr, &device_), "vkCreateDevice");
    vkGetDeviceQueue(device_, family_, 0, &queue_);
}

void Gpu::create_pools() {
    const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                       .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                       .queueFamilyIndex = family_};
    check(vkCreateCommandPool(device_, &pool, nullptr, &command_pool_), "vkCreateCommandPool");
    const VkDescriptorPoolSize storage{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 64};
    const VkDescriptorPoolCreateInfo sets{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                          .maxSets = 16,
                                          .poolSizeCount = 1,
                                          .pPoolSizes = &storage};
    check(vkCreateDescriptorPool(device_, &sets, nullptr, &descriptor_pool_), "vkCreateDescriptorPool");
    const VkSemaphoreTypeCreateInfo timeline{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                             .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    const VkSemaphoreCreateInfo semaphore{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &timeline};
    check(vkCreateSemaphore(device_, &semaphore, nullptr, &timeline_), "vkCreateSemaphore");
}

bool Gpu::choose(VkPhysicalDevice physical, const Wanted& wanted) {
    vkGetPhysicalDeviceProperties(physical, &properties_);
    if (properties_.apiVersion < api_version_ ||
        properties_.limits.maxPerStageDescriptorStorageBuffers < wanted.storage_buffers)
        return false;
    VkPhysicalDeviceTimelineSemaphoreFeatures timelines{
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES};
    VkPhysicalDeviceFeatures2 features{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &timelines};
    vkGetPhysicalDeviceFeatures2(physical, &features);
    if (!timelines.timelineSemaphore) return false;
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    const auto family = std::find_if(families.begin(), families.end(), [](const VkQueueFamilyProperties& f) {
        return f.queueFlags & VK_QUEUE_COMPUTE_BIT && f.timestampValidBits > 0;
    });
    if (family == families.end()) return false;
    physical_ = physical;
    family_ = uint32_t(family - families.begin());
    return true;
}

void Gpu::destroy() {
    if (device_) {
        for (VkQueryPool pool : query_pools_) vkDestroyQueryPool(device_, pool, nullptr);
        for (const Shader& shader : shaders_) {
            vkDestroyPipeline(device_, shader.pipeline, nullptr);
            vkDestroyPipelineLayout(device_, shader.layout, nullptr);
            vkDestroyDescriptorSetLayout(device_, shader.buffers, nullptr);
        }
        for (const Buffer& buffer : buffers_) {
            vkDestroyBuffer(device_, buffer.handle, nullptr);
            vkFreeMemory(device_, buffer.memory, nullptr);
        }
        vkDestroySemaphore(device_, timeline_, nullptr);
        vkDestroyDescriptorPool(device_, descriptor_pool_, nullptr);
        vkDestroyCommandPool(device_, command_pool_, nullptr);
        vkDestroyDevice(device_, nullptr);
    }
    if (messenger_)
        function<PFN_vkDestroyDebugUtilsMessengerEXT>(instance_, "vkDestroyDebugUtilsMessengerEXT")(
            instance_, messenger_, nullptr);
    if (instance_) vkDestroyInstance(instance_, nullptr);
}

Buffer Gpu::buffer(VkDeviceSize bytes, VkBufferUsageFlags usage, Place place,
                   const std::vector<unsigned char>& initial) {
    Buffer& b = buffers_.emplace_back();
    b.bytes = bytes;
    const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                  .size = bytes,
                                  .usage = usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    check(vkCreateBuffer(device_, &info, nullptr, &b.handle), "vkCreateBuffer");
    VkMemoryRequirements needs{};
    vkGetBufferMemoryRequirements(device_, b.handle, &needs);
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
    const VkMemoryPropertyFlags flags = place == Place::host
                                            ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT
                                            : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    uint32_t type = 0; // Vulkan promises one of each
    while (!(needs.memoryTypeBits >> type & 1) || (memory.memoryTypes[type].propertyFlags & flags) != flags) ++type;
    const VkMemoryAllocateInfo allocation{
        .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size, .memoryTypeIndex = type};
    check(vkAllocateMemory(device_, &allocation, nullptr, &b.memory), "vkAllocateMemory");
    check(vkBindBufferMemory(device_, b.handle, b.memory, 0), "vkBindBufferMemory");
    const Buffer made = b; // a staging buffer moves the list
    if (place == Place::host) {
        check(vkMapMemory(device_, b.memory, 0, VK_WHOLE_SIZE, 0, &b.data), "vkMapMemory");
        std::memset(b.data, 0, bytes);
        std::copy(initial.begin(), initial.end(), static_cast<unsigned char*>(b.data));
        return b;
    }
    const VkCommandBuffer once = commands();
    begin(once);
    if (initial.empty()) {
        vkCmdFillBuffer(once, made.handle, 0, VK_WHOLE_SIZE, 0);
    } else {
        const Buffer staging = buffer(initial.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Place::host, initial);
        const VkBufferCopy all{.size = initial.size()};
        vkCmdCopyBuffer(once, staging.handle, made.handle, 1, &all);
    }
    barrier(once, copies, {VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT});
    wait(submit(once));
    vkFreeCommandBuffers(device_, command_pool_, 1, &once);
    return made;
}

Shader Gpu::shader(const uint32_t* code, size_t bytes, uint32_t buffers, uint32_t push_bytes) {
    Shader& s = shaders_.emplace_back();
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (uint32_t i = 0; i < buffers; ++i)
        bindings.push_back({i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    const VkDescriptorSetLayoutCreateInfo set{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                              .bindingCount = buffers,
                                              .pBindings = bindings.data()};
    check(vkCreateDescriptorSetLayout(device_, &set, nullptr, &s.buffers), "vkCreateDescriptorSetLayout");
    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, push_bytes};
    const VkPipelineLayoutCreateInfo layout{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                            .setLayoutCount = 1,
                                            .pSetLayouts = &s.buffers,
                                            .pushConstantRangeCount = 1,
                                            .pPushConstantRanges = &push};
    check(vkCreatePipelineLayout(device_, &layout, nullptr, &s.layout), "vkCreatePipelineLayout");
    const VkShaderModuleCreateInfo text{
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = bytes, .pCode = code};
    VkShaderModule module = VK_NULL_HANDLE;
    check(vkCreateShaderModule(device_, &text, nullptr, &module), "vkCreateShaderModule");
    const VkComputePipelineCreateInfo pipeline{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                               .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                         .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                         .module = module,
                                                         .pName = "main"},
                                               .layout = s.layout};
    const VkResult created = vkCreateComputePipelines(device_, VK_NULL_HANDLE, 1, &pipeline, nullptr, &s.pipeline);
    vkDestroyShaderModule(device_, module, nullptr);
    check(created, "vkCreateComputePipelines");
    return s;
}

VkDescriptorSet Gpu::bind(const Shader& shader, std::initializer_list<Buffer> buffers) {
    const VkDescriptorSetAllocateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .descriptorPool = descriptor_pool_,
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &shader.buffers};
    VkDescriptorSet set = VK_NULL_HANDLE;
    check(vkAllocateDescriptorSets(device_, &info, &set), "vkAllocateDescriptorSets");
    std::vector<VkDescriptorBufferInfo> infos;
    for (const Buffer& b : buffers) infos.push_back(b.info());
    const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                     .dstSet = set,
                                     .descriptorCount = uint32_t(infos.size()), // one each, from binding 0 on
                                     .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                     .pBufferInfo = infos.data()};
    vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
    return set;
}

VkQueryPool Gpu::timestamps(uint32_t count) {
    const VkQueryPoolCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = VK_QUERY_TYPE_TIMESTAMP, .queryCount = count};
    VkQueryPool& pool = query_pools_.emplace_back();
    check(vkCreateQueryPool(device_, &info, nullptr, &pool), "vkCreateQueryPool");
    return pool;
}

double Gpu::seconds(VkQueryPool pool, uint32_t first) const {
    uint64_t ticks[2]{};
    check(vkGetQueryPoolResults(device_, pool, first, 2, sizeof ticks, ticks, sizeof ticks[0], VK_QUERY_RESULT_64_BIT),
          "vkGetQueryPoolResults");
    return double(ticks[1] - ticks[0]) * double(properties_.limits.timestampPeriod) * 1e-9;
}

VkCommandBuffer Gpu::commands() {
    const VkCommandBufferAllocateInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                           .commandPool = command_pool_,
                                           .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                           .commandBufferCount = 1};
    VkCommandBuffer made = VK_NULL_HANDLE;
    check(vkAllocateCommandBuffers(device_, &info, &made), "vkAllocateCommandBuffers");
    return made;
}

void Gpu::begin(VkCommandBuffer commands) {
    const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    check(vkBeginCommandBuffer(commands, &info), "vkBeginCommandBuffer");
}

void Gpu::barrier(VkCommandBuffer commands, Scope from, Scope to) {
    const VkMemoryBarrier memory{
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER, .srcAccessMask = from.access, .dstAccessMask = to.access};
    vkCmdPipelineBarrier(commands, from.stages, to.stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

uint64_t Gpu::submit(VkCommandBuffer commands) {
    check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    const uint64_t value = submitted_ + 1;
    const VkTimelineSemaphoreSubmitInfo values{.sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO,
                                               .signalSemaphoreValueCount = 1,
                                               .pSignalSemaphoreValues = &value};
    const VkSubmitInfo info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                            .pNext = &values,
                            .commandBufferCount = 1,
                            .pCommandBuffers = &commands,
                            .signalSemaphoreCount = 1,
                            .pSignalSemaphores = &timeline_};
    check(vkQueueSubmit(queue_, 1, &info, VK_NULL_HANDLE), "vkQueueSubmit");
    return submitted_ = value;
}

void Gpu::wait(uint64_t value) const {
    const VkSemaphoreWaitInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                   .semaphoreCount = 1,
                                   .pSemaphores = &timeline_,
                                   .pValues = &value};
    check(vkWaitSemaphores(device_, &info, UINT64_MAX), "vkWaitSemaphores");
}
