// SPDX-License-Identifier: MIT
// A device, a queue and what is made on it: plain Vulkan, as a simulator has it anyway. Functions throw.
#pragma once

#include <vulkan/vulkan.h>

#include <initializer_list>
#include <string>
#include <vector>

struct Wanted {
    uint32_t api_version = VK_API_VERSION_1_2;  // timeline semaphores
    uint32_t storage_buffers = 4;               // maxPerStageDescriptorStorageBuffers, at least
    std::vector<const char*> device_extensions; // enabled where they are offered
};

struct Buffer {
    VkBuffer handle = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkDeviceSize bytes = 0;
    void* data = nullptr; // mapped, where the host sees it
    VkDescriptorBufferInfo info() const { return {handle, 0, bytes}; }
};

struct Shader {
    VkDescriptorSetLayout buffers = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
};

// A side of a barrier.
struct Scope {
    VkPipelineStageFlags stages = 0;
    VkAccessFlags access = 0;
    constexpr Scope operator|(Scope other) const { return {stages | other.stages, access | other.access}; }
};
inline constexpr Scope shaders{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                               VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
inline constexpr Scope copies{VK_PIPELINE_STAGE_TRANSFER_BIT,
                              VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT};
inline constexpr Scope host_reads{VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};

class Gpu {
  public:
    enum class Place { device, host };

    // Validated, with synchronization; every message is printed and counted, until after the destruction.
    Gpu(const Wanted&, int& messages);
    ~Gpu();
    Gpu(const Gpu&) = delete;
    Gpu& operator=(const Gpu&) = delete;

    VkInstance instance() const { return instance_; }
    VkPhysicalDevice physical() const { return physical_; }
    VkDevice device() const { return device_; }
    uint32_t api_version() const { return api_version_; }
    const std::vector<std::string>& extensions() const { return extensions_; } // enabled, of instance and device
    const VkPhysicalDeviceProperties& properties() const { return properties_; }

    // Holds `initial`, or zeros.
    Buffer buffer(VkDeviceSize bytes, VkBufferUsageFlags, Place, const std::vector<unsigned char>& initial = {});
    Shader shader(const uint32_t* code, size_t bytes, uint32_t buffers, uint32_t push_bytes);
    VkDescriptorSet bind(const Shader&, std::initializer_list<Buffer>);
    VkQueryPool timestamps(uint32_t count);
    double seconds(VkQueryPool, uint32_t first) const; // from `first` to the next
    VkCommandBuffer commands();
    static void begin(VkCommandBuffer);
    uint64_t submit(VkCommandBuffer); // ends it; the value of the timeline when it is done
    void wait(uint64_t value) const;

    static void barrier(VkCommandBuffer, Scope from, Scope to);
    template <class Push>
    static void dispatch(VkCommandBuffer commands, const Shader& shader, VkDescriptorSet set, const Push& push,
                         uint32_t groups_x, uint32_t groups_y = 1) {
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, shader.pipeline);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, shader.layout, 0, 1, &set, 0, nullptr);
        vkCmdPushConstants(commands, shader.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, &push);
        vkCmdDispatch(commands, groups_x, groups_y, 1);
    }

  private:
    void create_instance();
    void create_device(const Wanted&);
    void create_pools(); // and the timeline
    bool choose(VkPhysicalDevice, const Wanted&);
    void destroy();

    int& messages_;
    uint32_t api_version_, family_ = 0;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties_{};
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkCommandPool command_pool_ = VK_NULL_HANDLE;
    VkDescriptorPool descriptor_pool_ = VK_NULL_HANDLE;
    VkSemaphore timeline_ = VK_NULL_HANDLE;
    uint64_t submitted_ = 0;
    std::vector<std::string> extensions_;
    std::vector<Buffer> buffers_;
    std::vector<Shader> shaders_;
    std::vector<VkQueryPool> query_pools_;
};

// At the end of its scope nothing is in flight, come what may.
class Drained {
  public:
    explicit Drained(const Gpu& gpu) : gpu_(gpu) {}
    ~Drained() { vkDeviceWaitIdle(gpu_.device()); }
    Drained(const Drained&) = delete;
    Drained& operator=(const Drained&) = delete;

  private:
    const Gpu& gpu_;
};
