// SPDX-License-Identifier: MIT
// The coefficients of one step by the baseline methods, and by the published study's method.
#pragma once

#include "dermis/scene.hpp"
#include "host/core/model/coefficients.hpp"

#include <numbers>

namespace dermis::model {

// The stability function R of a method, S = (1 - R)/z and T = (1 - S)/z, at z = dt/tau.
struct StabilityFunction {
    double R, S, T;
};
inline StabilityFunction stability_function(Method method, double z) {
    StabilityFunction r{};
    const double g = 1 - 1 / std::numbers::sqrt2; // SDIRK2's diagonal
    switch (method) {
    case Method::rk2: r.T = 0.5; break;
    case Method::rk4: r.T = 0.5 - z / 6 * (1 - z / 4); break;
    case Method::backward_euler: r.T = 1 / (1 + z); break;
    case Method::crank_nicolson: r.T = 1 / (2 + z); break;
    case Method::sdirk2: r.T = (0.5 + g * g * z) / ((1 + g * z) * (1 + g * z)); break;
    default: break; // forward Euler: 0
    }
    r.S = 1 - z * r.T;
    r.R = 1 - z * r.S;
    // These forms do not cancel at large z.
    if (method == Method::backward_euler) r.S = r.R = 1 / (1 + z);
    if (method == Method::crank_nicolson) r.S = 2 / (2 + z), r.R = (2 - z) / (2 + z);
    if (method == Method::sdirk2) {
        const double d = (1 + g * z) * (1 + g * z);
        r.S = (1 + g * g * z) / d;
        r.R = (1 - (1 - 2 * g) * z) / d;
    }
    return r;
}

// A baseline method, for a pressure held over the step: R(z) in place of e^-z; dt > 0, viscosity > 0.
inline f64::Coefficients baseline_coefficients(Method method, const Element& m, const ResponseRule& rule, double dt) {
    f64::Coefficients k{};
    const double q = dt / m.viscosity;
    const StabilityFunction r = stability_function(method, m.modulus * q);
    k.E = m.modulus;
    k.b = q * r.S;
    k.i0 = dt * r.S; // the same method for I' = eps
    k.i1 = dt * q * r.T;
    k.leak = dt / rule.sa2_adaptation; // by forward Euler; other methods refuse an adaptation
    k.v0 = r.R / m.viscosity;
    k.a0 = -m.modulus / m.viscosity * (rule.step_mean ? r.S / m.viscosity : k.v0);
    k.a2 = rule.step_mean ? 1 / (m.viscosity * dt) : 0;
    return k;
}

// Forward Euler with the published study's outputs: FA1 is the rate at the step's start, SA2 a running sum of the
// strain after the step, and FA2 a multiple of Constants::jump, which the timeline computes.
inline f64::Coefficients published_coefficients(const Element& m, double dt) {
    f64::Coefficients k{};
    k.E = m.modulus;
    k.b = dt / m.viscosity;
    k.i0 = dt * (1 - m.modulus * k.b);
    k.i1 = dt * k.b;
    k.v0 = 1 / m.viscosity;
    k.a2 = 1;
    return k;
}

} // namespace dermis::model
