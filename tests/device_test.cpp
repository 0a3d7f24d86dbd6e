// SPDX-License-Identifier: MIT
// Choosing a device, and every way in which there is none. Faults come from a loader put before the real one.
#include "host/device.hpp"
#include "tests/support.hpp"

#include <cstring>

using namespace test;
using vulkan::Loader;

namespace {

// What stands between the library and the real loader; volk asks by name.
struct Shim {
    PFN_vkGetInstanceProcAddr real = vulkan::system_loader().get;
    bool no_driver = false, no_compute = false, few_buffers = false, miscompile = false, miscompile_far = false;
    PFN_vkVoidFunction queues = nullptr, properties = nullptr, module = nullptr, device_address = nullptr;
} shim;

VKAPI_ATTR VkResult VKAPI_CALL no_instance(const VkInstanceCreateInfo*, const VkAllocationCallbacks*, VkInstance*) {
    return VK_ERROR_INCOMPATIBLE_DRIVER;
}

VKAPI_ATTR void VKAPI_CALL queues(VkPhysicalDevice p, uint32_t* count, VkQueueFamilyProperties* families) {
    reinterpret_cast<PFN_vkGetPhysicalDeviceQueueFamilyProperties>(shim.queues)(p, count, families);
    if (families)
        for (uint32_t i = 0; i < *count; ++i) families[i].queueFlags &= ~VkQueueFlags(VK_QUEUE_COMPUTE_BIT);
}

VKAPI_ATTR void VKAPI_CALL properties(VkPhysicalDevice p, VkPhysicalDeviceProperties* out) {
    reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(shim.properties)(p, out);
    out->limits.maxPerStageDescriptorStorageBuffers = 4;
}

// A compiler that gets one constant wrong: the 1 of every response, or 4/3 of the fourth-order stencil.
VKAPI_ATTR VkResult VKAPI_CALL module(VkDevice d, const VkShaderModuleCreateInfo* info, const VkAllocationCallbacks* a,
                                      VkShaderModule* m) {
    std::vector<uint32_t> code(info->pCode, info->pCode + info->codeSize / 4);
    for (uint32_t& word : code)
        if (word == (shim.miscompile ? 0x3f800000 : 0x3faaaaab)) word ^= 1;
    VkShaderModuleCreateInfo changed = *info;
    changed.pCode = code.data();
    return reinterpret_cast<PFN_vkCreateShaderModule>(shim.module)(d, &changed, a, m);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_address(VkDevice device, const char* name) {
    const PFN_vkVoidFunction real = reinterpret_cast<PFN_vkGetDeviceProcAddr>(shim.device_address)(device, name);
    if ((shim.miscompile || shim.miscompile_far) && std::strcmp(name, "vkCreateShaderModule") == 0) {
        shim.module = real;
        return reinterpret_cast<PFN_vkVoidFunction>(module);
    }
    return real;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_address(VkInstance instance, const char* name) {
    const PFN_vkVoidFunction real = shim.real(instance, name);
    const auto is = [name](const char* other) { return std::strcmp(name, other) == 0; };
    if (shim.no_driver && is("vkCreateInstance")) return reinterpret_cast<PFN_vkVoidFunction>(no_instance);
    if (shim.no_compute && is("vkGetPhysicalDeviceQueueFamilyProperties"))
        return shim.queues = real, reinterpret_cast<PFN_vkVoidFunction>(queues);
    if (shim.few_buffers && is("vkGetPhysicalDeviceProperties"))
        return shim.properties = real, reinterpret_cast<PFN_vkVoidFunction>(properties);
    if (is("vkGetDeviceProcAddr"))
        return shim.device_address = real, reinterpret_cast<PFN_vkVoidFunction>(device_address);
    return real;
}

Loader faulty(bool Shim::*fault) {
    shim = {};
    shim.*fault = true;
    return {instance_address, ""};
}

} // namespace

TEST_CASE("the canary: validation with synchronization is on, and reports a hazard") {
    Validated vulkan;
    auto context = vulkan.device().impl().context;
    vulkan::Buffer a(*context, 64, vulkan::Buffer::Place::device), b(*context, 64, vulkan::Buffer::Place::device);
    const VkCommandBuffer commands = context->begin();
    const VkBufferCopy all{0, 0, 64};
    context->calls().vkCmdCopyBuffer(commands, a.handle(), b.handle(), 1, &all);
    context->calls().vkCmdCopyBuffer(commands, b.handle(), a.handle(), 1,
                                     &all); // no barrier: reads what is being written
    context->submit();
    bool hazard = false;
    for (const std::string& m : vulkan.messages()) hazard |= m.find("SYNC-HAZARD") != std::string::npos;
    CHECK(hazard);
    vulkan.forgive();
}

TEST_CASE(
    "without a loader, a driver or a compute queue: auto says so and uses the CPU, vulkan names what is missing") {
    const auto check = [](const Loader& loader, const char* says) {
        CAPTURE(says);
        const Device automatic = open_device("auto", loader);
        CHECK_FALSE(automatic.info().vulkan);
        CHECK(automatic.info().refused.find(says) != std::string::npos);
        CHECK(automatic.info().refused.find('\n') == std::string::npos);
        const std::string message = refusal(Error::Code::no_device, [&] { open_device("vulkan", loader); });
        CHECK(message.find(says) != std::string::npos);
        refusal(Error::Code::no_device, [&] { open_device("0", loader); });
        CHECK_FALSE(open_device("cpu", loader).info().vulkan);
    };
    check({nullptr, "no Vulkan loader (libvulkan.so.1 is not installed)"}, "no Vulkan loader");
    check(faulty(&Shim::no_driver), "no driver");
    check(faulty(&Shim::no_compute), "no compute queue");
    check(faulty(&Shim::few_buffers), "maxPerStageDescriptorStorageBuffers = 4; 12 are needed");
}

TEST_CASE("a device whose bits differ is named and refused, unless asked for by name") {
    const Loader wrong = faulty(&Shim::miscompile);
    const std::string message = refusal(Error::Code::no_device, [&] { open_device("vulkan", wrong); });
    CHECK(message.find("llvmpipe") != std::string::npos);
    CHECK(message.find("bits differ") != std::string::npos);
    for (const char* by : {"llvmpipe", "LLVMpipe", "0"}) {
        const Device device = open_device(by, wrong);
        CHECK(device.info().vulkan);
        CHECK_FALSE(device.info().exact);
        const SelfTest test = self_test(device);
        CHECK_FALSE(test.exact());
        CHECK(test.kernels[0].different > 0);
        CHECK(test.kernels[1].different > 0);
    }
}

TEST_CASE("a device that fails in one variant alone is refused when a scene needs that one") {
    const Loader wrong = faulty(&Shim::miscompile_far);
    Scene s = small_scene(20, 12);
    s.model = Model::march;
    Device device = open_device("vulkan", wrong);
    CHECK(device.info().exact);
    CHECK(run(s, device).steps > 0);
    s.stencil = Stencil::fourth_order;
    CHECK(refusal(Error::Code::no_device, [&] { run(s, device); }).find("bits differ") != std::string::npos);
    CHECK(refusal(Error::Code::no_device, [&] { run(s, device); }).find("bits differ") != std::string::npos);
    device = open_device("0", wrong); // asked for: then the result says so
    CHECK_FALSE(run(s, device).device.exact);
}

TEST_CASE("auto takes no software driver; vulkan takes it; names are parts of names") {
    const Device automatic = Device::open("auto");
    if (!automatic.info().vulkan) CHECK(automatic.info().refused.find("software") != std::string::npos);
    const Validated vulkan;
    CHECK(vulkan.device().info().vulkan);
    CHECK(vulkan.device().info().exact);
    CHECK(self_test(vulkan.device()).exact());
    CHECK(Device::open("llvmpipe").info().name.find("llvmpipe") != std::string::npos);
    const std::string message = refusal(Error::Code::bad_input, [] { Device::open("voodoo"); });
    CHECK(message.find("voodoo") != std::string::npos);
    CHECK(message.find("llvmpipe") != std::string::npos);
    refusal(Error::Code::bad_input, [] { Device::open("99"); });
    refusal(Error::Code::bad_input, [] { Device::cpu(-1); });
}

TEST_CASE("a grid that does not fit a device is refused with the limit, before anything is allocated") {
    const Validated vulkan;
    Scene s;
    s.grid = {16384, 4096, {}};
    s.time.duration = 0.01;
    const std::string message = refusal(Error::Code::bad_input, [&] { run(s, vulkan.device()); });
    CHECK(message.find("maxStorageBufferRange = 134217728") != std::string::npos);
}

TEST_CASE("double precision on a Vulkan device is an error, not a silent float") {
    const Validated vulkan;
    RunOptions f64;
    f64.precision = Precision::f64;
    const std::string message = refusal(Error::Code::bad_input, [&] { run(small_scene(4, 4), vulkan.device(), f64); });
    CHECK(message.find("f64") != std::string::npos);
}
