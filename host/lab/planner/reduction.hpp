// SPDX-License-Identifier: MIT
// Fewer elements in series for a uniform chain, where a scene cannot tell the difference: an element much faster than
// the step becomes a spring, one much slower than the scene a dashpot, and two of nearly one retardation time become
// one. Each such replacement is proved: its error in each output that is asked for is bounded at every output time.
#pragma once

#include "host/lab/planner/replacement.hpp"

#include <functional>

namespace dermis::planner {

// The limits of a reduction.
struct Allowance {
    double error;   // greatest Replacement::error
    double seconds; // of the run with all elements: the search takes no more than it may save
    bool impulses;  // impulses of the load's jumps are written: they keep the error too
};

// Finds the shortest chain, where may_reduce() says so; the skin's own if none is shorter. peaks: measured_peaks(),
// asked for where a search is worth while.
Replacement reduced(const plan::PreparedSkin&, const plan::Schedule&, const Allowance&,
                    const std::function<const Peaks&()>& peaks);

// Whether a chain may be reduced: the model keeps a state of each cell and element, and the method is exact in time.
bool may_reduce(const plan::PreparedSkin&, const plan::Schedule&, Model);

} // namespace dermis::planner
