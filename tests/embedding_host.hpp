// SPDX-License-Identifier: MIT
// A host around a SkinProgram, with memory and submissions of its own.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/vulkan/recording.hpp"
#include "tests/support.hpp"

#include <cstring>

namespace test {

using vulkan::Binding;
using vulkan::Buffer;
using vulkan::Buffers;
using vulkan::Context;
using vulkan::Memory;
using vulkan::SkinProgram;

// A buffer of the host's with room before the range that is bound, where nothing may be written.
struct Range {
    static constexpr VkDeviceSize before = 512;
    Buffer buffer;
    VkDescriptorBufferInfo info;
    Range(Context& context, const Memory& m)
        : buffer(context, before + m.bytes + 256, Buffer::Location::host), info{buffer.handle(), before, m.bytes} {
        std::memset(buffer.data(), 0x7b, buffer.bytes());
        std::memset(data(), 0, m.bytes);
        std::copy(m.initial.begin(), m.initial.end(), data());
    }
    char* data() const { return static_cast<char*>(buffer.data()) + before; }
    bool untouched_around() const {
        const char* all = static_cast<const char*>(buffer.data());
        bool same = true;
        for (VkDeviceSize i = 0; i < buffer.bytes(); ++i)
            same &= (i >= before && i < before + info.range) || all[i] == 0x7b;
        return same;
    }
};

// A host with as many frames as are pressed at once: pressure 0 is at rest, frame n is pressure n.
struct Host {
    Context& context;
    SkinDescription description;
    int rows; // of all pads
    SkinProgram program;
    Range constants, invalid, scratch;
    std::vector<std::unique_ptr<Range>> states, pressures, responses;
    std::vector<Binding> bindings;

    Host(Context& c, const SkinDescription& d, int frames, const SkinOptions& options = {})
        : Host(c, c.handles(), d, frames, options) {}
    // handles: of the context, but for what stands between the program and the loader.
    Host(Context& c, const vulkan::Handles& handles, const SkinDescription& d, int frames, const SkinOptions& options)
        : context(c), description(d), rows(d.grid.height * options.count),
          program(handles, d, uint32_t(frames), options), constants(c, program.memory().constants),
          invalid(c, program.memory().invalid), scratch(c, program.memory().scratch) {
        const auto& m = program.memory();
        for (int i = 0; i <= frames; ++i) {
            states.push_back(std::make_unique<Range>(c, m.state));
            pressures.push_back(std::make_unique<Range>(c, m.pressure));
            responses.push_back(std::make_unique<Range>(c, m.response));
        }
        for (int i = 1; i <= frames; ++i) bindings.push_back(program.bind(buffers(i)));
    }
    // The ranges of press i = 1, 2 ..
    Buffers buffers(int i) const {
        const auto at = [](const auto& list, int k) { return list[size_t(k)]->info; };
        return {.constants = constants.info,
                .state_from = at(states, i - 1),
                .state_to = at(states, i),
                .pressure_from = at(pressures, i - 1),
                .pressure_to = at(pressures, i),
                .response = at(responses, i),
                .invalid = invalid.info,
                .scratch = scratch.info};
    }
    void set_pressure(int i, const std::vector<float>& map) {
        const int width = description.grid.width;
        auto* to = reinterpret_cast<float*>(pressures[size_t(i)]->data());
        for (int y = 0; y < rows; ++y) {
            std::memcpy(to + y * program.pitch(), map.data() + y * width, size_t(width) * sizeof(float));
            for (int x = width; x < program.pitch(); ++x) to[y * program.pitch() + x] = NAN; // nobody's
        }
    }
    std::vector<float> response(int i, Quantity q) const {
        const SkinProgram::Range r = program.range(q);
        const auto* from = reinterpret_cast<const float*>(responses[size_t(i)]->data()) + r.first;
        if (!description.sites.empty()) return {from, from + r.count};
        std::vector<float> map;
        for (int y = 0; y < rows; ++y)
            map.insert(map.end(), from + y * program.pitch(), from + y * program.pitch() + description.grid.width);
        return map;
    }
    uint32_t not_finite() const {
        uint32_t n = 0;
        std::memcpy(&n, invalid.data(), sizeof n);
        return n;
    }
    bool untouched_around() const {
        bool same = constants.untouched_around() && invalid.untouched_around() && scratch.untouched_around();
        for (const auto* list : {&states, &pressures, &responses})
            for (const auto& range : *list) same &= range->untouched_around();
        return same;
    }
};

// Records the barrier that the header asks for between presses.
inline void barrier(Context& context, VkCommandBuffer commands, const SkinProgram& program) {
    const auto last = program.last_access(), first = program.first_access();
    const VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, last.access, first.access};
    context.calls().vkCmdPipelineBarrier(commands, last.stages, first.stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

// All frames in one command buffer, and every response against the CPU path's.
inline void check_presses(Context& context, const SkinDescription& d, const SkinOptions& options = {}) {
    const double steps[] = {0.01, 0.02, 0.0, 0.3};
    Host host(context, d, 4, options);
    Skin skin(Device::cpu(1), d, options);
    for (int i = 1; i <= 4; ++i) host.set_pressure(i, frame(d, i));
    vulkan::Recording recording(context);
    const VkCommandBuffer commands = recording.commands();
    for (int i = 1; i <= 4; ++i) {
        REQUIRE(host.program.record_press(commands, host.bindings[size_t(i - 1)], steps[i - 1]));
        barrier(context, commands, host.program);
    }
    context.barrier(commands);
    recording.submit();
    for (int i = 1; i <= 4; ++i) {
        skin.press(frame(d, i), steps[i - 1]);
        for (Quantity q : all_responses) {
            if (host.program.range(q).count == 0) continue;
            CAPTURE(i);
            CAPTURE(name(q));
            CHECK(host.response(i, q) == answers(skin, q));
        }
    }
    CHECK(host.not_finite() == 0);
    CHECK(host.untouched_around());
}

} // namespace test
