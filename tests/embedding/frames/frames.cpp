// SPDX-License-Identifier: MIT
// A simulator with a device of its own: its shader presses a dome into a fingertip, dermis answers, and its next shader
// makes spikes of FA1 and SA1. Three frames are in flight. Every answer is compared with the CPU's.
#include "simulator.hpp"

#include <dermis/skin.hpp>
#include <dermis/vulkan.hpp>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace {

using dermis::Quantity;
using Place = Gpu::Place;

constexpr int frames = 60;
double step(int frame) { return frame == 30 ? 0 : 1.0 / (frame % 2 ? 60 : 120); } // s

dermis::SkinDescription fingertip() {
    dermis::SkinDescription d;
    d.grid = {.width = 200, .height = 150, .spacing = 50e-6};
    d.surface = {.kind = dermis::Surface::Kind::wave, .relief = 50e-6};
    d.material = {.modulus = 1e5, .viscosity = 5e3, .thickness = 1e-3, .curvature_length = 1e-4};
    d.sites = dermis::population(d.grid, {.sa1 = 70, .sa2 = 0, .fa1 = 140, .fa2 = 0});
    return d;
}

Scope scope(dermis::vulkan::Access a) { return {a.stages, a.access}; }

struct Totals {
    std::string device;
    size_t compared = 0, different = 0, not_zero = 0, spikes = 0;
    uint32_t invalid = 0;
    double seconds = 0; // of all presses, on the device
};

Wanted wanted_of(const dermis::vulkan::Requirements& needs) {
    Wanted wanted;
    wanted.api_version = std::max(wanted.api_version, needs.api_version);
    wanted.storage_buffers = needs.storage_buffers;
    for (auto& names : {needs.required_if_offered, needs.used_if_enabled})
        wanted.device_extensions.insert(wanted.device_extensions.end(), names.begin(), names.end());
    return wanted;
}

Buffer buffer_of(Gpu& gpu, const dermis::vulkan::Memory& m, Place place, VkBufferUsageFlags also = 0) {
    return gpu.buffer(m.bytes, m.usage | also, place, m.initial);
}

// Throws unless the device's bits are the CPU's.
void need_same_bits(Gpu& gpu, dermis::vulkan::SkinProgram& skin, VkCommandBuffer commands) {
    const Buffer check = buffer_of(gpu, skin.memory().check, Place::host);
    skin.bind_check(check.info());
    gpu.begin(commands);
    if (!skin.record_check(commands)) throw std::runtime_error("record_check");
    gpu.barrier(commands, scope(skin.last_access()), host_reads);
    gpu.wait(gpu.submit(commands));
    if (!skin.check_passed(check.data, skin.memory().check.bytes))
        throw std::runtime_error("the device's bits are not the CPU's");
}

// The memory of the frames in flight.
struct Memory {
    Buffer constants, invalid;
    Simulator::Buffers states, pressures, responses;
};

