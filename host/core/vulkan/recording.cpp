// SPDX-License-Identifier: MIT
#include "host/core/vulkan/recording.hpp"

namespace dermis::vulkan {

Recording::~Recording() {
    const Use use = context_.pipelines().use();
    if (!commands_ || !use) return;
    try {
        wait();
    } catch (const Error&) { // the device is lost
        return;
    }
    context_.calls().vkDestroyFence(context_.device(), fence_, nullptr);
    context_.calls().vkFreeCommandBuffers(context_.device(), context_.pool(), 1, &commands_);
}

VkCommandBuffer Recording::begin() {
    const Use use = context_.need_working();
    wait();
    const VolkDeviceTable& vk = context_.calls();
    if (!commands_) {
        VkCommandBufferAllocateInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        buffer.commandPool = context_.pool();
        buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
        buffer.commandBufferCount = 1;
        check_made(vk.vkAllocateCommandBuffers(context_.device(), &buffer, &commands_), "vkAllocateCommandBuffers",
                   commands_);
    }
    const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr, 0};
    if (!fence_) check_made(vk.vkCreateFence(context_.device(), &fence, nullptr, &fence_), "vkCreateFence", fence_);
    if (open_) check(vk.vkResetCommandBuffer(commands_, 0), "vkResetCommandBuffer");
    work_ = 0;
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vk.vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer");
    open_ = true;
    return commands_;
}

VkCommandBuffer Recording::commands() {
    if (!open_) return begin();
    const Use use = context_.need_working();
    return commands_;
}

void Recording::add(double work) {
    if (work_ > 0 && work_ + work > context_.pipelines().device().most_work) {
        submit();
        begin();
    }
    work_ += work;
}

void Recording::start() {
    const Use use = context_.need_working();
    barrier();
    check(context_.calls().vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
    context_.submit(commands_, fence_);
    open_ = false;
    started_ = true;
}

void Recording::wait() {
    const Use use = context_.need_working();
    if (!started_) return;
    context_.wait(fence_);
    started_ = false;
    if (context_.pipelines().take_fresh()) end_before_drivers();
}

} // namespace dermis::vulkan
