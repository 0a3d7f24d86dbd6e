// SPDX-License-Identifier: MIT
#include "host/vulkan/context.hpp"

#include "host/loops/model.hpp"

#include <utility>

namespace dermis::vulkan {
namespace {

// A submission holds at most about a second of a software driver's work; one that takes this long is lost.
constexpr uint64_t patience_ns = 60'000'000'000;

static_assert(sizeof(f32::Constants) <= 128, "push constants: 128 bytes are what every device has");

} // namespace

Buffer::Buffer(Context& context, VkDeviceSize bytes, Place place) : context_(&context), bytes_(bytes) {
    const VolkDeviceTable& vk = context.calls();
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage =
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    check(vk.vkCreateBuffer(context.device(), &info, nullptr, &handle_), "vkCreateBuffer");
    try {
        VkMemoryRequirements needs{};
        vk.vkGetBufferMemoryRequirements(context.device(), handle_, &needs);
        VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        allocation.allocationSize = needs.size;
        allocation.memoryTypeIndex = context.memory_type(needs.memoryTypeBits, place);
        check(vk.vkAllocateMemory(context.device(), &allocation, nullptr, &memory_), "vkAllocateMemory");
        check(vk.vkBindBufferMemory(context.device(), handle_, memory_, 0), "vkBindBufferMemory");
        if (place == Place::host)
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
    if (context_->stuck()) return;
    context_->calls().vkDestroyBuffer(context_->device(), handle_, nullptr);
    context_->calls().vkFreeMemory(context_->device(), memory_, nullptr);
}

Kernel::Kernel(Context& context, const uint32_t* code, size_t bytes, uint32_t bindings, uint32_t constants_bytes,
               const std::vector<uint32_t>& specialization, const std::vector<std::vector<const Buffer*>>& sets)
    : context_(context), constants_bytes_(constants_bytes),
      pipeline_(context.pipeline(code, bytes, bindings, constants_bytes, specialization)) {
    const VolkDeviceTable& vk = context.calls();
    const VkDevice device = context.device();
    try {
        const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, uint32_t(bindings * sets.size())};
        VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
        pool_info.maxSets = uint32_t(sets.size());
        pool_info.poolSizeCount = 1;
        pool_info.pPoolSizes = &size;
        check(vk.vkCreateDescriptorPool(device, &pool_info, nullptr, &pool_), "vkCreateDescriptorPool");
        for (const auto& buffers : sets) {
            VkDescriptorSetAllocateInfo allocation{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
            allocation.descriptorPool = pool_;
            allocation.descriptorSetCount = 1;
            allocation.pSetLayouts = &pipeline_.set_layout;
            check(vk.vkAllocateDescriptorSets(device, &allocation, &sets_.emplace_back()), "vkAllocateDescriptorSets");
            std::vector<VkDescriptorBufferInfo> ranges(bindings);
            std::vector<VkWriteDescriptorSet> writes(bindings);
            for (uint32_t i = 0; i < bindings; ++i) {
                ranges[i] = {buffers[i]->handle(), 0, buffers[i]->bytes()};
                writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
                writes[i].dstSet = sets_.back();
                writes[i].dstBinding = i;
                writes[i].descriptorCount = 1;
                writes[i].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
                writes[i].pBufferInfo = &ranges[i];
            }
            vk.vkUpdateDescriptorSets(device, bindings, writes.data(), 0, nullptr);
        }
    } catch (...) {
        vk.vkDestroyDescriptorPool(device, pool_, nullptr);
        throw;
    }
}

Kernel::~Kernel() {
    if (!context_.stuck()) context_.calls().vkDestroyDescriptorPool(context_.device(), pool_, nullptr);
}

void Kernel::record(VkCommandBuffer commands, size_t set, const void* constants, uint32_t x, uint32_t y,
                    uint32_t z) const {
    const VolkDeviceTable& vk = context_.calls();
    vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.pipeline);
    vk.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.layout, 0, 1, &sets_[set], 0,
                               nullptr);
    vk.vkCmdPushConstants(commands, pipeline_.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, constants_bytes_, constants);
    vk.vkCmdDispatch(commands, x, y, z);
}

