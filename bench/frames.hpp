// SPDX-License-Identifier: MIT
// Workload W1, a streamed frame: a new pressure each step, linear between frames, four responses written.
#pragma once

#include "bench/limits.hpp"
#include "host/device.hpp"
#include "host/plan/streamed_skin.hpp"
#include "host/vulkan/context.hpp"

namespace bench {

struct FrameScene {
    explicit FrameScene(int n);
    dermis::plan::StreamedSkin streamed;
    const dermis::plan::PreparedSkin& skin() const { return streamed.skin; }
    double dt = 0.01;           // s, from frame to frame
    std::vector<Floats> frames; // pitch*height, in turn
    size_t cells() const { return skin().padded_cells(); }
};

// The frames on a device: by the library's kernel, by one of one cell per invocation, or as much memory moved alone.
class VulkanFrames {
  public:
    enum class By { press, cell, moves };
    VulkanFrames(const FrameScene&, std::shared_ptr<dermis::vulkan::Context>, By);
    ~VulkanFrames();
    // Records and submits so many frames, waits. Seconds on the device.
    double press(int frames);
    double recording() const { return recording_; } // seconds of the host to record each of the last frames
    std::vector<float> response(int r);             // pitch*height of SA1, SA2, FA1, FA2

    // Seconds to copy a map of the frames on the device, so many times.
    double copy(int times);

  private:
    template <class Record> double timed(Record&&);
    const FrameScene& scene_;
    std::shared_ptr<dermis::vulkan::Context> context_;
    std::vector<dermis::vulkan::Buffer> buffers_;
    std::unique_ptr<dermis::vulkan::Kernel> kernel_;
    VkQueryPool stamps_ = VK_NULL_HANDLE;
    By by_;
    int frame_ = 0;
    double recording_ = 0;
};

} // namespace bench
