// SPDX-License-Identifier: MIT
// A step of one cell by kernels/cell.h in counted arithmetic.
#pragma once

#include "host/lab/planner/counted.hpp"
#include "host/lab/schedule/cell.hpp"

namespace dermis::planner {

// A sum of a cell's state under unit pressure, with its error as Counted has it.
struct CountedSum {
    double value = 0, off = 0, shift = 0;
    double excess = 0; // of a strain between frames: greatest |pressure less the spring's stress|
};

// A cell at the end of a step.
struct CountedCell {
    std::array<CountedSum, scene::most_in_series + 2> sums; // of elements, the integral, the rate of a spring
    counted::CellStep step;
    double strains = 0;   // magnitudes of the strains of elements, added up
    bool flushed = false; // the errors contain a value that was too small to be stored

    const Counted& signal(int q) const {
        const counted::Motion& m = step.motion;
        const Counted* const of[] = {&m.strain, &m.strain, &step.integral, &m.rate, &m.acceleration};
        return *of[q];
    }
};

// A step's coefficients, as they stand in a table, and its load.
struct CountedStep {
    model::StateShape shape;
    std::array<counted::LaneCoefficients, 2 * scene::most_in_series> k;
    std::array<f64::LaneCoefficients, 2 * scene::most_in_series> rounded_in_double;
    counted::Load load;

    const f64::LaneCoefficients* in_double(size_t e) const { return &rounded_in_double[(1 + shape.previous) * e]; }
};

} // namespace dermis::planner
