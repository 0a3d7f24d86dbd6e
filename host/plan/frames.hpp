// SPDX-License-Identifier: MIT
// A skin that is pressed frame by frame: by dermis::Skin, or in somebody's command buffer.
#pragma once

#include "host/plan/plan.hpp"

namespace dermis::plan {

// Every cell is pressed, from frame to frame, in f32. Throws Error::bad_input.
Plan skin_plan(const SkinDescription&, const SkinOptions&);

// Where answers stand among the floats of a response.
struct ResponseLayout {
    struct Range {
        size_t first = 0, count = 0;
    };
    std::array<Range, REDUCED_MAPS> of; // by quantity; a field is a map of pitch*height, sites are in the order given
    std::vector<size_t> site;           // of each site
    size_t all = 0;
};
ResponseLayout response_layout_of(const Plan&);

// Whether the coefficients of such a press are numbers in float: dt is not too small or too large for a medium.
bool in_float(const std::vector<Medium>&, double dt);

// Of a press over dt seconds. Nothing is allocated.
template <class Constants> Constants frame_constants(const Plan& plan, const Medium& medium, double dt) {
    Constants c = constants_of<Constants>(plan, {});
    c.row = rounded<decltype(c.row)>(exact_coefficients(medium, dt));
    c.rise = 1;
    c.respond = 1;
    return c;
}

// A small skin of odd size, its maps noise from below the flush to about 1: what a device is tested on.
SkinDescription sample_skin(Stencil, Edges, bool materials);
Map sample_pressure();

} // namespace dermis::plan
