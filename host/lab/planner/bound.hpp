// SPDX-License-Identifier: MIT
// A bound of a model's error before it is run: the largest |X - X_exact| over cells and output times, relative to the
// largest |X_exact|. X_exact solves the model on the scene's grid, maps and load without error in time or arithmetic.
#pragma once

#include "host/lab/schedule/timeline.hpp"

namespace dermis::planner {

// One number for each of strain, SA1, SA2, FA1, FA2, curvature and deformation; FA2 is taken before its gains.
using Errors = std::array<double, size_t(Quantity::deformation) + 1>;

// Raises a greatest value. A NaN, from a coefficient beyond the precision for example, counts as infinite.
inline void raise(double& greatest, double x) {
    if (!(x <= greatest)) greatest = std::isnan(x) ? INFINITY : x;
}

// How a run computes.
struct Arithmetic {
    bool single, compensated;
    bool separable; // one cell under unit pressure is stepped for all, and nothing is flushed
    bool spread;    // signals of all cells are spread to the depths of receptors; otherwise a cell is stepped there
    double stored;  // the least magnitude that is stored; a smaller one is flushed to 0
    double unit() const { return single ? 0x1p-24 : 0x1p-53; }
};
Arithmetic arithmetic_of(Precision, bool separable, bool spread = false);

// Lower bounds of the largest |X_exact|, from the exact solution in some cells.
struct Peaks {
    Errors all;   // over all cells: of traces and fields
    Errors sites; // over the sites of a class
};
Peaks measured_peaks(const model::PreparedSkin&, const model::Schedule&);

// Bounds of |X - X_exact|: rounding by a running analysis of one cell of each material under the load, the curvature's
// share by the stencil's weights, a baseline's truncation as its distance from the exact method. A run of
// model::in_parts is bounded against the skin that it stands for.
struct Bounds {
    Errors error;      // of |X - X_exact| where it is written
    Errors throughout; // of |X - X_exact| at every output time
    Errors greatest;   // of |X_exact| at every output time
};
Bounds bounds_of_cells(const model::PreparedSkin&, const model::Schedule&, const Arithmetic&);
// The same over the sites of each class alone.
Bounds bounds_of_sites(const model::PreparedSkin&, const model::Schedule&, const Arithmetic&);

// The worst relative error of what is asked for, the quantity that has it, and that quantity's peak.
struct Worst {
    double error = 0;
    Quantity of = Quantity::strain;
    double peak = 0;
};
// By bounds over all cells and over the sites of each class. An output that is nowhere above `stored` is exact.
Worst worst_asked(const model::PreparedSkin&, const model::Schedule&, const Bounds& cells, const Bounds& sites,
                  const Peaks&, double stored);

} // namespace dermis::planner
