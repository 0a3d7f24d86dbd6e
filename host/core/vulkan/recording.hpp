// SPDX-License-Identifier: MIT
// Commands that are recorded, submitted and waited for, a submission's worth of work at a time.
#pragma once

#include "host/core/vulkan/context.hpp"

namespace dermis::vulkan {

// Each recording has a command buffer of its own. Between two calls of one recording, others may therefore be made on
// the same device, for example by a progress callback that presses a skin.
class Recording {
  public:
    explicit Recording(Context& context) : context_(context) {}
    ~Recording();                               // waits
    Recording& operator=(Recording&&) = delete; // and no copies

    // These functions throw Error::device if the device is lost or a call fails; the message names the call.
    VkCommandBuffer begin();    // waits, and is ready to record; what was recorded and not submitted is given up
    VkCommandBuffer commands(); // the same command buffer, with what has been recorded; begins where nothing has
    // Counts work that is recorded next (see DeviceTable::most_work). If it is too much for one submission, submits
    // what has been recorded so far and begins the same command buffer again.
    void add(double work);
    void start(); // submits, with a barrier behind all, and does not wait
    void wait();  // for what was started, if it has not been waited for
    void submit() { start(), wait(); }
    void barrier() { context_.barrier(commands()); }
    bool empty() const { return !open_; }

  private:
    Context& context_;
    VkCommandBuffer commands_ = VK_NULL_HANDLE; // once something has been recorded
    VkFence fence_ = VK_NULL_HANDLE;            // of commands_
    bool open_ = false;                         // commands_ holds commands that have not been submitted
    bool started_ = false;                      // or ones that have not been waited for
    double work_ = 0;                           // of these commands
};

} // namespace dermis::vulkan
