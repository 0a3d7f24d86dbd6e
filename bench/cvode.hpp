// SPDX-License-Identifier: MIT
// The peer of stiff chains: CVODE of SUNDIALS, which chooses its own steps and orders by an estimate of its error.
#pragma once

#include "dermis/dermis.hpp"

#include <optional>
#include <string>
#include <vector>

namespace bench {

// The cells of a skin at rest that bears a pressure from time 0 on. All elements of all cells are one system of
// ordinary differential equations.
struct CreepProblem {
    std::vector<dermis::KelvinVoigt> chain;
    std::vector<double> pressure; // Pa, of each cell
    double frequency = 0;         // Hz: the pressure is multiplied by 1 + sin(2*pi*frequency*t)
    double interval = 0;          // s, between outputs
    int outputs = 0;              // without the one at time 0
};

struct CvodeRun {
    long long steps = 0;           // its own
    double seconds = 0;            // of stepping and outputs, without what is made before
    std::vector<double> responses; // [output, that at 0 included][strain and rate of each cell]
};

// Runs the problem by backward differentiation formulas of order 1 to 5 with a relative tolerance. Empty where the
// program was built without SUNDIALS.
std::optional<CvodeRun> cvode(const CreepProblem&, double tolerance);
std::string cvode_version();

} // namespace bench
