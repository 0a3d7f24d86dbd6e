// SPDX-License-Identifier: MIT
// labels: device threads long
// Choosing a device, and every way in which there is none. Faults come from a loader put before the real one.
#include "host/core/embedding/backend.hpp"
#include "host/core/embedding/check.hpp"
#include "host/core/press/device.hpp"
#include "host/core/vulkan/recording.hpp"
#include "host/lab/march/self_test.hpp"
#include "tests/shim.hpp"
#include "tests/support.hpp"

#include <cctype>

using namespace test;
using vulkan::Loader;

TEST_CASE("the canary: validation with synchronization is on, and reports a hazard") {
    Validated vulkan;
    auto context = vulkan::context_of(*vulkan.device().impl().backend);
    vulkan::Buffer a(*context, 64, vulkan::Buffer::Location::device), b(*context, 64, vulkan::Buffer::Location::device);
    vulkan::Recording recording(*context);
    const VkCommandBuffer commands = recording.commands();
    const VkBufferCopy all{0, 0, 64};
    context->calls().vkCmdCopyBuffer(commands, a.handle(), b.handle(), 1, &all);
    context->calls().vkCmdCopyBuffer(commands, b.handle(), a.handle(), 1,
                                     &all); // no barrier: reads what is being written
    recording.submit();
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
    };
    check({nullptr, "no Vulkan loader (libvulkan.so.1 is not installed)"}, "no Vulkan loader");
    check(faulty(&Shim::no_driver), "no driver");
    check(faulty(&Shim::no_compute), "no compute queue");
    check(faulty(&Shim::few_buffers), "maxPerStageDescriptorStorageBuffers = 4; 12 are needed");
}

TEST_CASE("a device whose bits differ is named and refused, unless asked for by name") {
    const Loader wrong = faulty(&Shim::miscompile);
    const std::string message = refusal(Error::Code::no_device, [&] { open_device("vulkan", wrong); });
    const std::string name = Device::list()[0].name;
    std::string other_case = name;
    for (char& c : other_case) c = char(std::islower(c) ? std::toupper(c) : std::tolower(c));
    CHECK(message.find(name) != std::string::npos);
    CHECK(message.find("bits differ") != std::string::npos);
    for (const std::string& by : {name.substr(0, name.size() / 2), other_case, std::string("0")}) {
        const Device device = open_device(by, wrong);
        CHECK(device.info().vulkan);
        CHECK_FALSE(device.info().exact);
        const SelfTest test = self_test(*device.impl().backend);
        CHECK_FALSE(test.exact());
        CHECK(test.kernels[SelfTest::press].different > 0);
        CHECK(test.kernels[SelfTest::sites].different > 0);
    }
}

TEST_CASE("two devices of one name are told apart by their rows and their uuids") {
    const Loader twins = faulty(&Shim::twins);
    const DeviceInfo first = open_device("0", twins).info(), second = open_device("1", twins).info();
    CHECK(first.name == second.name);
    CHECK(first.uuid.size() == 36);
    CHECK(first.uuid.substr(0, 34) == second.uuid.substr(0, 34));
    CHECK(first.uuid.substr(34) == "01");
    CHECK(second.uuid.substr(34) == "02");
    std::string capitals = second.uuid;
    for (char& c : capitals) c = char(std::toupper(c));
    for (const std::string& by : {second.uuid, "GPU-" + second.uuid, capitals, second.uuid.substr(24)})
        CHECK(open_device(by, twins).info().uuid == second.uuid);
    const std::string message = refusal(Error::Code::bad_input, [&] { open_device(second.uuid.substr(29), twins); });
    for (const char* allowed : {"0 or part of", "1 or part of"}) CHECK(message.find(allowed) != std::string::npos);
    CHECK(message.find(second.uuid) != std::string::npos);
    refuses([&] { open_device("gpu", twins); }, "vulkan (the best Vulkan device");
}

TEST_CASE("a device that fails in one variant alone is refused when a scene needs that one") {
    const Loader wrong = faulty(&Shim::miscompile_far);
    Scene s = small_scene(20, 12);
    s.model = Model::march;
    Device device = open_device("vulkan", wrong);
    CHECK(device.info().exact);
    CHECK(run(s, device).steps > 0);
    s.precision = Precision::f32_compensated; // each variant is tested by itself
    CHECK(run(s, device).device.exact);
    s.precision.reset();
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
    CHECK(self_test(*vulkan.device().impl().backend).exact());
    const std::string name = Device::list()[0].name;
    CHECK(Device::open(name.substr(0, name.size() / 2)).info().name == name);
    const std::string message = refusal(Error::Code::bad_input, [] { Device::open("voodoo"); });
    CHECK(message.find("voodoo") != std::string::npos);
    CHECK(message.find(name) != std::string::npos);
    for (const char* which : {"99", "", " ", "   "}) refusal(Error::Code::bad_input, [&] { Device::open(which); });
    refusal(Error::Code::bad_input, [] { Device::cpu(-1); });
}

TEST_CASE("a grid that does not fit a device is refused with the limit, before anything is allocated") {
    const vulkan::Loader loader = shimmed();
    shim.heap = 2147483648;
    const Validated vulkan(loader);
    Scene s;
    s.grid = {16384, 4096, {}};
    s.time.duration = 0.01;
    const std::string message = refusal(Error::Code::bad_input, [&] { run(s, vulkan.device()); });
    CHECK(message.find("grid of 16384 x 4096 needs ") != std::string::npos);
    CHECK(message.find("device memory = 2147483648") != std::string::npos);
}

TEST_CASE("double precision on a Vulkan device is an error, not a silent float") {
    const Validated vulkan;
    RunOptions f64;
    f64.precision = Precision::f64;
    refuses([&] { run(small_scene(4, 4), vulkan.device(), f64); }, "f64");
}

TEST_CASE("a submission that fails in the test of a device: it is not opened, and the next one is") {
    const LeftToDriver leaks;
    const vulkan::Loader loader = shimmed();
    for (Fault fault :
         {Fault{"vkQueueSubmit", 0, VK_ERROR_DEVICE_LOST}, Fault{"vkWaitForFences", 0, VK_ERROR_DEVICE_LOST},
          Fault{"vkResetFences", 0, VK_ERROR_OUT_OF_HOST_MEMORY}})
        for (; fault.before < 8; fault.before += 3) {
            shim.fault = fault;
            CHECK(refusal(Error::Code::no_device, [&] { open_device("0", loader); }).find(fault.call) !=
                  std::string::npos);
            CHECK(shim.fault.struck);
            shim.fault = {};
            CHECK(open_device("0", loader).info().exact);
        }
}
