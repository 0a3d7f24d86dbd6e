// SPDX-License-Identifier: MIT
// Each device that is made by the layer of tests/shims is what it says, so that suites on it show something. These
// cases run under the layer alone, one for each shim (tests/shims/shims.py).
#include "host/core/embedding/backend.hpp"
#include "host/core/embedding/check.hpp"
#include "host/core/press/device.hpp"
#include "host/core/vulkan/recording.hpp"
#include "host/lab/march/self_test.hpp"
#include "tests/support.hpp"

using namespace test;
using vulkan::Buffer;

namespace {

// The first device, whatever its bits are.
struct Opened {
    Device device = open_device("0", vulkan::system_loader());
    vulkan::Context& context = *vulkan::context_of(*device.impl().backend);
};

// A buffer in memory of a type that the library has not chosen.
struct Unchosen {
    static constexpr VkDeviceSize bytes = 1024;
    vulkan::Context& context;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    unsigned char* data = nullptr;

    Unchosen(vulkan::Context& c, uint32_t type) : context(c) {
        VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
        info.size = bytes;
        info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
        const VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, bytes, type};
        REQUIRE(c.calls().vkCreateBuffer(c.device(), &info, nullptr, &buffer) == VK_SUCCESS);
        REQUIRE(c.calls().vkAllocateMemory(c.device(), &allocation, nullptr, &memory) == VK_SUCCESS);
        REQUIRE(c.calls().vkBindBufferMemory(c.device(), buffer, memory, 0) == VK_SUCCESS);
        void* mapped = nullptr;
        REQUIRE(c.calls().vkMapMemory(c.device(), memory, 0, VK_WHOLE_SIZE, 0, &mapped) == VK_SUCCESS);
        data = static_cast<unsigned char*>(mapped);
    }
    ~Unchosen() {
        context.calls().vkDestroyBuffer(context.device(), buffer, nullptr);
        context.calls().vkFreeMemory(context.device(), memory, nullptr);
    }
    VkMappedMemoryRange range() const {
        return {VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE, nullptr, memory, 0, VK_WHOLE_SIZE};
    }
};

void copy(vulkan::Context& c, VkBuffer from, VkBuffer to) {
    vulkan::Recording recording(c);
    const VkCommandBuffer commands = recording.commands();
    const VkBufferCopy all{0, 0, Unchosen::bytes};
    c.calls().vkCmdCopyBuffer(commands, from, to, 1, &all);
    c.barrier(commands);
    recording.submit();
}

} // namespace

TEST_SUITE_BEGIN("devices made by a layer" * doctest::skip());

TEST_CASE("noncoherent: the host and the device see each other's bytes where a range is flushed or invalidated") {
    const Opened opened;
    vulkan::Context& c = opened.context;
    const VkPhysicalDeviceMemoryProperties& types = c.physical().memory;
    REQUIRE(types.memoryTypeCount == 2);
    CHECK((types.memoryTypes[0].propertyFlags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT) == 0);
    Unchosen memory(c, 0);
    Buffer coherent(c, Unchosen::bytes, Buffer::Location::host); // the library's own choice
    const auto* seen = static_cast<const unsigned char*>(coherent.data());
    CHECK(memory.data[0] == 0xcd);
    const VkMappedMemoryRange range = memory.range();
    memory.data[0] = 3; // the device's memory holds anything before
    CHECK(c.calls().vkFlushMappedMemoryRanges(c.device(), 1, &range) == VK_SUCCESS);
    memory.data[0] = 1;
    copy(c, memory.buffer, coherent.handle());
    CHECK(seen[0] == 3);
    CHECK(c.calls().vkFlushMappedMemoryRanges(c.device(), 1, &range) == VK_SUCCESS);
    copy(c, memory.buffer, coherent.handle());
    CHECK(seen[0] == 1);
    static_cast<unsigned char*>(coherent.data())[0] = 2;
    copy(c, coherent.handle(), memory.buffer);
    CHECK(memory.data[0] == 1);
    CHECK(c.calls().vkInvalidateMappedMemoryRanges(c.device(), 1, &range) == VK_SUCCESS);
    CHECK(memory.data[0] == 2);
}

