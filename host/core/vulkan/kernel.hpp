// SPDX-License-Identifier: MIT
// Compute pipelines over buffers, on the library's own device or an embedding host's.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/base/process.hpp"
#include "host/core/vulkan/ending.hpp"
#include "host/core/vulkan/modules.hpp"
#include "host/core/vulkan/volk.hpp"

#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dermis::vulkan {

// The message of a call that failed: its name and result.
std::string failure(VkResult, const char* call);
// Throws Error::device with that message unless the result is success.
void check(VkResult, const char* call);
// The same for a call that makes an object. A failure leaves the object's handle undefined; it is then set to null.
template <class Handle> void check_made(VkResult result, const char* call, Handle& handle) {
    if (result != VK_SUCCESS) handle = VK_NULL_HANDLE;
    check(result, call);
}

// The list that a call gives by its count first: call(&count, list or null).
template <class Item, class Call> std::vector<Item> listed(const char* name, Call call) {
    uint32_t count = 0;
    check(call(&count, nullptr), name);
    std::vector<Item> list(count);
    check(call(&count, list.data()), name);
    return list;
}

// The handle, functions and limits of a device that pipelines and recording use.
struct DeviceTable {
    VkDevice device = VK_NULL_HANDLE;
    VolkDeviceTable calls{};
    VkPhysicalDeviceLimits limits{};
    FloatRules floats;   // that kernels declare
    bool texels = false; // kernels read maps as texel buffers where they have a variant for that
    const VkAllocationCallbacks* allocator = nullptr;
    VkPipelineCache cache = VK_NULL_HANDLE;
    // The most work of one submission, in numbers that kernels write or sum up. No limit where a host submits.
    double most_work = std::numeric_limits<double>::infinity();
};

struct Pipeline {
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
};

// A cache of pipelines, because a driver may take long to make one: all that kernels use, and at most 128 others.
class Pipelines {
  public:
    explicit Pipelines(const DeviceTable& device) : device_(device) {}
    ~Pipelines();
    Pipelines& operator=(Pipelines&&) = delete; // and no copies

    static constexpr size_t most_unused = 128;
    std::shared_ptr<const Pipeline> get(const Module&, const std::vector<uint32_t>& specialization);
    const DeviceTable& device() const { return device_; }
    // Keeps every pipeline from being destroyed, after its device is lost.
    void abandon() { abandoned_ = true; }
    // A use of the driver that destroys objects; false if all objects of the device are left to the driver: it is lost,
    // or was opened by another process, or the process is ending.
    Use use() const { return Use(!abandoned_ && process_.calls()); }
    const simd::Process& process() const { return process_; }
    bool take_fresh() { return std::exchange(fresh_, false); } // whether pipelines have been made since the last call

  private:
    void destroy(const Pipeline&) const;
    void drop_unused();

    const DeviceTable& device_;
    std::map<std::pair<const uint32_t*, std::vector<uint32_t>>, std::shared_ptr<const Pipeline>> pipelines_;
    const simd::Process process_;
    bool abandoned_ = false, fresh_ = false;
};

// Records a memory barrier.
inline void barrier(const VolkDeviceTable& vk, VkCommandBuffer commands, const Access& from, const Access& to) {
    const VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, from.access, to.access};
    vk.vkCmdPipelineBarrier(commands, from.stages, to.stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

struct BufferRange {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceSize offset = 0, bytes = 0;
};

// A buffer range and the binding number (kernels/layout.h) that it is bound to.
struct BoundRange {
    uint32_t binding;
    BufferRange range;
};

// A pipeline over buffers with its push constants and descriptor sets.
class Kernel {
  public:
    // specialization: constant 0, 1 .. max_sets: of descriptor sets.
    Kernel(Pipelines&, const Module&, const std::vector<uint32_t>& specialization, uint32_t max_sets);
    ~Kernel();
    Kernel& operator=(Kernel&&) = delete; // and no copies
    // Fills a descriptor set; sets are filled in the order 0, 1 .. max_sets - 1 and have a range for every binding.
    // After a failure the same set may be filled again.
    void bind(size_t set, const std::vector<BoundRange>&);
    // Dispatches x times y times z workgroups.
    void record(VkCommandBuffer, size_t set, const void* constants, uint32_t x, uint32_t y,
                uint32_t z = 1) const noexcept;

  private:
    void destroy_views(std::vector<VkBufferView>&) const;

    Pipelines& pipelines_;
    uint32_t constants_bytes_, texels_; // see Module
    std::shared_ptr<const Pipeline> pipeline_;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    std::vector<VkDescriptorSet> sets_;
    std::vector<std::vector<VkBufferView>> views_; // of each set, for its texel buffers
};

} // namespace dermis::vulkan
