// SPDX-License-Identifier: MIT
// One logical device: queue, memory, pipelines, submission. One thread at a time.
#pragma once

#include "host/vulkan/instance.hpp"

#include <map>
#include <memory>

namespace dermis::vulkan {

constexpr uint32_t storage_buffers_needed = 12; // per stage; `press` uses 11

class Context;

// A buffer with its own memory. On the device, or where the host can read and write it.
class Buffer {
  public:
    enum class Place { device, host };
    Buffer(Context&, VkDeviceSize bytes, Place);
    ~Buffer();
    Buffer(Buffer&&) noexcept;
    Buffer& operator=(Buffer&&) = delete;
    VkBuffer handle() const { return handle_; }
    VkDeviceSize bytes() const { return bytes_; }
    void* data() const { return data_; } // Place::host

  private:
    Context* context_;
    VkBuffer handle_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    VkDeviceSize bytes_;
    void* data_ = nullptr;
};

// A compute pipeline; its context keeps it, because a driver may take long to make one.
struct Pipeline {
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
};

// A pipeline over storage buffers 0..bindings-1, constants of so many bytes pushed, and `sets` descriptor sets.
class Kernel {
  public:
    Kernel(Context&, const uint32_t* code, size_t bytes, uint32_t bindings, uint32_t constants_bytes,
           const std::vector<uint32_t>& specialization, const std::vector<std::vector<const Buffer*>>& sets);
    ~Kernel();
    Kernel(const Kernel&) = delete;
    Kernel& operator=(const Kernel&) = delete;
    void record(VkCommandBuffer, size_t set, const void* constants, uint32_t x, uint32_t y, uint32_t z) const;

  private:
    Context& context_;
    uint32_t constants_bytes_;
    Pipeline pipeline_;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    std::vector<VkDescriptorSet> sets_;
};

class Context {
  public:
    Context(std::shared_ptr<const Instance>, const Physical&); // throws Error::device
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    const Physical& physical() const { return physical_; }
    // Made once for each code and specialization.
    const Pipeline& pipeline(const uint32_t* code, size_t bytes, uint32_t bindings, uint32_t constants_bytes,
                             const std::vector<uint32_t>& specialization);
    const VkPhysicalDeviceLimits& limits() const { return physical_.properties.limits; }
    VkDeviceSize heap_bytes() const; // of the largest device-local heap
    const VolkDeviceTable& calls() const { return calls_; }
    VkDevice device() const { return device_; }
    uint32_t memory_type(uint32_t allowed, Buffer::Place) const;

    VkCommandBuffer begin(); // the one command buffer, ready to record
    void submit();           // ends it, submits it and waits
    // Everything recorded before is finished and visible to everything recorded after, and to the host.
    void barrier(VkCommandBuffer) const;
    // After a submission that did not come back nothing may be destroyed: it is left to the driver.
    bool stuck() const { return stuck_; }

  private:
    void destroy(const Pipeline&) const;

    std::shared_ptr<const Instance> instance_;
    Physical physical_;
    VolkDeviceTable calls_{};
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    VkPipelineCache cache_ = VK_NULL_HANDLE;
    std::map<std::pair<const uint32_t*, std::vector<uint32_t>>, Pipeline> pipelines_;
    bool stuck_ = false;
};

} // namespace dermis::vulkan
