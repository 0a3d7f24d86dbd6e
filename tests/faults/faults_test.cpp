// SPDX-License-Identifier: MIT
// labels: threads long
// Every Vulkan call fails, one after another: an error names it, nothing is left, and the next device works.
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"
#include "tests/command.hpp"
#include "tests/embedding_host.hpp"
#include "tests/shim.hpp"
#include "tests/vulkan_calls.hpp"

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

using namespace test;

namespace {

using Numbers = std::vector<float>;

struct Figures {
    int faults = 0, errors = 0, absorbed = 0, losses = 0, left = 0;
} figures;

void append(Numbers& all, const Numbers& more) { all.insert(all.end(), more.begin(), more.end()); }

Ledger ledger;

// A run with traces, probes and fields, in several submissions.
Numbers run_scene(const Device& device) {
    Scene s = small_scene(33, 20);
    s.model = Model::march;
    s.precision = Precision::f32;
    s.output.fields = {{0.1, {Quantity::curvature, Quantity::sa1}}, {0.2, {Quantity::fa2}}};
    const Result r = run(s, device);
    Numbers all;
    for (const Trace& t : r.traces)
        for (const auto* column : {&t.mean, &t.min, &t.max, &t.probes[0], &t.probes[1]})
            all.insert(all.end(), column->begin(), column->end());
    for (const Field& f : r.fields) all.insert(all.end(), f.values.begin(), f.values.end());
    return all;
}

// Three presses, with a reset, a state that is saved and one that is loaded.
Numbers press_skin(const Device& device) {
    const SkinDescription d = small_scene(33, 20);
    SkinOptions options{.responses = {Quantity::sa1, Quantity::fa2}};
    Skin skin(device, d, options);
    skin.press(frame(d, 0), 0.1);
    Numbers all = answers(skin, Quantity::sa1);
    std::vector<char> state(skin.state_bytes());
    skin.save(state.data(), state.size());
    skin.press(frame(d, 1), 0.2);
    skin.reset();
    skin.load(state.data(), state.size());
    skin.press(frame(d, 2), 0.1);
    const Quantity told[] = {Quantity::sa1, Quantity::fa2, Quantity::strain};
    append(all, answers(skin, told));
    const Numbers frames = frames_of(d, 3, 2);
    skin.press_frames(frames.data(), 2, frames.size() / 2, 0.1);
    append(all, answers(skin, told));
    return all;
}

// Pads that are pressed together and alone, with receptors alone that respond.
Numbers press_batch(const Device& device) {
    SkinDescription d = small_scene(12, 8);
    d.sites = {{Quantity::sa1, {3, 4}}, {Quantity::fa2, {11, 7}}};
    SkinOptions options{.count = 3};
    Skin skin(device, d, options);
    const Quantity told[] = {Quantity::sa1, Quantity::fa2};
    skin.press(frames_of(d, 0, 3), 0.1);
    Numbers all = answers(skin, told);
    skin.press(frame(d, 5), std::vector<double>{0.3}, std::vector<int>{2});
    append(all, answers(skin, told));
    return all;
}

// Devices without a self-test, of one instance.
struct Source {
    vulkan::Loader loader = shimmed();
    std::shared_ptr<const vulkan::Instance> instance = left_instance(loader);

