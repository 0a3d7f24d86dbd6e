// SPDX-License-Identifier: MIT
// Finds mistakes in a Vulkan host's own code before its first frame: copy this header into the host. The host uploads
// two known pressures, presses them and reads the responses back as it will do with every frame; the trial says what
// the responses show.
//
//     const Trial trial(description, options);                           // description and options of the program
//     upload(trial.pressure(1)), press by Trial::dt, and the same with pressure(2)   // from a skin at rest
//     const std::string fault = trial.fault(program, 2, responses, bytes);
//
// It recognizes rows of pressure that were written width numbers apart instead of pitch(), constants that were never
// uploaded, and states that were swapped.
#pragma once

#include <dermis/vulkan.hpp>

#include <algorithm>
#include <cstring>

class Trial {
  public:
    static constexpr double dt = 0.01; // s

    explicit Trial(const dermis::SkinDescription& d, const dermis::SkinOptions& o = {}) : description_(d), options_(o) {
        const size_t cells = size_t(o.count) * size_t(d.grid.width) * size_t(d.grid.height);
        unsigned seed = 1;
        for (std::vector<float>& pressure : pressures_) // no two rows or columns alike
            for (size_t i = 0; i < cells; ++i) {
                seed = seed * 1664525u + 1013904223u;
                pressure.push_back(float(seed >> 8) / float(1 << 24) + 0.25f);
            }
        for (size_t i = 0; i < asked_.size(); ++i) {
            if (d.sites.empty()) asked_[i] = std::count(o.responses.begin(), o.responses.end(), classes[i]) > 0;
            for (const dermis::Site& site : d.sites) asked_[i] = asked_[i] || site.type == classes[i];
        }
    }

    // The pressure at the end of press 1 or 2, Pa: width*height floats for each pad, row 0 first.
    const std::vector<float>& pressure(int press) const { return pressures_.at(size_t(press - 1)); }

    // Says what is wrong after press 1 or 2; empty if the responses have the CPU path's bits. responses: the content of
    // memory().response, so many bytes.
    std::string fault(const dermis::vulkan::SkinProgram& program, int press, const void* responses,
                      size_t bytes) const {
        if (!responses || bytes < program.memory().response.bytes)
            return "responses: fewer than memory().response.bytes = " + std::to_string(program.memory().response.bytes);
        const Responses given = read(program, static_cast<const float*>(responses));
        const auto right = [](const std::vector<float>& p) { return p; };
        if (same(given, pressed(description_, press, right))) return "";
        const size_t width = size_t(description_.grid.width), pitch = size_t(program.pitch());
        if (same(given, pressed(description_, press, [&](const auto& p) { return misread(p, width, pitch); })))
            return "pressures: rows stand width = " + std::to_string(width) +
                   " numbers apart, not SkinProgram::pitch() = " + std::to_string(pitch);
        if (press == 2 && same(given, from_rest()))
            return "state_from: press 2 began from the state before press 1; it must begin from what that one wrote to "
                   "state_to";
        dermis::SkinDescription flat = description_; // zeros are the curvature at rest of a flat surface
        flat.surface = {};
        flat.surface.kind = dermis::Surface::Kind::flat;
        flat.surface.relief = description_.surface.relief;
        bool untouched = true; // except the first number: zeros in place of receptors write there
        for (const std::vector<float>& r : given)
            for (const float& x : r) untouched = untouched && (x == 0 || &x == given[0].data());
        if (description_.sites.empty() ? same(given, pressed(flat, press, right)) : untouched)
            return "constants: they are zeros; upload memory().constants.initial before the first press";
        return "responses: other bits than the CPU path's, for no reason that this trial knows; "
               "SkinProgram::record_check tells whether the device gives these bits";
    }

  private:
    static constexpr dermis::Quantity classes[] = {dermis::Quantity::sa1, dermis::Quantity::sa2, dermis::Quantity::fa1,
                                                   dermis::Quantity::fa2};
    using Responses = std::array<std::vector<float>, 4>; // by classes; empty if a response is not asked for

    // Returns the width*height numbers of each pad that a kernel reads if a host writes rows `width` numbers apart into
    // a buffer of zeros in which the kernel expects them `pitch` numbers apart.
    static std::vector<float> misread(const std::vector<float>& dense, size_t width, size_t pitch) {
        std::vector<float> read;
        for (size_t row = 0; row < dense.size() / width; ++row)
            for (size_t x = 0; x < width; ++x) {
                const size_t at = row * pitch + x;
                read.push_back(at < dense.size() ? dense[at] : 0.0f);
            }
        return read;
    }
    static bool same(const Responses& a, const Responses& b) {
        for (size_t i = 0; i < a.size(); ++i)
            if (a[i].size() != b[i].size() || std::memcmp(a[i].data(), b[i].data(), a[i].size() * sizeof(float)) != 0)
                return false;
        return true;
    }

    dermis::Skin made(const dermis::SkinDescription& d) const {
        return dermis::Skin(dermis::Device::cpu(1), d, options_);
    }
    Responses responses_of(const dermis::Skin& skin) const {
        Responses all;
        for (size_t i = 0; i < all.size(); ++i)
            if (asked_[i]) {
                const dermis::Skin::Response r = skin.response(classes[i]);
                all[i].assign(r.begin(), r.end());
            }
        return all;
    }
    // The responses after one or both presses, whose pressures `change` changes.
    template <class Change>
    Responses pressed(const dermis::SkinDescription& d, int presses, const Change& change) const {
        dermis::Skin skin = made(d);
        for (int i = 1; i <= presses; ++i) skin.press(change(pressure(i)), dt);
        return responses_of(skin);
    }
    // The responses of a second press that starts from the state at rest and from the first press's pressure.
    Responses from_rest() const {
        dermis::Skin skin = made(description_);
        skin.press(pressure(1), 0);
        skin.press(pressure(2), dt);
        return responses_of(skin);
    }
    // The responses that a host has read back.
    Responses read(const dermis::vulkan::SkinProgram& program, const float* responses) const {
        Responses all;
        const size_t width = size_t(description_.grid.width), pitch = size_t(program.pitch());
        for (size_t i = 0; i < all.size(); ++i) {
            const dermis::vulkan::SkinProgram::Range r = program.range(classes[i]);
            if (!description_.sites.empty()) all[i].assign(responses + r.first, responses + r.first + r.count);
            else
                for (size_t at = r.first; at < r.first + r.count; at += pitch)
                    all[i].insert(all[i].end(), responses + at, responses + at + width);
        }
        return all;
    }

    const dermis::SkinDescription description_;
    const dermis::SkinOptions options_;
    std::array<bool, 4> asked_ = {};
    std::array<std::vector<float>, 2> pressures_;
};