TEST_CASE("split: no memory is both the device's and the host's") {
    const Opened opened;
    const VkPhysicalDeviceMemoryProperties& types = opened.context.physical().memory;
    CHECK(types.memoryHeapCount == 2);
    constexpr VkMemoryPropertyFlags both = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
    for (uint32_t i = 0; i < types.memoryTypeCount; ++i) CHECK((types.memoryTypes[i].propertyFlags & both) != both);
    const uint32_t device = opened.context.memory_type(~0u, Buffer::Location::device),
                   host = opened.context.memory_type(~0u, Buffer::Location::host);
    CHECK(types.memoryTypes[device].heapIndex != types.memoryTypes[host].heapIndex);
}

TEST_CASE("alignment: buffers begin at multiples of 256 bytes") {
    const Opened opened;
    CHECK(opened.context.limits().minStorageBufferOffsetAlignment == 256);
    CHECK(opened.context.limits().nonCoherentAtomSize == 256);
}

TEST_CASE("least: limits are the least that Vulkan allows, and no texels are fetched") {
    const Opened opened;
    const VkPhysicalDeviceLimits& limits = opened.context.limits();
    CHECK(limits.maxComputeWorkGroupInvocations == 128);
    CHECK(limits.maxPushConstantsSize == 128);
    CHECK(limits.maxStorageBufferRange == 1 << 27);
    CHECK(limits.maxPerStageDescriptorStorageBuffers == 12);
    CHECK(limits.minStorageBufferOffsetAlignment == 256);
    CHECK_FALSE(opened.context.pipelines().device().floats.rounds_to_even);
    CHECK_FALSE(opened.context.pipelines().device().floats.keeps_nans);
    CHECK_FALSE(opened.context.pipelines().device().texels);
}

TEST_CASE("few_buffers: the device is refused, and the limit is named") {
    const std::string says = "maxPerStageDescriptorStorageBuffers = 4; 12 are needed";
    for (const char* which : {"vulkan", "0"})
        CHECK(refusal(Error::Code::no_device, [&] { Device::open(which); }).find(says) != std::string::npos);
    CHECK(Device::open("auto").info().refused.find(says) != std::string::npos);
    CHECK(Device::list()[0].refused == says);
}

TEST_CASE("contracting: the device is refused unless it is named; then it says so, and its error is within the bound") {
    CHECK(refusal(Error::Code::no_device, [] { Device::open("vulkan"); }).find("bits differ") != std::string::npos);
    CHECK_FALSE(Device::open("auto").info().vulkan);
    const Opened opened;
    CHECK_FALSE(opened.device.info().exact);
    CHECK_FALSE(self_test(*opened.device.impl().backend).exact());
    Scene plain = small_scene(60, 40);
    plain.model = Model::march;
    plain.tolerance = 1e-4; // a bound is computed where one is asked for
    plain.time = {0.01, 1};
    Scene slow = plain, chain = plain;
    slow.material.viscosity = 300;
    chain.material.elements = {{2.5, 0.01, {}, {}}, {4, 0.7, {}, {}}};
    chain.material.spring = 8;
    long long different = 0;
    for (const Scene& s : {plain, slow, chain})
        for (Precision precision : {Precision::f32, Precision::f32_compensated}) {
            RunOptions options{.precision = precision, .check = true};
            const Result r = run(s, opened.device, options);
            CHECK_FALSE(r.device.exact);
            different += r.cells_different;
            options.precision = Precision::f64;
            options.check = false;
            const Result exact = run(s, Device::cpu(), options);
            REQUIRE(r.predicted_error < 1e-4);
            for (const Trace& t : exact.traces) {
                CAPTURE(name(t.quantity));
                const Trace& own = r.trace(t.quantity);
                CHECK(difference(own.max, t.max) <= r.predicted_error);
                for (size_t p = 0; p < t.probes.size(); ++p) {
                    double greatest = 0, worst = 0; // over all cells
                    for (size_t i = 0; i < t.max.size(); ++i) {
                        greatest = std::max({greatest, std::abs(t.max[i]), std::abs(t.min[i])});
                        worst = std::max(worst, std::abs(own.probes[p][i] - t.probes[p][i]));
                    }
                    CHECK(worst <= r.predicted_error * greatest);
                }
            }
        }
    CHECK(different > 0); // the shim acts
}

TEST_SUITE_END();