    Source() { shim.ledger = &ledger; }
    ~Source() { shim.ledger = nullptr; }
    // A device that is lost keeps its instance for ever.
    static std::shared_ptr<const vulkan::Instance> left_instance(const vulkan::Loader& loader) {
        const LeftToDriver leaks;
        return std::make_shared<const vulkan::Instance>(loader);
    }
    Device device() const {
        const vulkan::PhysicalDevice& physical = instance->devices()[0];
        auto impl = std::make_shared<Device::Impl>();
        impl->info = physical.info;
        impl->info.exact = impl->asked = impl->named = true;
        impl->backend = std::make_shared<vulkan::VulkanBackend>(std::make_shared<vulkan::Context>(instance, physical));
        return Device(impl);
    }
};

std::string says(const Fault& f) { return std::string(f.struck) + " failed with VkResult " + std::to_string(f.code); }

// Does a work under a fault. Returns the message of the error, or nothing.
template <class Work> std::string error_under(const Fault& fault, Error::Code code, Work&& work) {
    shim.fault = fault;
    try {
        work();
    } catch (const Error& e) {
        CHECK(int(e.code()) == int(code));
        return e.what();
    }
    return "";
}

// Ends the fault and counts what came of it. message: of the error, or empty.
Fault judge(const std::string& message) {
    const Fault fault = std::exchange(shim.fault, {});
    if (!fault.struck) return fault;
    ++figures.faults;
    ++(message.empty() ? figures.absorbed : figures.errors);
    if (message.empty()) return fault;
    CHECK_MESSAGE(message.find(says(fault)) != std::string::npos, message);
    CHECK_MESSAGE(std::regex_match(message, std::regex("[^\n]*\\bvk[A-Z]\\w+ failed with VkResult -?\\d+[^\n]*")),
                  message);
    return fault;
}

// Checks that nothing was ended wrongly, and that as many objects are there as there were before.
void check_ledger(size_t before) {
    for (const std::string& fault : ledger.faults()) CHECK_MESSAGE(false, fault);
    const size_t now = ledger.left().size();
    CHECK(now == before);
    figures.left += int(now > before ? now - before : 0);
}

constexpr VkResult codes[] = {VK_ERROR_OUT_OF_HOST_MEMORY, VK_ERROR_OUT_OF_DEVICE_MEMORY,
                              VK_ERROR_INITIALIZATION_FAILED, VK_ERROR_DEVICE_LOST, VK_ERROR_UNKNOWN};
constexpr VkResult each_in_turn = VK_SUCCESS; // one of these after another

// The fault of the call after so many others.
Fault fault_after(int before, Fault kind) {
    kind.before = before;
    if (kind.code == each_in_turn) kind.code = codes[size_t(before) % std::size(codes)];
    return kind;
}

// Fails each call of a work in turn on a device that has done it before, and so has its pipelines.
template <class Work> void strike_work(const Source& source, const Fault& kind, const Numbers& right, Work&& work) {
    const size_t none = ledger.left().size();
    std::optional<Device> device;
    size_t objects = 0;
    bool struck = true;
    for (int before = 0; struck; ++before) {
        const Fault fault = fault_after(before, kind);
        CAPTURE(fault.code);
        CAPTURE(fault.before);
        if (!device) {
            device = source.device();
            CHECK(work(*device) == right);
            objects = ledger.left().size();
        }
        Numbers got;
        const std::string message = error_under(fault, Error::Code::device, [&] { got = work(*device); });
        const Fault done = judge(message);
        struck = done.struck;
        CAPTURE(std::string(struck ? done.struck : ""));
        const vulkan::Context& context = *vulkan::context_of(*device->impl().backend);
        const bool lost = context.lost();
        CHECK(lost == ledger.lost(uint64_t(reinterpret_cast<uintptr_t>(context.device()))));
        if (lost) {
            ++figures.losses;
            shim.calls.clear();
            // Where later calls fail too, a wait among them, that one may have lost the device.
            const std::string again = refusal(Error::Code::device, [&] { work(*device); });
            CAPTURE(again);
            CHECK(again.find(" is lost since " + (done.sticky ? "vk" : says(done))) != std::string::npos);
            device.reset();
            CHECK(shim.calls.empty()); // nothing is tried again or destroyed
        } else CHECK((message.empty() ? got : work(*device)) == right);
        check_ledger(device ? objects : none);
    }
    device.reset();
    check_ledger(none);
}

// Once and from then on with each code; once with the work done all the same; and a wait that ends too early. By day
// each call fails once, and loses the device once.
std::vector<Fault> kinds() {
    std::vector<Fault> all;
    if (!night()) return {{.call = any_call, .code = codes[1]}, {.call = any_call, .code = VK_ERROR_DEVICE_LOST}};
    for (VkResult code : codes) all.push_back({.call = any_call, .code = code});
    for (VkResult code : codes) all.push_back({.call = any_call, .code = code, .sticky = true});
    // Most of these lose the device, and each new one compiles its pipelines: the other codes share the calls.
    for (VkResult code : {VK_ERROR_OUT_OF_DEVICE_MEMORY, VK_ERROR_DEVICE_LOST, each_in_turn})
        all.push_back({.call = any_call, .code = code, .made = true});
    for (const bool made : {false, true}) all.push_back({.call = "vkWaitForFences", .code = VK_TIMEOUT, .made = made});
    return all;
}

// A skin that is made, pressed and reset; after a failure it goes on with what failed.
struct Pressing {
    std::unique_ptr<Skin> skin;
    int done = 0;
    bool pressed = false; // and not read yet
    Numbers responses;

