// SPDX-License-Identifier: MIT
// The model `sites`: a march in double of only the cells that some points and their stencils need. A point has the bits
// that the CPU path in double gives its cell.
#pragma once

#include "host/core/model/site_cells.hpp"
#include "host/lab/march/stepper.hpp"

namespace dermis::reduced {

// A class is the quantity that a point of SiteCells is asked for; every_quantity stands for all of them and the
// curvature, which follows them in a sample.
constexpr int every_quantity = -1;
// The classes of the schedule's points: every quantity for a probe, the site's own for a site.
std::vector<int> classes_of(const model::PreparedSkin&, const model::Schedule&);

// Takes the steps of a timeline of cells.materials; all references must outlive it. threads: 0 = one per core. gains:
// FA2 has its gains; the planner takes the greatest values before them.
std::unique_ptr<model::Stepper> sites(const model::PreparedSkin&, const model::Schedule&, const model::SiteCells& cells,
                                      const std::vector<int>& classes, int threads, model::Stepper::Sink,
                                      bool gains = true);

} // namespace dermis::reduced
