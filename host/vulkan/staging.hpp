// SPDX-License-Identifier: MIT
// Work that is recorded into one command buffer until it is submitted, and values on their way to the device.
#pragma once

#include "host/vulkan/context.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {

// The command buffer of a context, begun when something is to be recorded.
class Recording {
  public:
    explicit Recording(Context& context) : context_(context) {}
    VkCommandBuffer commands() {
        if (!commands_) commands_ = context_.begin();
        return commands_;
    }
    bool empty() const { return !commands_; }
    void submit() {
        context_.submit();
        commands_ = VK_NULL_HANDLE;
    }
    // Everything recorded before is finished and visible to everything recorded after, and to the host.
    void barrier() { context_.barrier(commands()); }

  private:
    Context& context_;
    VkCommandBuffer commands_ = VK_NULL_HANDLE; // while recording
};

// Copies values to buffers in the order of what is recorded. A host buffer holds them until the next submission.
class Staging {
  public:
    Staging(Context& context, Recording& recording) : context_(context), recording_(recording) {}

    // make_room: called where the host buffer is full; it submits what is recorded and calls reuse().
    template <class T, class MakeRoom> void copy(const std::vector<T>& values, const Buffer& to, MakeRoom make_room) {
        const VkDeviceSize bytes = values.size() * sizeof(T);
        if (!host_)
            host_ =
                std::make_unique<Buffer>(context_, std::clamp(bytes, least_bytes, most_bytes), Buffer::Location::host);
        for (VkDeviceSize done = 0; done < bytes;) {
            if (used_ == host_->bytes()) make_room();
            const VkDeviceSize part = std::min(bytes - done, host_->bytes() - used_);
            std::memcpy(static_cast<char*>(host_->data()) + used_, reinterpret_cast<const char*>(values.data()) + done,
                        part);
            const VkBufferCopy region{used_, done, part};
            context_.calls().vkCmdCopyBuffer(recording_.commands(), host_->handle(), to.handle(), 1, &region);
            recording_.barrier();
            used_ += part;
            done += part;
        }
    }

    // After a submission the host buffer is free again.
    void reuse() { used_ = 0; }

  private:
    static constexpr VkDeviceSize least_bytes = 1 << 16, most_bytes = 16 << 20;
    Context& context_;
    Recording& recording_;
    std::unique_ptr<Buffer> host_;
    VkDeviceSize used_ = 0; // bytes
};

} // namespace dermis::vulkan
