// SPDX-License-Identifier: MIT
// A step of one cell by kernels/cell.h in counted arithmetic.
#pragma once

#include "host/lab/planner/counted.hpp"
#include "host/lab/schedule/cell.hpp"

namespace dermis::planner {

// A sum of a cell's state under unit pressure, with its error as Counted has it.
struct CountedSum {
    double value = 0, off = 0, shift = 0;
};

// A cell at the end of a step. Its sums are those of a plan::SingleCell.
struct CountedCell {
    counted::CellStep step;
    double strains = 0;   // magnitudes of the strains in series, added up
    bool flushed = false; // the errors contain a value that was too small to be stored

    Counted signal(int q) const { return counted::signal(q, step.motion, step.integral); }
};

// A step's coefficients, as they stand in a table, and its load.
struct CountedStep {
    static constexpr size_t most = 2 * scene::most_in_series;
    plan::StateShape shape;
    std::array<counted::LaneCoefficients, most> k;
    std::array<f64::LaneCoefficients, most> in_double;
    counted::Load load;
    double end = 0; // between frames: the greatest pressure at the step's end
};

// sums: of the cell's state, before the step and after it.
CountedCell pressed(const CountedStep&, const Rounding&, const CountedCell& before, const CountedSum* sums,
                    CountedSum* after);

} // namespace dermis::planner
