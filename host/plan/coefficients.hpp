// SPDX-License-Identifier: MIT
// The coefficients of one step: all transcendental work of the model, in double, once per material and step length.
#pragma once

#include "dermis/dermis.hpp"
#include "host/simd/model.hpp"

#include <optional>
#include <vector>

namespace dermis::plan {

// P1 = (1 - e^-z)/z, P2 = (e^-z - 1 + z)/z^2, P3 = (1 - z + z^2/2 - e^-z)/z^3, each 1/k! at z = 0; z >= 0, infinity
// too.
struct Phi {
    double p0, p1, p2, p3;
};
Phi phi(double z);

// A Kelvin-Voigt element: a spring beside a dashpot.
struct Element {
    double modulus, viscosity; // Pa, Pa s; >= 0, not both 0
};

// How SA2 and FA2 are formed from a strain, of any material.
struct ResponseRule {
    double sa2_adaptation; // s; infinity: the plain integral
    bool step_mean;        // FA2 is the mean over the step; otherwise its density at the step's end
};

// Exact for a pressure that jumps at the step's start and then runs linearly; dt >= 0 s.
f64::Coefficients exact_coefficients(const Element&, const ResponseRule&, double dt);
// A baseline, pressure held: the same kernel with another constant, R(z) in place of e^-z; dt > 0, viscosity > 0.
f64::Coefficients baseline_coefficients(Method, const Element&, const ResponseRule&, double dt);
// R, S = (1 - R)/z and T = (1 - S)/z at z = dt/tau.
struct Relaxation {
    double R, S, T;
};
Relaxation relaxation(Method, double z);
// Forward Euler with the published study's outputs: FA1 is the rate at the step's start, SA2 a running sum of the
// strain after the step, and FA2 a scalar of the load's jump (Constants::jump), made in the timeline.
f64::Coefficients published_coefficients(const Element&, double dt);

// Coefficients in the precision of a backend, K = f32 or f64.
template <class K> typename K::Coefficients rounded(const f64::Coefficients& k) {
    typename K::Coefficients r;
#define ROUND(name) r.name = static_cast<typename K::real>(k.name);
    COEFFICIENTS(ROUND)
#undef ROUND
    return r;
}

// The coefficients of a step of frames for one material, in float; none where dt or one of them is beyond float.
std::optional<f32::Coefficients> coefficients_in_float(const Element&, const ResponseRule&, double dt);

} // namespace dermis::plan
