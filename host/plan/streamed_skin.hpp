// SPDX-License-Identifier: MIT
// A skin that is pressed frame by frame, by dermis::Skin or in a host's command buffer.
#pragma once

#include "host/plan/skin.hpp"
#include "host/plan/timeline.hpp"

namespace dermis::plan {

struct StreamedSkin {
    PreparedSkin skin;
    Wanted wanted{}; // the responses to compute
    Precision precision = Precision::f32;
    Variant variant() const;
};
// Throws Error::bad_input. threads: as for Device::cpu.
StreamedSkin streamed_skin(const SkinDescription&, const SkinOptions&, int threads = 0);

// The positions of responses among the floats of a stream.
struct ResponseLayout {
    struct Range {
        size_t first = 0, count = 0;
    };
    std::array<Range, REDUCED_MAPS> of; // by quantity: a field of pitch*height, or its sites in the order given
    std::vector<size_t> site;           // index of each site's float
    size_t all = 0;                     // number of floats
};
ResponseLayout response_layout_of(const StreamedSkin&);

// The floats of a saved state, the same on every backend: planes of one number for each cell, in the order of a state
// in kernels/layout.h without the cell's strain (for sites of the cells that they read, in ascending order); then the
// pressure that the next press starts from, width*height.
struct StateLayout {
    size_t cells = 0, planes = 0, pressure = 0;
    size_t floats() const { return cells * planes + pressure; }
};
StateLayout state_layout_of(const StreamedSkin&);

// A pressure, whose rows begin `stride` numbers apart, and a map of `pitch` for it.
struct PressureCopy {
    const float* from;
    size_t stride, width;
    float* to;
    size_t pitch;
};
// Copies rows first .. last - 1. Returns whether all numbers are finite.
bool copy_rows(const PressureCopy&, int first, int last);

// Writes the coefficients of a press for each of the materials, in float. Returns false if dt or one of them is beyond
// float. Allocates nothing.
bool fill_table(const std::vector<Element>& materials, const Chain&, const ResponseRule&, double dt,
                f32::Coefficients* table);

// The constants of a press, with these coefficients.
f32::Constants frame_constants(const PreparedSkin&, const f32::Coefficients&);

} // namespace dermis::plan
