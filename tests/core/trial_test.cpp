// SPDX-License-Identifier: MIT
// labels: device threads
// The example's Trial finds the mistakes that a host can make with memory, bindings and rows before its first frame.
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"
#include "host/examples/vulkan_trial.hpp"
#include "tests/embedding_host.hpp"

using namespace test;

namespace {

// Ways to press a trial's pressures, all but the first with a mistake.
enum class Way { right, width_for_pitch, no_constants, swapped_states };

// The fault that the trial tells of after its second press.
std::string told(Context& context, const SkinDescription& d, const SkinOptions& options, Way way) {
    const Trial trial(d, options);
    Host host(context, d, 2, options);
    if (way == Way::no_constants) std::memset(host.constants.data(), 0, host.program.memory().constants.bytes);
    for (int i : {1, 2}) {
        host.set_pressure(i, trial.pressure(i));
        if (way != Way::width_for_pitch) continue;
        std::memset(host.pressures[size_t(i)]->data(), 0, host.program.memory().pressure.bytes);
        std::memcpy(host.pressures[size_t(i)]->data(), trial.pressure(i).data(),
                    trial.pressure(i).size() * sizeof(float));
    }
    vulkan::Buffers second = host.buffers(2);
    if (way == Way::swapped_states) std::swap(second.state_from, second.state_to); // rests, as before press 1
    for (VkDescriptorBufferInfo* b : {&second.constants, &second.state_to, &second.pressure_from, &second.response})
        b->range = VK_WHOLE_SIZE;
    vulkan::SkinProgram program(context.handles(), d, 2, options);
    const Binding bindings[] = {program.bind(host.buffers(1)), program.bind(second)};
    vulkan::Recording recording(context);
    const VkCommandBuffer commands = recording.commands();
    for (const Binding& binding : bindings) {
        REQUIRE(program.record_press(commands, binding, Trial::dt));
        barrier(context, commands, program);
    }
    context.barrier(commands);
    recording.submit();
    const size_t bytes = size_t(program.memory().response.bytes);
    if (way == Way::right) CHECK(trial.fault(program, 1, host.responses[1]->data(), bytes).empty());
    CHECK(trial.fault(program, 2, host.responses[2]->data(), bytes - 4).find("memory().response.bytes") !=
          std::string::npos);
    return trial.fault(program, 2, host.responses[2]->data(), bytes);
}

} // namespace

TEST_CASE("a trial of a host's code finds rows a width apart, constants never uploaded and swapped states") {
    const Validated vulkan;
    Context& context = *vulkan::context_of(*vulkan.device().impl().backend);
    for (bool sites : {false, true})
        for (int count : {1, 3}) {
            CAPTURE(sites);
            CAPTURE(count);
            SkinOptions options{.count = count};
            const SkinDescription d = with_sites(ridged(21, 9), sites ? 40 : 0);
            CHECK(told(context, d, options, Way::right) == "");
            CHECK(told(context, d, options, Way::width_for_pitch).find("SkinProgram::pitch()") != std::string::npos);
            CHECK(told(context, d, options, Way::no_constants).find("constants") == 0);
            CHECK(told(context, d, options, Way::swapped_states).find("state_from") == 0);
        }
}

TEST_CASE("a press that is refused says why") {
    const Validated vulkan;
    Context& context = *vulkan::context_of(*vulkan.device().impl().backend);
    const SkinDescription d = ridged(20, 9);
    Host host(context, d, 1);
    const Binding binding = host.bindings[0];
    vulkan::Recording recording(context);
    const VkCommandBuffer commands = recording.commands();
    const auto why = [](const vulkan::Recorded& r) { return r ? std::string() : std::string(r.refused); };
    CHECK(why(host.program.record_press(commands, binding, 0.1)) == "");
    CHECK(why(host.program.record_press(commands, binding, NAN)).find("dt") == 0);
    CHECK(why(host.program.record_press(commands, binding, -1)).find(">= 0") != std::string::npos);
    CHECK(why(host.program.record_press(commands, binding, 1e39)).find("3.4e38") != std::string::npos);
    CHECK(why(host.program.record_press(commands, Binding(), 0.1)).find("binding") != std::string::npos);
    const double dt = 0.1;
    CHECK(why(host.program.record_press(commands, binding, Pads(), &dt, 1)).find("single skin") != std::string::npos);
    recording.submit();
    std::vector<char> bytes(size_t(host.program.memory().check.bytes) - 1);
    refuses([&] { (void)host.program.check_passed(bytes.data(), bytes.size()); }, "memory().check.bytes");
}
