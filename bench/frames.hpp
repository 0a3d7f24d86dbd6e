// SPDX-License-Identifier: MIT
// One press of one skin: a new pressure each step, linear between frames, four responses written.
#pragma once

#include "bench/limits.hpp"
#include "host/core/cpu/stream.hpp"
#include "host/core/model/streamed_skin.hpp"
#include "host/core/press/device.hpp"
#include "host/core/vulkan/recording.hpp"

#include <array>
#include <functional>

namespace bench {

struct FrameScene {
    explicit FrameScene(int n, const dermis::Material& = {});
    dermis::model::StreamedSkin streamed;
    const dermis::model::PreparedSkin& skin() const { return streamed.skin; }
    double dt = 0.01;           // s, from frame to frame
    std::vector<Floats> frames; // pitch*height each, used cyclically
    size_t cells() const { return skin().padded_cells(); }
};

// SA1, SA2, FA1, FA2, pitch*height each.
using Responses = std::array<std::vector<float>, RESPONSE_MAPS>;

// Presses the frames of a scene. The scene must outlive this object.
struct Stepper {
    std::function<double(int frames)> press; // seconds; on a device, the device's own
    std::function<Responses()> responses;    // of the last frame
};
// The library's loops. fa1: compute FA1 alone.
Stepper library(const FrameScene&, int threads, const dermis::simd::Isa&, bool fa1 = false);
// Moves the memory of a frame and computes next to nothing. There are two ways to write responses, past the caches and
// through them; the time of the faster one is a lower limit for every kernel.
Stepper moves(const FrameScene&, int threads, bool past_caches);
// The native peer: the same work as the library's, with any order of operations and fused multiply-add, in one loop,
// which steps a row and answers the one above it.
Stepper native_loop(const FrameScene&, int threads, bool past_caches);
// The library's kernel on a device, or one that only moves the same memory.
Stepper on_device(const FrameScene&, std::shared_ptr<dermis::vulkan::Context>, bool moves);

// The greatest error that a peer may have, by the greatest value.
constexpr double peer_error = 8e-7;
// The greatest error of each response after so many presses from rest, by its greatest value, against the same model
// in double.
std::array<double, RESPONSE_MAPS> errors_of_frames(const FrameScene&, int presses, const Responses&);

} // namespace bench