    Numbers on(const Device& device) {
        const SkinDescription d = small_scene(33, 20);
        if (!skin) skin = std::make_unique<Skin>(device, d);
        for (; done < 5; ++done) {
            if (pressed) {
            } else if (done == 3) skin->reset(); // after an odd number of presses
            else skin->press(frame(d, done), 0.1);
            pressed = true;
            append(responses, answers(*skin, Quantity::fa2));
            pressed = false;
        }
        return responses;
    }
};

// Fails each call of that name in turn, until there is none left to fail.
void strike_pressing(const Source& source, Fault fault, bool loses) {
    const Numbers right = Pressing().on(Device::cpu(1));
    std::optional<Device> device;
    for (bool struck = true; struck; ++fault.before) {
        CAPTURE(std::string(fault.call));
        CAPTURE(fault.code);
        CAPTURE(fault.before);
        if (!device) device = source.device();
        Pressing work;
        Numbers got;
        const std::string first = error_under(fault, Error::Code::device, [&] { got = work.on(*device); });
        const Fault done = std::exchange(shim.fault, {});
        struck = done.struck;
        CHECK((struck || fault.before > 1));
        if (!struck) {
            CHECK(got == right);
            break;
        }
        CHECK(first.find(says(done)) == 0); // never absorbed
        shim.calls.clear();
        if (!loses) {
            CHECK(work.on(*device) == right);
            continue;
        }
        const std::string lost = " is lost since " + says(done);
        for (int i = 0; i < 2; ++i)
            CHECK(refusal(Error::Code::device, [&] { work.on(*device); }).find(lost) != std::string::npos);
        if (work.skin) refusal(Error::Code::device, [&] { work.skin->response(Quantity::sa1); });
        work.skin.reset();
        device.reset();
        CHECK(shim.calls.empty()); // nothing is tried again or destroyed
    }
}

// Opens a device under a fault, and checks the error. Returns the call that failed, or nothing.
std::string strike_opening(const vulkan::Loader& loader, const Fault& fault, size_t objects) {
    CAPTURE(fault.code);
    CAPTURE(fault.before);
    std::optional<LeftToDriver> leaks;
    if (!fault.sticky) leaks.emplace();
    const std::string message = error_under(fault, Error::Code::no_device, [&] {
        const Device device = open_device("0", loader);
        CHECK(device.info().exact);
    });
    const Fault done = judge(message);
    check_ledger(objects);
    return done.struck ? done.struck : "";
}

// A host whose own calls never fail: they pass the shim by.
struct Embedding {
    Device device = Device::open("0");
    vulkan::Context& context = *vulkan::context_of(*device.impl().backend);
    vulkan::Handles handles = context.handles();
    SkinOptions options;
    SkinDescription description = small_scene(12, 8);

    Embedding(const Source& source, int count) {
        handles.get_instance_proc_addr = source.loader.get;
        options.count = count;
        options.responses = {Quantity::sa1, Quantity::fa2};
        if (count > 1) description.sites = {{Quantity::sa1, {3, 4}}, {Quantity::fa2, {11, 7}}};
    }
    Numbers pressure(int press) const { return frames_of(description, press, size_t(options.count)); }
    Numbers operator()() const {
        Host host(context, handles, description, 2, options);
        Range check(context, host.program.memory().check);
        host.program.bind_check(check.info);
        for (int press : {1, 2}) host.set_pressure(press, pressure(press));
        vulkan::Recording recording(context);
        const VkCommandBuffer commands = recording.commands();
        CHECK(host.program.record_check(commands));
        for (const vulkan::Binding& binding : host.bindings) {
            barrier(context, commands, host.program);
            CHECK(host.program.record_press(commands, binding, 0.1));
        }
        context.barrier(commands);
        recording.submit();
        CHECK(host.program.check_passed(check.data(), check.info.range));
        Numbers all = host.response(2, Quantity::sa1);
        append(all, host.response(2, Quantity::fa2));
        return all;
    }
    Numbers right() const {
        Skin skin(Device::cpu(1), description, options);
        for (int press : {1, 2}) skin.press(pressure(press), 0.1);
        return answers(skin, options.responses);
    }
};

// Each call of a program fails, with one code after another, because each trial compiles its pipelines.
void strike_program(const Embedding& host, const Fault& kind) {
    const size_t objects = ledger.left().size();
    const Numbers right = host.right();
    bool struck = true;
    for (int before = 0; struck; ++before) {
        const Fault fault = fault_after(before, kind);
        CAPTURE(fault.code);
        CAPTURE(fault.before);
        Numbers got;
        const std::string message = error_under(fault, Error::Code::device, [&] { got = host(); });
        struck = judge(message).struck;
        check_ledger(objects);
        if (message.empty()) CHECK(got == right);
        else if (before % 8 == 0) CHECK(host() == right); // the driver compiles a new program's kernels
    }
}

} // namespace

