// SPDX-License-Identifier: MIT
// What a model can be off by, before it is run: largest |X - X_exact| over cells and output times, by the largest
// |X_exact|, where X_exact solves the model on the scene's grid, maps and load without error in time or arithmetic.
#pragma once

#include "host/plan/plan.hpp"

namespace dermis::planner {

using Errors = std::array<double, REDUCED_MAPS>; // of strain, SA1, SA2, FA1, FA2

// Rounding by a running analysis of one cell of each material under the load; the curvature's share by the stencil's
// weights; a baseline's truncation as its distance from the exact method. `largest` are measured_peaks.
Errors predicted_errors(const plan::Plan&, Precision, bool flushed, const Errors& largest);

// Lower bounds of the largest |X_exact|: the exact solution in some cells.
Errors measured_peaks(const plan::Plan&);

// The worst of what the scene asks for.
double worst_asked(const plan::Plan&, const Errors&);

} // namespace dermis::planner
