// SPDX-License-Identifier: MIT
// One press of one skin: a new pressure each step, linear between frames, four responses written.
#pragma once

#include "bench/limits.hpp"
#include "host/core/model/streamed_skin.hpp"
#include "host/core/press/device.hpp"
#include "host/core/vulkan/recording.hpp"

#include <array>

namespace bench {

struct FrameScene {
    explicit FrameScene(int n, const dermis::Material& = {});
    dermis::model::StreamedSkin streamed;
    const dermis::model::PreparedSkin& skin() const { return streamed.skin; }
    double dt = 0.01;           // s, from frame to frame
    std::vector<Floats> frames; // pitch*height each, used cyclically
    size_t cells() const { return skin().padded_cells(); }
};

// Moves the memory of a frame on the CPU and computes next to nothing. There are two ways to write responses, past the
// caches and through them; the time of the faster one is a lower limit for every kernel.
class CpuMoves {
  public:
    CpuMoves(const FrameScene&, int threads, bool past_caches);
    void press(int frames);

  private:
    const FrameScene& scene_;
    const bool past_caches_;
    dermis::simd::Pool pool_;
    Floats rest_, strain_, integral_;
    std::array<Floats, 4> responses_;
    size_t frame_ = 0;
};

// Presses the frames on a device by the library's kernel, or by one that only moves the same memory.
class VulkanFrames {
  public:
    enum class Shader { press, moves };
    VulkanFrames(const FrameScene&, std::shared_ptr<dermis::vulkan::Context>, Shader);
    ~VulkanFrames();
    // Records `frames` frames, submits them and waits. Returns seconds on the device.
    double press(int frames);
    double recording() const { return recording_; } // seconds of the host to record one of the last frames, on average
    std::vector<float> response(int r);             // pitch*height values; r = 0 .. 3: SA1, SA2, FA1, FA2

  private:
    template <class Record> double timed(Record&&);
    const FrameScene& scene_;
    std::shared_ptr<dermis::vulkan::Context> context_;
    std::vector<dermis::vulkan::Buffer> buffers_;
    std::unique_ptr<dermis::vulkan::Kernel> kernel_;
    VkQueryPool stamps_ = VK_NULL_HANDLE;
    int frame_ = 0;
    double recording_ = 0;
};

} // namespace bench
