// SPDX-License-Identifier: MIT
// dermis::vulkan::Trial: what the responses to known pressures say of a host's own code.
#include "dermis/vulkan.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/description/description.hpp"

#include <cstring>
#include <optional>

namespace dermis::vulkan {
namespace {

// By scene::receptor_classes; empty where a response is not asked for.
using Responses = std::array<std::vector<float>, std::size(scene::receptor_classes)>;

// Pressures with no two rows or columns alike.
std::vector<float> pressures(size_t count, unsigned seed) {
    std::vector<float> all;
    for (size_t i = 0; i < count; ++i) {
        seed = seed * 1664525u + 1013904223u;
        all.push_back(float(seed >> 8) / float(1 << 24) + 0.25f);
    }
    return all;
}

// Returns the width*height numbers of each pad that a kernel reads if a host writes rows `width` numbers apart into a
// buffer of zeros in which the kernel expects them `pitch` numbers apart.
std::vector<float> misread(const std::vector<float>& dense, size_t width, size_t pitch) {
    std::vector<float> read;
    for (size_t row = 0; row < dense.size() / width; ++row)
        for (size_t x = 0; x < width; ++x) {
            const size_t at = row * pitch + x;
            read.push_back(at < dense.size() ? dense[at] : 0.0f);
        }
    return read;
}

Responses responses_of(const Skin& skin, const std::vector<bool>& asked) {
    Responses all;
    for (size_t i = 0; i < all.size(); ++i)
        if (asked[i]) {
            const Skin::Response r = skin.response(scene::receptor_classes[i].type);
            all[i].assign(r.begin(), r.end());
        }
    return all;
}

bool same(const Responses& a, const Responses& b) {
    for (size_t i = 0; i < a.size(); ++i)
        if (a[i].size() != b[i].size() || std::memcmp(a[i].data(), b[i].data(), a[i].size() * sizeof(float)) != 0)
            return false;
    return true;
}

} // namespace

struct Trial::Impl {
    Impl(const SkinDescription& d, const SkinOptions& o) : description(d), options(o) {
        const Skin skin = made(d);
        const size_t cells = size_t(skin.count()) * size_t(d.grid.width) * size_t(d.grid.height);
        for (unsigned press : {1, 2}) pressure[press - 1] = pressures(cells, press);
        for (const scene::ReceptorClass& c : scene::receptor_classes) {
            const Quantity q = c.type;
            bool wanted = false;
            if (d.sites.empty())
                for (Quantity r : o.responses) wanted |= r == q;
            for (const Site& site : d.sites) wanted |= site.type == q;
            asked.push_back(wanted);
        }
    }

    Skin made(const SkinDescription& d) const { return Skin(Device::cpu(1), d, options); }

    // The responses after one or both presses, whose pressures `read` changes.
    template <class Read> Responses pressed(const SkinDescription& d, int presses, Read read) const {
        Skin skin = made(d);
        for (int i = 0; i < presses; ++i) skin.press(read(pressure[size_t(i)]), dt);
        return responses_of(skin, asked);
    }

    // The responses of a second press that starts from the state at rest and from the first press's pressure.
    Responses from_rest() const {
        Skin skin = made(description);
        skin.press(pressure[0], 0);
        skin.press(pressure[1], dt);
        return responses_of(skin, asked);
    }

    // The responses that a host has read back.
    Responses given(const SkinProgram& program, const float* responses) const {
        Responses all;
        const size_t width = size_t(description.grid.width), pitch = size_t(program.pitch());
        for (size_t i = 0; i < all.size(); ++i) {
            const SkinProgram::Range r = program.range(scene::receptor_classes[i].type);
            if (!description.sites.empty()) all[i].assign(responses + r.first, responses + r.first + r.count);
            else
                for (size_t at = r.first; at < r.first + r.count; at += pitch)
                    all[i].insert(all[i].end(), responses + at, responses + at + width);
        }
        return all;
    }

    const SkinDescription description;
    const SkinOptions options;
    std::vector<bool> asked; // by scene::receptor_classes
    std::array<std::vector<float>, 2> pressure;
};

Trial::Trial(const SkinDescription& description, const SkinOptions& options)
    : impl_(scene::guarded([&] { return "a trial of " + scene::needs_of(description, options); },
                           [&] { return std::make_unique<Impl>(description, options); })) {}
Trial::~Trial() = default;

const std::vector<float>& Trial::pressure(int press) const {
    if (press != 1 && press != 2)
        throw Error(Error::Code::bad_input, "press", "press = " + std::to_string(press) + "; allowed: 1, 2");
    return impl_->pressure[size_t(press - 1)];
}

std::string Trial::fault(const SkinProgram& program, int press, const void* responses, size_t bytes) const {
    const auto words = [&] { return "a trial of " + scene::needs_of(impl_->description, impl_->options); };
    return scene::guarded(words, [&]() -> std::string {
        const Impl& t = *impl_;
        (void)pressure(press); // refuses another press
        if (!responses || bytes < program.memory().response.bytes)
            throw Error(Error::Code::bad_input, "responses",
                        "responses = " + (responses ? std::to_string(bytes) + " bytes" : std::string("(null)")) +
                            "; allowed: memory().response.bytes = " + std::to_string(program.memory().response.bytes));
        const Responses given = t.given(program, static_cast<const float*>(responses));
        const auto right = [](const std::vector<float>& p) -> const std::vector<float>& { return p; };
        if (same(given, t.pressed(t.description, press, right))) return "";
        const size_t width = size_t(t.description.grid.width), pitch = size_t(program.pitch());
        if (same(given, t.pressed(t.description, press, [&](auto& p) { return misread(p, width, pitch); })))
            return "pressures: rows stand width = " + std::to_string(width) +
                   " numbers apart, not SkinProgram::pitch() = " + std::to_string(pitch);
        if (press == 2 && same(given, t.from_rest()))
            return "state_from: press 2 began from the state before press 1; it must begin from what that one wrote to "
                   "state_to";
        SkinDescription flat = t.description; // zeros are the curvature at rest of a flat surface
        flat.surface = {};
        flat.surface.kind = Surface::Kind::flat;
        flat.surface.relief = t.description.surface.relief;
        bool untouched = true; // except the first number: zeros in place of receptors write there
        for (const auto& r : given)
            for (const float& x : r) untouched &= x == 0 || &x == given[0].data();
        if (t.description.sites.empty() ? same(given, t.pressed(flat, press, right)) : untouched)
            return "constants: they are zeros; upload memory().constants.initial before the first press";
        return "responses: other bits than the CPU path's, for no reason that this trial knows; "
               "SkinProgram::record_check tells whether the device gives these bits";
    });
}

} // namespace dermis::vulkan
