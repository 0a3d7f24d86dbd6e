// SPDX-License-Identifier: MIT
// Values on their way to the device.
#pragma once

#include "host/core/vulkan/recording.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {

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