Context::Context(std::shared_ptr<const Instance> instance, const Physical& physical)
    : instance_(std::move(instance)), physical_(physical) {
    device_ = instance_->open(physical_, calls_);
    try {
        calls_.vkGetDeviceQueue(device_, physical_.family, 0, &queue_);
        VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
        pool.queueFamilyIndex = physical_.family;
        check(calls_.vkCreateCommandPool(device_, &pool, nullptr, &pool_), "vkCreateCommandPool");
        VkCommandBufferAllocateInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        buffer.commandPool = pool_;
        buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
        buffer.commandBufferCount = 1;
        check(calls_.vkAllocateCommandBuffers(device_, &buffer, &commands_), "vkAllocateCommandBuffers");
        const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
        check(calls_.vkCreateFence(device_, &fence, nullptr, &fence_), "vkCreateFence");
        const VkPipelineCacheCreateInfo cache{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
        check(calls_.vkCreatePipelineCache(device_, &cache, nullptr, &cache_), "vkCreatePipelineCache");
    } catch (...) {
        calls_.vkDestroyFence(device_, fence_, nullptr);
        calls_.vkDestroyCommandPool(device_, pool_, nullptr);
        calls_.vkDestroyDevice(device_, nullptr);
        throw;
    }
}

Context::~Context() {
    if (stuck_) { // the driver still works: leave it everything, the instance too
        new std::shared_ptr<const Instance>(std::move(instance_));
        return;
    }
    for (const auto& [key, pipeline] : pipelines_) destroy(pipeline);
    calls_.vkDestroyPipelineCache(device_, cache_, nullptr);
    calls_.vkDestroyFence(device_, fence_, nullptr);
    calls_.vkDestroyCommandPool(device_, pool_, nullptr);
    calls_.vkDestroyDevice(device_, nullptr);
}

const Pipeline& Context::pipeline(const uint32_t* code, size_t bytes, uint32_t bindings, uint32_t constants_bytes,
                                  const std::vector<uint32_t>& specialization) {
    const auto [entry, fresh] = pipelines_.try_emplace({code, specialization});
    Pipeline& made = entry->second;
    if (!fresh) return made;
    VkShaderModule module = VK_NULL_HANDLE;
    try {
        std::vector<VkDescriptorSetLayoutBinding> slots(bindings);
        for (uint32_t i = 0; i < bindings; ++i)
            slots[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
        VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
        set_info.bindingCount = bindings;
        set_info.pBindings = slots.data();
        check(calls_.vkCreateDescriptorSetLayout(device_, &set_info, nullptr, &made.set_layout),
              "vkCreateDescriptorSetLayout");

        const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, constants_bytes};
        VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
        layout_info.setLayoutCount = 1;
        layout_info.pSetLayouts = &made.set_layout;
        layout_info.pushConstantRangeCount = 1;
        layout_info.pPushConstantRanges = &range;
        check(calls_.vkCreatePipelineLayout(device_, &layout_info, nullptr, &made.layout), "vkCreatePipelineLayout");

        VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        module_info.codeSize = bytes;
        module_info.pCode = code;
        check(calls_.vkCreateShaderModule(device_, &module_info, nullptr, &module), "vkCreateShaderModule");

        std::vector<VkSpecializationMapEntry> entries;
        for (uint32_t i = 0; i < specialization.size(); ++i) entries.push_back({i, i * 4, 4});
        const VkSpecializationInfo special{uint32_t(entries.size()), entries.data(), specialization.size() * 4,
                                           specialization.data()};
        VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
        info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
        info.stage.module = module;
        info.stage.pName = "main";
        info.stage.pSpecializationInfo = &special;
        info.layout = made.layout;
        check(calls_.vkCreateComputePipelines(device_, cache_, 1, &info, nullptr, &made.pipeline),
              "vkCreateComputePipelines");

    } catch (...) {
        calls_.vkDestroyShaderModule(device_, module, nullptr);
        destroy(made);
        pipelines_.erase(entry);
        throw;
    }
    calls_.vkDestroyShaderModule(device_, module, nullptr);
    return made;
}

void Context::destroy(const Pipeline& p) const {
    calls_.vkDestroyPipeline(device_, p.pipeline, nullptr);
    calls_.vkDestroyPipelineLayout(device_, p.layout, nullptr);
    calls_.vkDestroyDescriptorSetLayout(device_, p.set_layout, nullptr);
}

VkDeviceSize Context::heap_bytes() const {
    VkDeviceSize largest = 0;
    for (uint32_t i = 0; i < physical_.memory.memoryHeapCount; ++i)
        if (physical_.memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
            largest = std::max(largest, physical_.memory.memoryHeaps[i].size);
    return largest;
}

uint32_t Context::memory_type(uint32_t allowed, Buffer::Place place) const {
    constexpr VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const std::vector<VkMemoryPropertyFlags> wishes =
        place == Buffer::Place::device
            ? std::vector<VkMemoryPropertyFlags>{VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0}
            : std::vector<VkMemoryPropertyFlags>{host | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, host};
    for (VkMemoryPropertyFlags wish : wishes)
        for (uint32_t i = 0; i < physical_.memory.memoryTypeCount; ++i)
            if (allowed >> i & 1 && (physical_.memory.memoryTypes[i].propertyFlags & wish) == wish) return i;
    throw Error(Error::Code::device, "", physical_.info.name + " has no memory type for these buffers");
}

VkCommandBuffer Context::begin() {
    if (stuck_)
        throw Error(Error::Code::device, "", physical_.info.name + " has not come back from an earlier submission");
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(calls_.vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer");
    return commands_;
}

void Context::submit() {
    check(calls_.vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
    VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands_;
    check(calls_.vkQueueSubmit(queue_, 1, &info, fence_), "vkQueueSubmit");
    const VkResult waited = calls_.vkWaitForFences(device_, 1, &fence_, VK_TRUE, patience_ns);
    stuck_ = waited == VK_TIMEOUT;
    check(waited, "vkWaitForFences");
    check(calls_.vkResetFences(device_, 1, &fence_), "vkResetFences");
}

void Context::barrier(VkCommandBuffer commands) const {
    constexpr VkPipelineStageFlags stages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    VkMemoryBarrier all{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    all.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    all.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                        VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_HOST_READ_BIT;
    calls_.vkCmdPipelineBarrier(commands, stages, stages | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &all, 0, nullptr, 0,
                                nullptr);
}

} // namespace dermis::vulkan
