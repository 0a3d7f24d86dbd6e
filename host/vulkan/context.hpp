// SPDX-License-Identifier: MIT
// One logical device: queue, memory, pipelines, submission. One thread at a time.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/vulkan/instance.hpp"

#include <memory>

namespace dermis::vulkan {

class Context;

// A buffer with its own memory. On the device, or where the host can read and write it.
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
    void* data() const { return data_; } // Location::host

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
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    const PhysicalDevice& physical() const { return physical_; }
    Handles handles() const; // as a stranger would hand them to a SkinProgram
    Pipelines& pipelines() { return *pipelines_; }
    const VkPhysicalDeviceLimits& limits() const { return physical_.properties.limits; }
    VkDeviceSize heap_bytes() const; // of the largest device-local heap
    const VolkDeviceTable& calls() const { return device_.calls; }
    VkDevice device() const { return device_.device; }
    uint32_t memory_type(uint32_t allowed, Buffer::Location) const;

    VkCommandBuffer begin(); // the one command buffer, ready to record
    void submit();           // ends it, submits it and waits
    // Everything recorded before is finished and visible to everything recorded after, and to the host.
    void barrier(VkCommandBuffer) const;
    // After a submission that did not come back nothing may be destroyed: it is left to the driver.
    bool stuck() const { return stuck_; }

  private:
    std::shared_ptr<const Instance> instance_;
    PhysicalDevice physical_;
    DeviceTable device_;
    std::unique_ptr<Pipelines> pipelines_;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    bool stuck_ = false;
};

} // namespace dermis::vulkan
