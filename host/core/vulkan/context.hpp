// SPDX-License-Identifier: MIT
// A logical device with its queue, memory, pipelines and submissions. One thread uses it at a time.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/vulkan/instance.hpp"

#include <map>
#include <memory>

namespace dermis::vulkan {

class Context;

// A buffer with memory of its own, on the device or where the host can read and write it.
class Buffer {
  public:
    enum class Location { device, host };
    Buffer(Context&, VkDeviceSize bytes, Location);
    ~Buffer();
    Buffer(Buffer&&) noexcept;
    Buffer& operator=(Buffer&&) = delete;
    VkBuffer handle() const { return handle_; }
    BufferRange all() const { return {handle_, 0, bytes_}; }
    VkDeviceSize bytes() const { return bytes_; }
    void* data() const { return data_; } // the mapped memory of Location::host, otherwise null

  private:
    Context* context_;
    VkBuffer handle_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    VkDeviceSize bytes_;
    void* data_ = nullptr;
};

class Context {
  public:
    Context(std::shared_ptr<const Instance>, const PhysicalDevice&); // throws Error::device
    ~Context();
    Context& operator=(Context&&) = delete; // and no copies

    const PhysicalDevice& physical() const { return physical_; }
    Handles handles() const; // as an embedding host gives them to a SkinProgram
    Pipelines& pipelines() { return *pipelines_; }
    // Returns whether a variant of the kernels has the CPU path's bits on this device; test() says so, once.
    template <class Test> bool exact(const std::vector<uint32_t>& variant, Test test) {
        if (!exact_variants_.contains(variant)) exact_variants_.emplace(variant, test());
        return exact_variants_.at(variant);
    }
    const VkPhysicalDeviceLimits& limits() const { return physical_.properties.limits; }
    VkDeviceSize heap_bytes() const; // size of the largest device-local heap
    const VolkDeviceTable& calls() const { return device_.calls; }
    VkDevice device() const { return device_.device; }
    uint32_t memory_type(uint32_t allowed, Buffer::Location) const;

    VkCommandPool pool() const { return pool_; } // command buffers: see Recording
    // Submits a command buffer that is ended; the fence tells when it and all that was submitted before are done.
    // wait() waits until the driver says so or that the device is lost, and resets the fence. Both throw Error::device
    // naming the call that failed.
    void submit(VkCommandBuffer, VkFence);
    void wait(VkFence);
    // Everything recorded before is finished and visible to everything recorded after, and to the host.
    void barrier(VkCommandBuffer) const;
    // True for ever once a submission, or the wait for it, has failed in any way. The driver may then still use every
    // object, so none is destroyed; nothing more is submitted, and nothing that the device has written is read.
    bool lost() const { return lost_.call != nullptr; }
    // Returns a use of the driver, within which no function of a caller's is called: that may wait for exit(). Throws
    // Error::device, naming the call that failed, if the device is lost, or if another process has opened it.
    [[nodiscard]] Use need_working() const;
    void wait_idle() const; // for all that was submitted

  private:
    void check_submitted(VkResult, const char* call);

    struct Loss {
        const char* call = nullptr;
        VkResult result = VK_SUCCESS;
    };
    std::shared_ptr<const Instance> instance_;
    PhysicalDevice physical_;
    DeviceTable device_;
    std::unique_ptr<Pipelines> pipelines_;
    std::map<std::vector<uint32_t>, bool> exact_variants_;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    Loss lost_;
};

} // namespace dermis::vulkan
