// SPDX-License-Identifier: MIT
// The loops of the native peer. They are compiled for this processor with fused multiply-add, so that this header has
// plain data and declarations alone: no inline function may be compiled both their way and the library's.
#pragma once

#include <stddef.h>

namespace bench::native {

// Cells of a vector. Maps begin at a cache line, and widths and pitches are multiples of it.
constexpr size_t lanes = 16;

// One exact step of a Kelvin-Voigt element under a pressure that runs straight from `from` to `to`. With
// r = from - E*strain and way = to - from: strain += b*r + f*way, integral += i0*strain + i1*from + i2*way (of the old
// strain), rate = v0*r + v1*way, acceleration = a0*r + a1*way.
template <class Real> struct ExactStep { Real E, b, f, i0, i1, i2, v0, v1, a0, a1; };

// One press of one skin. A row of the strain has a cell more on each side, a copy of the first and of the last.
struct Frame {
    ExactStep<float> step;
    size_t width, height, pitch, strain_pitch;
    const float *from, *to, *rest;
    float *strain, *integral;
    float* responses[4]; // SA1, SA2, FA1, FA2
};

// A thread's own rows: the new strain of the row above its first and of the row below its last, and the rate and the
// acceleration of the row that is answered next.
struct ThreadRows {
    float *above, *below, *rate, *acceleration;
};

// Fills `above` and `below` for rows first .. last - 1; every thread does so before any of them steps.
void step_beside(const Frame&, size_t first, size_t last, const ThreadRows&);
// Steps rows first .. last - 1 in place and writes their responses past the caches, or through them.
void press_rows(const Frame&, size_t first, size_t last, const ThreadRows&, bool past_caches);

// The memory of a streamed frame: the four responses are written from registers, past the caches or through them.
struct Moved {
    const float *from, *to, *rest;
    float *strain, *integral;
    float* responses[4];
    bool past_caches;
};

// Reads and writes the cells first .. last - 1, multiples of `lanes`, as a step does, and computes next to nothing.
void move_cells(const Moved&, size_t first, size_t last);

} // namespace bench::native
