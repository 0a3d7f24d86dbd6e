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

// The same in two passes over whole maps, as one would write it first. rate, acceleration: maps.
void advance_rows(const Frame&, size_t first, size_t last, float* rate, float* acceleration);
void answer_rows(const Frame&, size_t first, size_t last, const float* rate, const float* acceleration);

// The memory of a streamed frame: the four responses are written from registers, past the caches or through them.
struct Moved {
    const float *from, *to, *rest;
    float *strain, *integral;
    float* responses[4];
    bool past_caches;
};

// Reads and writes the cells first .. last - 1, multiples of `lanes`, as a step does, and computes next to nothing.
void move_cells(const Moved&, size_t first, size_t last);

// A part of the grid with a halo of `lanes` columns and one row on each side: strain, pressure and material have
// height + 2 rows of `pitch` cells, and their first cell inside stands at pitch + lanes. The others have no halo.
struct Tile {
    size_t width, height, pitch;
    float *strain, *pressure;
    int* material; // index of a step
    float *integral, *rest;
    float *rate, *acceleration; // one row
};

// Strain, SA1, SA2, FA1, FA2 over cells.
struct Statistics {
    double sum[5];
    float least[5], greatest[5];
};

// The pressure map is multiplied by start, and by start + rise at the end of the step.
struct Envelope {
    float start, rise;
};

constexpr size_t most_materials = lanes;
// Takes all steps of a tile while it stays in the cache, and adds each one's statistics. materials: 1 ..
// most_materials.
void march_tile(const Tile&, const ExactStep<float>* of_material, size_t materials, const Envelope*, size_t steps,
                Statistics*);

} // namespace bench::native
