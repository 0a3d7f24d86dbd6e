// SPDX-License-Identifier: MIT
// What the state of a cell holds, on every backend.
#pragma once

#include "host/core/simd/model.hpp"

#include <cstddef>

namespace dermis::model {

struct StateShape {
    size_t elements = 1;      // elements in series, whose strains the state holds
    bool spring = false;      // a spring in series with them, whose strain follows from the pressure
    bool compensated = false; // with each strain and the integral the rounding error of that sum
    bool strain = false;      // the strain of the cell: the sum over its elements and spring
    bool integral = false;    // the integral of the cell's strain, for SA2
    bool rate = false;        // the rate of the spring's strain, for FA2 between frames
    bool previous = false;    // the pressure of the frame before the one that the next step starts from

    // The numbers of a cell.
    int planes() const {
        return STATE_PLANES(int(elements), int(compensated), int(strain), int(integral), int(rate), int(previous));
    }
};

} // namespace dermis::model
