// SPDX-License-Identifier: MIT
// Commands that are recorded, submitted and waited for, a submission's worth of work at a time.
#pragma once

#include "host/core/vulkan/context.hpp"

namespace dermis::vulkan {

// A command buffer of its own: other recordings of the same device, made between two calls of this one, as by a
// progress callback that presses a skin, change nothing of it.
class Recording {
  public:
    explicit Recording(Context& context) : context_(context) {}
    ~Recording();
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;

    // These functions throw Error::device if the device is lost, and naming a call that failed.
    VkCommandBuffer begin();    // ready to record; what has been recorded and not submitted is given up
    VkCommandBuffer commands(); // the same command buffer, with what has been recorded; begins where nothing has
    // Counts work that is recorded next (see DeviceTable::most_work). Where that is too much for one submission,
    // submits what stands recorded and begins the same command buffer again.
    void add(double work);
    void submit(); // and waits
    void barrier() { context_.barrier(commands()); }
    bool empty() const { return !open_; }

  private:
    Context& context_;
    VkCommandBuffer commands_ = VK_NULL_HANDLE; // once something has been recorded
    bool open_ = false;                         // commands_ holds what has not been submitted
    double work_ = 0;                           // of that
};

} // namespace dermis::vulkan
