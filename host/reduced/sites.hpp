// SPDX-License-Identifier: MIT
// The model `sites`: a march, in double, of no more cells than some places and their stencils need. A place has the
// bits that the CPU path in double gives its cell.
#pragma once

#include "host/plan/site_cells.hpp"
#include "host/plan/stepper.hpp"

#include <memory>

namespace dermis::reduced {

// Takes the steps of plan::timing(plan, cells.media, ..). threads: 0 = one per core.
std::unique_ptr<plan::Stepper> sites(const plan::Plan&, const plan::SiteCells& cells, int threads, plan::Stepper::Sink);

} // namespace dermis::reduced
