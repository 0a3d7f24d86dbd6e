// SPDX-License-Identifier: MIT
// Compute pipelines over storage buffers, on a device that is ours or somebody else's.
#pragma once

#include "host/vulkan/modules.hpp"
#include "host/vulkan/volk.hpp"

#include <map>
#include <utility>
#include <vector>

namespace dermis::vulkan {

// Throws Error::device naming the call unless the result is success.
void check(VkResult, const char* call);

// A device as pipelines and recording need it.
struct DeviceTable {
    VkDevice device = VK_NULL_HANDLE;
    VolkDeviceTable calls{};
    VkPhysicalDeviceLimits limits{};
    bool rounds = false; // round-to-nearest-even may be declared
    const VkAllocationCallbacks* allocator = nullptr;
    VkPipelineCache cache = VK_NULL_HANDLE;
};

struct Pipeline {
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
};

// Makes each pipeline once, because a driver may take long to make one.
class Pipelines {
  public:
    explicit Pipelines(const DeviceTable& device) : device_(device) {}
    ~Pipelines();
    Pipelines(const Pipelines&) = delete;
    Pipelines& operator=(const Pipelines&) = delete;

    const Pipeline& get(const Module&, uint32_t bindings, uint32_t constants_bytes,
                        const std::vector<uint32_t>& specialization);
    const DeviceTable& device() const { return device_; }
    // The device did not come back: nothing made here may be destroyed any more.
    void abandon() { abandoned_ = true; }
    bool abandoned() const { return abandoned_; }

  private:
    void destroy(const Pipeline&) const;

    const DeviceTable& device_;
    std::map<std::pair<const uint32_t*, std::vector<uint32_t>>, Pipeline> pipelines_;
    bool abandoned_ = false;
};

struct BufferRange {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceSize offset = 0, bytes = 0;
};

// A range at one of the binding numbers of kernels/layout.h.
struct BoundRange {
    uint32_t binding;
    BufferRange range;
};

// A pipeline over storage buffers 0..bindings-1, with constants of so many bytes pushed and at most so many bindings.
class Kernel {
  public:
    Kernel(Pipelines&, const Module&, uint32_t bindings, uint32_t constants_bytes,
           const std::vector<uint32_t>& specialization, uint32_t max_sets);
    ~Kernel();
    Kernel(const Kernel&) = delete;
    Kernel& operator=(const Kernel&) = delete;
    // Sets 0, 1 .. max_sets - 1 in order; every binding has a range. After a failure the same set may be bound again.
    void bind(size_t set, const std::vector<BoundRange>&);
    void record(VkCommandBuffer, size_t set, const void* constants, uint32_t x, uint32_t y) const noexcept;

  private:
    Pipelines& pipelines_;
    uint32_t constants_bytes_;
    Pipeline pipeline_;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    std::vector<VkDescriptorSet> sets_;
};

} // namespace dermis::vulkan
