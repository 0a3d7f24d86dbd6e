// SPDX-License-Identifier: MIT
// dermis::Skin: frames in, responses out, on the CPU or on a device.
#include "host/cpu/stream.hpp"
#include "host/device.hpp"
#include "host/plan/float_environment.hpp"
#include "host/scene/refusal.hpp"
#include "host/vulkan/runner.hpp"

#include <algorithm>
#include <cstring>

namespace dermis {
namespace {

constexpr size_t line = 64 / sizeof(float);

// Maps that are walked side by side: each begins at a cache line, and at other bits of an address than its neighbours,
// which would otherwise fight for the same lines of a cache.
class Block {
  public:
    explicit Block(const std::vector<size_t>& sizes) {
        size_t all = line;
        for (size_t size : sizes) all += size + gap;
        values_.assign(all, 0.0f);
        size_t at = (64 - reinterpret_cast<uintptr_t>(values_.data()) % 64) % 64 / sizeof(float);
        for (size_t size : sizes) {
            begins_.push_back(values_.data() + at);
            at += (size + line - 1) / line * line + 5 * line;
        }
    }
    float* operator[](size_t i) { return begins_[i]; }
    void clear() { std::fill(values_.begin(), values_.end(), 0.0f); }

  private:
    static constexpr size_t gap = 6 * line;
    std::vector<float> values_;
    std::vector<float*> begins_;
};

} // namespace

struct Skin::Impl {
    Impl(const SkinDescription& description, const SkinOptions& options)
        : plan(plan::skin_plan(description, options)), width(size_t(plan.constants.width)),
          height(size_t(plan.constants.height)), pitch(size_t(plan.pitch)), fields(plan.scene.sites.empty()),
          answers(plan::response_layout_of(plan)) {}

    plan::Plan plan;
    const size_t width, height, pitch;
    const bool fields;
    const plan::ResponseLayout answers;
    std::unique_ptr<vulkan::SkinRunner> runner; // either
    std::unique_ptr<cpu::Frames> frames;
    std::optional<Block> memory; // of frames: two pressures, responses of SA1, SA2, FA1, FA2
    float* pressure[2] = {};
    float* answer[4] = {};
    double dt = -1;              // that of the last press
    std::vector<float> dense[4]; // fields without what lies beyond the width

    const float* of(int q) const { // where the backend has put it
        return runner ? runner->answers() + answers.of[size_t(q)].first : answer[q - 1];
    }
};

Skin::Skin(const Device& device, const SkinDescription& description, const SkinOptions& options) {
    const DefaultFloats guard;
    impl_ = std::make_unique<Impl>(description, options);
    Impl& s = *impl_;
    Device::Impl& d = device.impl();
    if (d.context) {
        s.plan.maps = {}; // the program makes its own
        s.runner = std::make_unique<vulkan::SkinRunner>(d.context, description, options);
        const bool exact = s.runner->exact();
        d.info.exact &= exact;
        if (!exact && !d.named)
            throw Error(Error::Code::no_device, "device",
                        d.info.name +
                            ": its bits differ from the CPU path's; ask for it by name to use it all the same");
    } else {
        s.frames = std::make_unique<cpu::Frames>(s.plan, d.threads);
        s.plan.maps = {}; // they have been made use of
        const size_t map = s.pitch * s.height;
        std::vector<size_t> sizes = {map, map};
        for (int q = 1; q < REDUCED_MAPS; ++q) sizes.push_back(s.answers.of[size_t(q)].count);
        s.memory.emplace(sizes);
        for (size_t i = 0; i < 2; ++i) s.pressure[i] = (*s.memory)[i];
        for (size_t r = 0; r < 4; ++r) s.answer[r] = s.plan.wanted[r + 1] ? (*s.memory)[2 + r] : nullptr;
    }
    for (size_t r = 0; r < 4; ++r)
        if (s.fields && s.width != s.pitch && s.plan.wanted[r + 1]) s.dense[r].assign(s.width * s.height, 0.0f);
}

Skin::~Skin() = default;
Skin::Skin(Skin&&) noexcept = default;
Skin& Skin::operator=(Skin&&) noexcept = default;

void Skin::press(const float* pressure, size_t cells, double dt) {
    Impl& s = *impl_;
    if (!scene::finite(dt) || dt < 0) scene::need_not_negative("dt", dt); // whose words are allocated
    if (dt != s.dt) {
        const DefaultFloats guard;
        if (!plan::in_float(s.plan.media, dt))
            scene::need(false, "dt", dt, "seconds over which the coefficients of a step stay below 3.4e38");
        s.dt = dt;
    }
    if (cells != s.width * s.height)
        scene::refuse("pressure", std::to_string(cells) + " cells",
                      "width*height = " + std::to_string(s.width * s.height) + ", row 0 first");
    bool all = true; // without a way out, for the compiler's vectors
    for (size_t i = 0; i < cells; ++i) all &= (std::bit_cast<uint32_t>(pressure[i]) & 0x7f800000u) != 0x7f800000u;
    for (size_t i = 0; !all && i < cells; ++i)
        if (!scene::finite(double(pressure[i])))
            scene::refuse("pressure", shortest(double(pressure[i])) + " in cell " + scene::cell_text(i, int(s.width)),
                          "finite numbers");
    float* to = s.runner ? s.runner->pressure() : s.pressure[1];
    if (s.width == s.pitch) std::memcpy(to, pressure, cells * sizeof(float));
    else
        for (size_t y = 0; y < s.height; ++y)
            std::memcpy(to + y * s.pitch, pressure + y * s.width, s.width * sizeof(float));
    if (s.runner) {
        const DefaultFloats guard;
        s.runner->press(dt);
    } else {
        s.frames->press(dt, s.pressure[0], s.pressure[1], s.answer);
        std::swap(s.pressure[0], s.pressure[1]);
    }
    for (int q = 1; q < REDUCED_MAPS; ++q) {
        std::vector<float>& dense = s.dense[q - 1];
        for (size_t y = 0; !dense.empty() && y < s.height; ++y)
            std::memcpy(dense.data() + y * s.width, s.of(q) + y * s.pitch, s.width * sizeof(float));
    }
}

Skin::Response Skin::response(Quantity q) const {
    const Impl& s = *impl_;
    if (q < Quantity::sa1 || q > Quantity::fa2 || !s.plan.wanted[int(q)])
        scene::refuse("response", std::string("\"") + name(q) + "\"",
                      s.fields ? "what SkinOptions::responses asks for" : "the classes of the description's sites");
    const std::vector<float>& dense = s.dense[int(q) - 1];
    return {dense.empty() ? s.of(int(q)) : dense.data(), s.fields ? s.width * s.height : s.answers.of[size_t(q)].count};
}

void Skin::reset() {
    Impl& s = *impl_;
    if (s.runner) {
        s.runner->reset();
    } else {
        s.frames->reset();
        s.memory->clear();
    }
    for (std::vector<float>& dense : s.dense) std::fill(dense.begin(), dense.end(), 0.0f);
}

} // namespace dermis
