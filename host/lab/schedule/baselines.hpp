// SPDX-License-Identifier: MIT
// The coefficients of one step by the baseline methods, and by the published study's method.
#pragma once

#include "dermis/scene.hpp"
#include "host/core/model/coefficients.hpp"

namespace dermis::model {

// A baseline method, for a pressure held over the step: R(z) in place of e^-z; dt > 0, viscosity > 0.
f64::Coefficients baseline_coefficients(Method, const Element&, const ResponseRule&, double dt);
// The stability function R of a method, S = (1 - R)/z and T = (1 - S)/z, at z = dt/tau.
struct StabilityFunction {
    double R, S, T;
};
StabilityFunction stability_function(Method, double z);
// Forward Euler with the published study's outputs: FA1 is the rate at the step's start, SA2 a running sum of the
// strain after the step, and FA2 a multiple of Constants::jump, which the timeline computes.
f64::Coefficients published_coefficients(const Element&, double dt);

} // namespace dermis::model
