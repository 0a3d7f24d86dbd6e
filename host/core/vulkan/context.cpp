// SPDX-License-Identifier: MIT
#include "host/core/vulkan/context.hpp"

#include <utility>

namespace dermis::vulkan {

Buffer::Buffer(Context& context, VkDeviceSize bytes, Location location) : context_(&context), bytes_(bytes) {
    const VolkDeviceTable& vk = context.calls();
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (context.pipelines().device().texels) info.usage |= VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    check(vk.vkCreateBuffer(context.device(), &info, nullptr, &handle_), "vkCreateBuffer");
    try {
        VkMemoryRequirements needs{};
        vk.vkGetBufferMemoryRequirements(context.device(), handle_, &needs);
        VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        allocation.allocationSize = needs.size;
        allocation.memoryTypeIndex = context.memory_type(needs.memoryTypeBits, location);
        check_made(vk.vkAllocateMemory(context.device(), &allocation, nullptr, &memory_), "vkAllocateMemory", memory_);
        check(vk.vkBindBufferMemory(context.device(), handle_, memory_, 0), "vkBindBufferMemory");
        if (location == Location::host)
            check(vk.vkMapMemory(context.device(), memory_, 0, VK_WHOLE_SIZE, 0, &data_), "vkMapMemory");
    } catch (...) {
        vk.vkDestroyBuffer(context.device(), handle_, nullptr);
        vk.vkFreeMemory(context.device(), memory_, nullptr);
        throw;
    }
}

Buffer::Buffer(Buffer&& other) noexcept
    : context_(other.context_), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)),
      memory_(std::exchange(other.memory_, VK_NULL_HANDLE)), bytes_(other.bytes_), data_(other.data_) {}

Buffer::~Buffer() {
    const Use use = context_->pipelines().use();
    if (!use) return;
    context_->calls().vkDestroyBuffer(context_->device(), handle_, nullptr);
    context_->calls().vkFreeMemory(context_->device(), memory_, nullptr);
}

Context::Context(std::shared_ptr<const Instance> instance, const PhysicalDevice& physical)
    : instance_(std::move(instance)), physical_(physical) {
    const Use use(physical_.info.name);
    instance_->open(physical_, device_);
    const VkDevice device = device_.device;
    const VolkDeviceTable& vk = device_.calls;
    try {
        vk.vkGetDeviceQueue(device, physical_.family, 0, &queue_);
        VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
        pool.queueFamilyIndex = physical_.family;
        check_made(vk.vkCreateCommandPool(device, &pool, nullptr, &pool_), "vkCreateCommandPool", pool_);
        const VkPipelineCacheCreateInfo cache{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
        check_made(vk.vkCreatePipelineCache(device, &cache, nullptr, &device_.cache), "vkCreatePipelineCache",
                   device_.cache);
        pipelines_ = std::make_unique<Pipelines>(device_);
        if (!end_before_drivers()) throw std::bad_alloc();
        add_open(this);
    } catch (...) {
        vk.vkDestroyPipelineCache(device, device_.cache, nullptr);
        vk.vkDestroyCommandPool(device, pool_, nullptr);
        vk.vkDestroyDevice(device, nullptr);
        throw;
    }
}

Context::~Context() {
    const VolkDeviceTable& vk = device_.calls;
    const VkDevice device = device_.device;
    // The driver may still use every object, the instance too: they are left to it.
    const Use use = pipelines_->use();
    remove_open(this);
    if (!use) {
        simd::leave(instance_);
        return;
    }
    pipelines_.reset();
    vk.vkDestroyPipelineCache(device, device_.cache, nullptr);
    vk.vkDestroyCommandPool(device, pool_, nullptr);
    vk.vkDestroyDevice(device, nullptr);
}

Handles Context::handles() const {
    Handles h;
    h.instance = instance_->handle();
    h.physical = physical_.handle;
    h.device = device_.device;
    h.get_instance_proc_addr = instance_->get();
    h.extensions = physical_.extensions;
    h.cache = device_.cache;
    return h;
}

VkDeviceSize Context::heap_bytes() const {
    VkDeviceSize largest = 0;
    for (uint32_t i = 0; i < physical_.memory.memoryHeapCount; ++i)
        if (physical_.memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
            largest = std::max(largest, physical_.memory.memoryHeaps[i].size);
    return largest;
}

uint32_t Context::memory_type(uint32_t allowed, Buffer::Location location) const {
    constexpr VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const std::vector<VkMemoryPropertyFlags> wishes =
        location == Buffer::Location::device
            ? std::vector<VkMemoryPropertyFlags>{VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0}
            : std::vector<VkMemoryPropertyFlags>{host | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, host};
    for (VkMemoryPropertyFlags wish : wishes)
        for (uint32_t i = 0; i < physical_.memory.memoryTypeCount; ++i)
            if (allowed >> i & 1 && (physical_.memory.memoryTypes[i].propertyFlags & wish) == wish) return i;
    throw Error(Error::Code::device, "", physical_.info.name + " has no memory type for these buffers");
}

Use Context::need_working() const {
    if (!pipelines_->process().calls()) pipelines_->process().refuse(physical_.info.name + " was");
    if (lost())
        throw Error(Error::Code::device, "",
                    physical_.info.name + " is lost since " + failure(lost_.result, lost_.call) + "; open it again");
    return Use(physical_.info.name);
}

void Context::wait_idle() const {
    if (pipelines_->process().calls() && !lost()) device_.calls.vkDeviceWaitIdle(device_.device);
}

void Context::check_submitted(VkResult result, const char* call) {
    if (result != VK_SUCCESS) {
        lost_ = {call, result};
        pipelines_->abandon();
    }
    check(result, call);
}

void Context::submit(VkCommandBuffer commands, VkFence fence) {
    VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands;
    const VkResult submitted = device_.calls.vkQueueSubmit(queue_, 1, &info, fence);
    // Only the two errors of memory promise that nothing was submitted.
    const bool nothing = submitted == VK_ERROR_OUT_OF_HOST_MEMORY || submitted == VK_ERROR_OUT_OF_DEVICE_MEMORY;
    if (nothing) check(submitted, "vkQueueSubmit");
    check_submitted(submitted, "vkQueueSubmit");
}

void Context::wait(VkFence fence) {
    // A driver that answers is at work, and says itself when its device is lost. A clock could not tell: it goes on
    // while a process is stopped, and jumps when it is set.
    VkResult waited = VK_TIMEOUT;
    while (waited == VK_TIMEOUT) waited = device_.calls.vkWaitForFences(device_.device, 1, &fence, VK_TRUE, UINT64_MAX);
    check_submitted(waited, "vkWaitForFences");
    // A fence that stays signalled would end the next wait before its submission.
    check_submitted(device_.calls.vkResetFences(device_.device, 1, &fence), "vkResetFences");
}

void Context::barrier(VkCommandBuffer commands) const {
    constexpr VkPipelineStageFlags stages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    constexpr VkAccessFlags written = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    vulkan::barrier(device_.calls, commands, {stages, written},
                    {stages | VK_PIPELINE_STAGE_HOST_BIT,
                     written | VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_HOST_READ_BIT});
}

} // namespace dermis::vulkan
