// SPDX-License-Identifier: MIT
// The errors of a step's coefficients before they are rounded to the run's precision.
#pragma once

#include "host/lab/schedule/extended.hpp"
#include "host/lab/schedule/forcing.hpp"

namespace dermis::planner {

// What an element's coefficients are made by.
struct MadeBy {
    const model::ResponseRule& rule;
    const model::Forcing<double>* forcing; // null: none
    double step;                           // s: of a whole step
    double length;                         // s: of this one
    double amplitude;                      // of a sine within the step; 0: there is none
    double unit;                           // unit roundoff
};

// Bounds of what coefficients are off by beside a few units of each: where they come from more roundings, or are a
// small difference of large terms.
f64::Coefficients coefficient_errors(const f64::Coefficients&, const model::Element&, const MadeBy&);

} // namespace dermis::planner
