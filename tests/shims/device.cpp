// SPDX-License-Identifier: MIT
#include "tests/shims/shims.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace shims {
namespace {

constexpr struct {
    const char* name;
    Kind kind;
} kinds[] = {{"none", Kind::none},
             {"noncoherent", Kind::noncoherent},
             {"split", Kind::split},
             {"subgroup", Kind::subgroup},
             {"no_timestamps", Kind::no_timestamps},
             {"alignment", Kind::alignment},
             {"least", Kind::least},
             {"few_buffers", Kind::few_buffers},
             {"contracting", Kind::contracting},
             {"metal", Kind::metal},
             {"groups", Kind::groups},
             {"narrow", Kind::narrow}};

// Sets the limits that a program of compute kernels meets to the least of Vulkan 1.1.
void change_to_least(VkPhysicalDeviceLimits& l) {
    l.maxTexelBufferElements = 65536;
    l.maxUniformBufferRange = 16384;
    l.maxStorageBufferRange = 1 << 27;
    l.maxPushConstantsSize = 128;
    l.maxMemoryAllocationCount = 4096;
    l.bufferImageGranularity = 131072;
    l.maxBoundDescriptorSets = 4;
    l.maxPerStageDescriptorUniformBuffers = 12;
    l.maxPerStageDescriptorStorageBuffers = 12; // more than the least, 4: kernels bind so many
    l.maxPerStageResources = 128;
    l.maxDescriptorSetStorageBuffers = 24;
    l.maxComputeSharedMemorySize = 16384;
    for (uint32_t& count : l.maxComputeWorkGroupCount) count = 65535;
    l.maxComputeWorkGroupInvocations = 128;
    l.maxComputeWorkGroupSize[0] = l.maxComputeWorkGroupSize[1] = 128;
    l.maxComputeWorkGroupSize[2] = 64;
    l.timestampComputeAndGraphics = VK_FALSE;
}

void change_to_aligned(VkPhysicalDeviceLimits& l) {
    l.minTexelBufferOffsetAlignment = l.minUniformBufferOffsetAlignment = l.minStorageBufferOffsetAlignment = 256;
    l.nonCoherentAtomSize = 256;
    l.optimalBufferCopyOffsetAlignment = 256;
}

} // namespace

const Choice& chosen() {
    static const Choice choice = [] {
        const char* variable = std::getenv("DERMIS_SHIM");
        Choice c;
        c.name = variable ? variable : "none";
        const size_t end = c.name.find('=');
        if (end != std::string::npos) c.number = uint32_t(std::strtoul(c.name.c_str() + end + 1, nullptr, 10));
        const auto known =
            std::find_if(std::begin(kinds), std::end(kinds), [&](auto& k) { return c.name.substr(0, end) == k.name; });
        if (known == std::end(kinds)) broken("DERMIS_SHIM names none of tests/shims/README.md");
        c.kind = known->kind;
        const bool numbered = c.kind == Kind::subgroup || c.kind == Kind::groups || c.kind == Kind::narrow;
        if (numbered != (c.number > 0)) broken("DERMIS_SHIM needs a number above 0, or none");
        return c;
    }();
    return choice;
}

void broken(const std::string& rule) {
    const char* variable = std::getenv("DERMIS_SHIM");
    std::fprintf(stderr, "shim %s: %s\n", variable ? variable : "", rule.c_str());
    std::abort();
}

void change(VkPhysicalDeviceProperties& p) {
    const std::string name = p.deviceName + (", " + chosen().name);
    std::snprintf(p.deviceName, sizeof p.deviceName, "%s", name.c_str());
    VkPhysicalDeviceLimits& l = p.limits;
    switch (chosen().kind) {
    case Kind::noncoherent: l.nonCoherentAtomSize = 256; break;
    case Kind::no_timestamps:
        l.timestampComputeAndGraphics = VK_FALSE;
        l.timestampPeriod = 0;
        break;
    case Kind::alignment: change_to_aligned(l); break;
    case Kind::least:
    case Kind::few_buffers:
        p.apiVersion = VK_API_VERSION_1_1;
        change_to_least(l);
        change_to_aligned(l);
        if (is(Kind::few_buffers)) l.maxPerStageDescriptorStorageBuffers = 4;
        break;
    case Kind::narrow: l.maxStorageBufferRange = chosen().number; break;
    default: break;
    }
}

void change(VkPhysicalDeviceSubgroupProperties& p) {
    if (is(Kind::subgroup)) p.subgroupSize = chosen().number;
    if (is(Kind::least)) p.subgroupSize = 1;
}

void change(VkPhysicalDeviceFloatControlsProperties& p) {
    if (is(Kind::least)) p.shaderRoundingModeRTEFloat32 = p.shaderSignedZeroInfNanPreserveFloat32 = VK_FALSE;
}

void change(VkQueueFamilyProperties& p) {
    if (is(Kind::no_timestamps) || is(Kind::least)) p.timestampValidBits = 0;
}

void change(VkMemoryRequirements& r) {
    if (is(Kind::alignment) || is(Kind::least)) r.alignment = std::max<VkDeviceSize>(r.alignment, 256);
    if (is(Kind::noncoherent)) r.memoryTypeBits = 0b11;
    if (is(Kind::split)) r.memoryTypeBits = 0b111;
}

void change(VkPhysicalDeviceMemoryProperties& p) {
    if (!Memory::changed()) return;
    constexpr VkMemoryPropertyFlags device = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT,
                                    host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT,
                                    coherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                                    cached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    const VkDeviceSize bytes = p.memoryHeaps[p.memoryTypes[Memory::real_type(p)].heapIndex].size;
    p = {};
    p.memoryHeaps[0] = {bytes, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT};
    if (is(Kind::noncoherent)) {
        p.memoryHeapCount = 1;
        p.memoryTypeCount = 2; // Vulkan demands a coherent one
        p.memoryTypes[0] = {device | host | cached, 0};
        p.memoryTypes[1] = {host | coherent, 0};
    } else {
        p.memoryHeapCount = 2;
        p.memoryHeaps[1] = {bytes, 0};
        p.memoryTypeCount = 3;
        p.memoryTypes[0] = {device, 0};
        p.memoryTypes[1] = {host | coherent, 1};
        p.memoryTypes[2] = {host | coherent | cached, 1};
    }
}

} // namespace shims
