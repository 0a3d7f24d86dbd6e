// SPDX-License-Identifier: MIT
// Skins as robots have them, their pressures, and how they are pressed.
#pragma once

#include "bench/bench.hpp"

#include <cmath>

namespace bench {

constexpr double press_dt = 0.001; // s

// Cells of 0.25 mm, unless another spacing is given.
dermis::SkinDescription rectangle(int width, int height, double spacing = 2.5e-4);
// Retardation times from 4 ms on, each three times the one before.
dermis::Material chain_of(int elements, bool spring);

// How materials are spread over a grid: the index of each cell's material; empty if there is one.
enum class Spread { uniform, patches, random, thousand, each };
std::vector<size_t> materials_of(Spread, size_t n);

dermis::SkinOptions in_f32(int pads = 1);

// Skins of one kind, and how they are pressed.
struct Press {
    std::string model;
    dermis::SkinDescription skin;
    dermis::SkinOptions options = in_f32();
    int skins = 1;                                   // pressed one by one
    size_t frames = 1;                               // of one call
    bool cells = false;                              // the pressures of the cells of their sites alone are handed over
    std::string stencil = "five-point", method = {}; // method: empty: the shape
    bool reads_each = false, reads_last = false; // the response FA2, after each press or after the last one of a run
    long long cells_of_frame() const;
};

// The pressures of a ring of frames one after another, Pa: at random, or the same in all cells.
using Frames = std::shared_ptr<const std::vector<float>>;
Frames frames_of(const Press&, size_t ring, float pressure = NAN);

// The row of a workload and its work: so many frames of the ring. Throws if a device, or several threads, have other
// bits than one thread.
Contender pressed(const Bench&, const dermis::Device&, const char* workload, const Press&, long long steps,
                  const Frames&, size_t ring);

// The same work and bits by a loop that is written for this one kind of pad and compiled for this processor.
Contender native_pads(const Bench&, const dermis::Device&, const dermis::SkinDescription&, int pads, long long steps,
                      const Frames&, size_t ring);

} // namespace bench
