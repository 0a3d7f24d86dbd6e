// SPDX-License-Identifier: MIT
// What a model can be off by, before it is run: largest |X - X_exact| over cells and output times, by the largest
// |X_exact|, where X_exact solves the model on the scene's grid, maps and load without error in time or arithmetic.
#pragma once

#include "host/plan/timeline.hpp"

namespace dermis::planner {

using Errors = std::array<double, REDUCED_MAPS>; // of strain, SA1, SA2, FA1, FA2

// Rounding by a running analysis of one cell of each material under the load; the curvature's share by the stencil's
// weights; a baseline's truncation as its distance from the exact method. `largest` are measured_peaks.
// flushed: magnitudes below 2^-64 are stored as 0. points_only: no cell but the schedule's points is read.
Errors predicted_errors(const plan::PreparedSkin&, const plan::Schedule&, Precision, bool flushed,
                        const Errors& largest, bool points_only);

// Lower bounds of the largest |X_exact|: the exact solution in some cells, or in some of the schedule's points alone.
Errors measured_peaks(const plan::PreparedSkin&, const plan::Schedule&, bool points_only);

// The worst of what the scene asks for.
double worst_asked(const plan::PreparedSkin&, const plan::Schedule&, const Errors&);

} // namespace dermis::planner
