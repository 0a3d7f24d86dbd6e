// SPDX-License-Identifier: MIT
// A skin that is pressed frame by frame: by dermis::Skin, or in somebody's command buffer.
#pragma once

#include "host/plan/skin.hpp"
#include "host/plan/timeline.hpp"

namespace dermis::plan {

struct StreamedSkin {
    PreparedSkin skin;
    Wanted wanted{}; // the responses
    Precision precision = Precision::f32;
    Variant variant() const;
};
// Throws Error::bad_input.
StreamedSkin streamed_skin(const SkinDescription&, const SkinOptions&);

// Where responses stand among the floats that a stream gives.
struct ResponseLayout {
    struct Range {
        size_t first = 0, count = 0;
    };
    std::array<Range, REDUCED_MAPS> of; // by quantity; a field is a map of pitch*height, sites are in the order given
    std::vector<size_t> site;           // of each site
    size_t all = 0;
};
ResponseLayout response_layout_of(const StreamedSkin&);

// The coefficients of a press for each of the materials, in float; false where dt or one of them is beyond float.
// Nothing is allocated.
bool fill_table(const std::vector<Element>& materials, const ResponseRule&, double dt, f32::Coefficients* table);

// Of a press, with the coefficients of the first material.
f32::Constants frame_constants(const PreparedSkin&, const f32::Coefficients&);

} // namespace dermis::plan