TEST_CASE("the list of calls to fail has every Vulkan function that the library names") {
#define FAILS(name_)                                                                                                   \
    static_assert(std::is_same_v<decltype(std::function(PFN_##name_()))::result_type, VkResult>);                      \
    known.insert(#name_);
#define TELLS_NOTHING(name_)                                                                                           \
    static_assert(std::is_void_v<decltype(std::function(PFN_##name_()))::result_type>);                                \
    known.insert(#name_);
    std::set<std::string> known = {"vkGetInstanceProcAddr", "vkGetDeviceProcAddr"}, unknown, named;
    FAILABLE_INSTANCE_CALLS(FAILS)
    FAILABLE_DEVICE_CALLS(FAILS)
    ENDING_CALLS(TELLS_NOTHING)
    ENDING_INSTANCE_CALLS(TELLS_NOTHING)
    RECORDING_CALLS(TELLS_NOTHING)
    TELLING_CALLS(TELLS_NOTHING)
    known.insert("vkDeviceWaitIdle"); // as a process ends, when nobody is left to be told
    const std::regex function("\\b(PFN_)?(vk[A-Z]\\w*)\\b");
    for (const auto& file : std::filesystem::recursive_directory_iterator(DERMIS_TEST_DATA "/../../host")) {
        const std::string ending = file.path().extension();
        if (ending != ".cpp" && ending != ".hpp") continue;
        const std::string text = slurp(file.path());
        for (std::sregex_iterator i(text.begin(), text.end(), function), end; i != end; ++i)
            if (!known.count((*i)[2]) && (*i)[2] != "vkVoidFunction") unknown.insert((*i)[2]);
            else named.insert((*i)[2]);
    }
    for (const std::string& name : unknown) CHECK_MESSAGE(false, name);
    CHECK(named.size() > 50);
}

TEST_CASE(
    "whatever fails in a submission is an error; then the device is lost, or the skin goes on, with the right bits") {
    const Source source;
    for (const auto& [call, code] : {std::pair("vkBeginCommandBuffer", VK_ERROR_OUT_OF_HOST_MEMORY),
                                     {"vkEndCommandBuffer", VK_ERROR_OUT_OF_DEVICE_MEMORY},
                                     {"vkQueueSubmit", VK_ERROR_OUT_OF_HOST_MEMORY}})
        strike_pressing(source, {.call = call, .code = code}, false);
    strike_pressing(source, {.call = "vkQueueSubmit", .code = VK_ERROR_DEVICE_LOST, .made = true}, true);
    for (const auto& [call, code] : {std::pair("vkWaitForFences", VK_ERROR_DEVICE_LOST),
                                     {"vkWaitForFences", VK_ERROR_OUT_OF_HOST_MEMORY},
                                     {"vkResetFences", VK_ERROR_OUT_OF_DEVICE_MEMORY}})
        strike_pressing(source, {.call = call, .code = code}, true);
}

TEST_CASE("a wait that a driver ends before its time goes on, however often: the device is not lost") {
    const Source source;
    const Device device = source.device();
    const Numbers run = run_scene(Device::cpu(1)), press = Pressing().on(Device::cpu(1));
    for (const int times : {1, 3, 1000}) {
        const Fault ended{.call = "vkWaitForFences", .before = 1, .code = VK_TIMEOUT, .times = times};
        for (const bool pressing : {false, true}) {
            shim.fault = ended;
            CHECK((pressing ? Pressing().on(device) == press : run_scene(device) == run));
            CHECK(std::exchange(shim.fault, {}).times <= 0); // as often as that
        }
    }
}

TEST_CASE("every Vulkan call fails: one error names it, nothing is left, and what comes next has the right bits") {
    const Source source;
    const size_t objects = ledger.left().size();
    for (const auto work : {&run_scene, &press_skin, &press_batch}) {
        if (work == &press_batch && !night()) continue;
        const Numbers right = work(Device::cpu(1));
        for (const Fault& kind : kinds()) strike_work(source, kind, right, work);
    }
    for (const int count : {1, 3}) {
        const Embedding host(source, count);
        for (const auto& [sticky, made] : {std::pair(false, false), {true, false}, {false, true}})
            if (night() || count == 1)
                strike_program(host, {.call = any_call, .code = each_in_turn, .made = made, .sticky = sticky});
    }
    for (const Fault& kind : kinds()) { // up to the test of the device, which is a run
        if (kind.made || kind.code == VK_TIMEOUT) continue;
        Fault fault = kind;
        for (std::string call = "any"; !call.empty() && call != "vkCreatePipelineCache"; ++fault.before)
            call = strike_opening(source.loader, fault, objects);
    }
    for (int before = 0;
         !strike_opening(source.loader, fault_after(before, {.call = any_call, .code = each_in_turn}), objects).empty();
         ++before)
        if (before % 8 == 0) CHECK(open_device("0", source.loader).info().exact);
    check_ledger(objects);
    CHECK(figures.faults > (night() ? 3000 : 300));
    CHECK(figures.left == 0);
    MESSAGE(figures.faults << " faults injected: " << figures.errors << " errors, " << figures.absorbed << " absorbed, "
                           << figures.left << " leaks; " << figures.losses << " devices lost");
}
