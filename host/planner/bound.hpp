// SPDX-License-Identifier: MIT
// Bounds of a model's error before it is run: greatest |X - X_exact| over cells and output times, divided by the
// greatest |X_exact|. X_exact solves the model on the scene's grid, maps and load without error in time or arithmetic.
#pragma once

#include "host/plan/timeline.hpp"

namespace dermis::planner {

using Errors = std::array<double, REDUCED_MAPS>; // errors of strain, SA1, SA2, FA1, FA2

// The bounds contain rounding, by a running analysis of one cell of each material under the load; its effect on the
// curvature, by the stencil's weights; and a baseline's truncation, as its distance from the exact method. largest:
// from measured_peaks. flushed: magnitudes below 2^-64 are stored as 0. points_only: only the schedule's points are
// read.
Errors predicted_errors(const plan::PreparedSkin&, const plan::Schedule&, Precision, bool flushed,
                        const Errors& largest, bool points_only);

// Lower bounds of the greatest |X_exact|: the exact solution in some cells, or only in some of the schedule's points.
Errors measured_peaks(const plan::PreparedSkin&, const plan::Schedule&, bool points_only);

// The greatest error among the quantities that the scene asks for.
double worst_asked(const plan::PreparedSkin&, const plan::Schedule&, const Errors&);

} // namespace dermis::planner