Memory memory_of(Gpu& gpu, const dermis::vulkan::MemoryNeeds& needs) {
    Memory m{.constants = buffer_of(gpu, needs.constants, Place::device),
             .invalid = buffer_of(gpu, needs.invalid, Place::host)};
    for (int i = 0; i < in_flight; ++i) {
        m.states[i] = buffer_of(gpu, needs.state, Place::device);
        m.pressures[i] = buffer_of(gpu, needs.pressure, Place::device, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
        m.responses[i] = buffer_of(gpu, needs.response, Place::device);
    }
    return m;
}

// Presses the CPU's skin with a frame that is done, and counts the answers that differ.
void compare(int frame, const Simulator& simulator, dermis::Skin& cpu, Totals& totals) {
    const int slot = frame % in_flight;
    cpu.press(simulator.pressure(slot), step(frame));
    const Reading* reading = simulator.readings(slot);
    for (Quantity q : {Quantity::fa1, Quantity::sa1})
        for (float answer : cpu.response(q)) {
            if (std::memcmp(&answer, &reading->response, sizeof answer) != 0 && totals.different++ == 0)
                std::fprintf(stderr, "frame %d, %s: %a, on the CPU %a\n", frame, dermis::name(q), reading->response,
                             answer);
            ++totals.compared;
            totals.not_zero += answer != 0;
            totals.spikes += reading++->spikes;
        }
}

Totals simulate(int& messages) {
    Gpu gpu(wanted_of(dermis::vulkan::requirements()), messages);
    const dermis::SkinDescription description = fingertip();
    const dermis::vulkan::Handles handles{gpu.instance(),        gpu.physical(),    gpu.device(),
                                          vkGetInstanceProcAddr, gpu.api_version(), gpu.extensions()};
    dermis::vulkan::SkinProgram skin(handles, description, in_flight);
    const Drained drained(gpu); // before the program goes
    const Scope first = scope(skin.first_access()), last = scope(skin.last_access());
    VkCommandBuffer commands[in_flight];
    for (VkCommandBuffer& c : commands) c = gpu.commands();
    need_same_bits(gpu, skin, commands[0]);

    const Memory memory = memory_of(gpu, skin.memory());
    dermis::vulkan::Binding bindings[in_flight];
    for (int to = 0; to < in_flight; ++to) {
        const int from = (to + in_flight - 1) % in_flight; // the frame before; at first a skin at rest
        bindings[to] = skin.bind({memory.constants.info(), memory.states[from].info(), memory.states[to].info(),
                                  memory.pressures[from].info(), memory.pressures[to].info(),
                                  memory.responses[to].info(), memory.invalid.info()});
    }
    const Patch patch{description.grid.width, description.grid.height, skin.pitch()};
    const auto fa1 = skin.range(Quantity::fa1), sa1 = skin.range(Quantity::sa1);
    const Simulator simulator(gpu, patch, {int(fa1.first), int(fa1.count), int(sa1.first), int(sa1.count)},
                              memory.pressures, memory.responses);
    const VkQueryPool stamps = gpu.timestamps(2 * in_flight);

    Totals totals{.device = gpu.properties().deviceName};
    dermis::Skin cpu(dermis::Device::cpu(1), description);

    uint64_t done[in_flight]{};
    double now = 0;
    for (int n = 0; n < frames + in_flight; ++n) {
        const int slot = n % in_flight;
        const uint32_t stamp = uint32_t(2 * slot);
        gpu.wait(done[slot]);
        if (n >= in_flight) {
            totals.seconds += gpu.seconds(stamps, stamp);
            compare(n - in_flight, simulator, cpu, totals);
        }
        if (n >= frames) continue;
        const VkCommandBuffer c = commands[slot];
        const double dt = step(n);
        gpu.begin(c);
        gpu.barrier(c, last | shaders | copies, first | shaders | copies); // the frames before
        vkCmdResetQueryPool(c, stamps, stamp, 2);
        simulator.record_pressure(c, slot, now += dt);
        gpu.barrier(c, shaders, first);
        if (!skin.record_press(c, bindings[slot], dt, {stamps, stamp})) throw std::runtime_error("record_press");
        gpu.barrier(c, last, shaders | host_reads); // the host's is `invalid`
        simulator.record_spikes(c, slot, dt);
        simulator.record_readback(c, slot);
        done[slot] = gpu.submit(c);
    }
    std::memcpy(&totals.invalid, memory.invalid.data, sizeof totals.invalid);
    return totals;
}

} // namespace

int main() try {
    int messages = 0;
    const Totals t = simulate(messages);
    std::printf("%s: %d frames, %zu answers compared, %zu different, %zu not 0; %zu spikes; %u pressures not finite; "
                "%.0f us a press; %d messages\n",
                t.device.c_str(), frames, t.compared, t.different, t.not_zero, t.spikes, t.invalid,
                t.seconds / frames * 1e6, messages);
    return t.compared == 0 || t.different || t.not_zero == 0 || t.invalid || messages;
} catch (const std::exception& e) {
    std::fprintf(stderr, "frames: %s\n", e.what());
    return 1;
}
