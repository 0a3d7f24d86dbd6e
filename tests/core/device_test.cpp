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
        CHECK(test.kernels[SelfTest::fields].different > 0);
        CHECK(test.kernels[SelfTest::sites].different > 0);
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
    CHECK(self_test(*vulkan.device().impl().backend).exact());
    const std::string name = Device::list()[0].name;
    CHECK(Device::open(name.substr(0, name.size() / 2)).info().name == name);
    const std::string message = refusal(Error::Code::bad_input, [] { Device::open("voodoo"); });
    CHECK(message.find("voodoo") != std::string::npos);
    CHECK(message.find(name) != std::string::npos);
    refusal(Error::Code::bad_input, [] { Device::open("99"); });
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
    const std::string message = refusal(Error::Code::bad_input, [&] { run(small_scene(4, 4), vulkan.device(), f64); });
    CHECK(message.find("f64") != std::string::npos);
}

namespace {

std::vector<float> numbers(const Result& r) {
    std::vector<double> all;
    for (const Trace& t : r.traces)
        for (const auto* column : {&t.mean, &t.min, &t.max, &t.probes[0]})
            all.insert(all.end(), column->begin(), column->end());
    for (const Field& f : r.fields) all.insert(all.end(), f.values.begin(), f.values.end());
    return {all.begin(), all.end()};
}

// A run; after a failure another one.
struct Running {
    std::vector<float> on(const Device& device) {
        Scene s = small_scene(33, 20);
        s.model = Model::march;
        s.precision = Precision::f32;
        s.output.fields = {{0.1, {Quantity::curvature, Quantity::sa1}}, {0.2, {Quantity::fa2}}};
        return numbers(run(s, device));
    }
    void refuse_responses() {}
};

// A skin that is made, pressed and reset; after a failure it goes on with what failed.
struct Pressing {
    std::unique_ptr<Skin> skin;
    int done = 0;
    std::vector<float> responses;

    std::vector<float> on(const Device& device) {
        const SkinDescription d = small_scene(33, 20);
        if (!skin) skin = std::make_unique<Skin>(device, d);
        for (; done < 5; ++done) {
            if (done == 3) skin->reset(); // after an odd number of presses
            else skin->press(frame(d, done), 0.1);
            const Skin::Response r = skin->response(Quantity::fa2);
            responses.insert(responses.end(), r.begin(), r.end());
        }
        return responses;
    }
    void refuse_responses() {
        if (skin) refusal(Error::Code::device, [&] { skin->response(Quantity::sa1); });
    }
};

// Fails each call of that name in turn, until there is none left to fail.
template <class Work> void strike(const vulkan::Loader& loader, Fault fault, bool loses) {
    const std::vector<float> right = Work().on(Device::cpu(1));
    const std::string call = fault.call, says = call + " failed with VkResult " + std::to_string(fault.code);
    for (bool struck = true; struck; ++fault.before) {
        CAPTURE(call);
        CAPTURE(fault.code);
        CAPTURE(fault.before);
        {
            const Device device = open_device("vulkan", loader); // whatever was lost before
            Work work;
            shim.fault = fault;
            std::vector<float> got;
            std::string first;
            try {
                got = work.on(device);
            } catch (const Error& e) {
                CHECK(e.code() == Error::Code::device);
                first = e.what();
            }
            struck = shim.fault.struck;
            shim.fault = {};
            shim.calls.clear();
            if (struck) CHECK(first.find(says) == 0); // never absorbed
            else CHECK(got == right);
            if (struck && loses) {
                for (int i = 0; i < 2; ++i)
                    CHECK(refusal(Error::Code::device, [&] { work.on(device); }).find(" is lost since " + says) !=
                          std::string::npos);
                work.refuse_responses();
                CHECK(shim.calls.empty());
            } else if (struck) {
                CHECK(work.on(device) == right);
                shim.calls.clear();
            }
        }
        if (struck && loses) CHECK(shim.calls.empty()); // nothing is destroyed
        CHECK((struck || fault.before > 1));
    }
}

} // namespace

TEST_CASE("whatever fails in a submission is an error; then the device is lost, or gives the right bits") {
    const LeftToDriver leaks;
    const vulkan::Loader loader = shimmed();
    const auto strike_both = [&](const Fault& fault, bool loses) {
        strike<Running>(loader, fault, loses);
        strike<Pressing>(loader, fault, loses);
    };
    strike_both({"vkBeginCommandBuffer", 0, VK_ERROR_OUT_OF_HOST_MEMORY}, false);
    strike_both({"vkEndCommandBuffer", 0, VK_ERROR_OUT_OF_DEVICE_MEMORY}, false);
    strike_both({"vkQueueSubmit", 0, VK_ERROR_OUT_OF_HOST_MEMORY}, false);
    strike_both({"vkQueueSubmit", 0, VK_ERROR_DEVICE_LOST, true}, true);
    strike_both({"vkWaitForFences", 0, VK_ERROR_DEVICE_LOST}, true);
    strike_both({"vkWaitForFences", 0, VK_ERROR_OUT_OF_HOST_MEMORY}, true);
    strike_both({"vkResetFences", 0, VK_ERROR_OUT_OF_DEVICE_MEMORY}, true);
}

TEST_CASE("a wait that a driver ends before its time goes on, however often: the device is not lost") {
    const Device device = open_device("vulkan", shimmed());
    const std::vector<float> run = Running().on(Device::cpu(1)), press = Pressing().on(Device::cpu(1));
    for (const int times : {1, 3, 1000}) {
        const Fault ended{.call = "vkWaitForFences", .before = 1, .code = VK_TIMEOUT, .times = times};
        for (const bool pressing : {false, true}) {
            shim.fault = ended;
            CHECK((pressing ? Pressing().on(device) == press : Running().on(device) == run));
            CHECK(std::exchange(shim.fault, {}).times <= 0); // as often as that
        }
    }
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
