// SPDX-License-Identifier: MIT
// The model `sites`: a march in double of only those cells that given points and their stencils need. A point has the
// bits that the CPU path in double gives its cell.
#pragma once

#include "host/plan/site_cells.hpp"
#include "host/plan/stepper.hpp"

namespace dermis::reduced {

// Takes the steps of a timeline of cells.materials; all references outlive it. threads: 0 = one per core.
// own_class: the last points are the skin's sites, and each has only the response of its own class; otherwise every
// quantity of every point is computed.
std::unique_ptr<plan::Stepper> sites(const plan::PreparedSkin&, const plan::Schedule&, const plan::SiteCells& cells,
                                     bool own_class, int threads, plan::Stepper::Sink);

} // namespace dermis::reduced
