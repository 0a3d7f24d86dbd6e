// SPDX-License-Identifier: MIT
// The native peer of pads: the same work as a Skin's, checked and copied, with the same bits, for one kind of pad. Its
// loops are compiled for this processor, so that this header has plain data and declarations alone.
#pragma once

#include <stddef.h>

namespace bench::native {

// One step of a Kelvin-Voigt element between two pressures, as kernels/step.h has it without compensation, and the
// curvature gain of its responses.
struct PadStep {
    float E, b, f, i0, i1, i2, leak, v0, v1, a0, a1, a2, start, rise, jump, bend, length;
};

// Pads of width*height cells with mirrored edges, each one row of cells at a pitch that is a multiple of 16.
struct PadBatch {
    PadStep step;
    size_t cells, width, pitch;
    const float* rest;    // of one pad; `pitch` cells
    const int* inside[4]; // for each cell, all ones where its neighbour on the left, right, above and below is inside
    float *strain, *integral;
    float *from, *to;    // pressures
    float* responses[4]; // SA1, SA2, FA1, FA2; `cells` from pad to pad
};

// Copies the pressures of pads first .. last - 1 to batch.to. Returns whether all are finite.
bool take_pads(const PadBatch&, size_t first, size_t last, const float* pressure);
// Steps the pads and writes their responses. scratch: 2*pitch numbers of the calling thread.
void press_pads(const PadBatch&, size_t first, size_t last, float* scratch);

} // namespace bench::native
