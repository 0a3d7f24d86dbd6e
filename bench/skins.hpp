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
    bool reads_each = false, reads_last = false;     // FA2, after each press or after the last one of a run
    size_t ring = 2;                                 // pressures, which are used cyclically
    float pressure = NAN;                            // Pa, of the first of them, in all cells; NAN: at random
    bool native = false;       // by a loop that is written for this one kind of pad and compiled for this processor
    std::string ratio_to = {}; // the model of an earlier press of the same round and place
    long long cells_of_frame() const;
};

Press hand_of_sites(int n); // receptors of a fingertip on n x n cells

// The pressures of a ring one after another, Pa.
using Frames = std::shared_ptr<const std::vector<float>>;

// How many presses a run has: as many as step about so many cells.
struct Length {
    double cells, cells_on_software;                               // the latter on a device whose kind is "software"
    int least = 1, most = 2000, most_on_software = 2000, unit = 1; // least and most: of units
    long long of(const dermis::Device&, const Press&) const;
};
constexpr Length fixed(int presses) { return {0, 0, presses, presses, presses}; }

// Times presses at each place in the same rounds. Throws if a device, or several threads, have other bits than one
// thread.
void measure_presses(Bench&, const char* workload, const std::vector<dermis::Device>& places, const std::vector<Press>&,
                     const Length&, int times);
// The row of a press, without its place.
Measurement described(Measurement, const Press&, long long steps);
// The work and the bits of a press of pads by a loop of their own.
std::function<double()> native_pads(const Press&, int threads, long long steps, const Frames&);

} // namespace bench
