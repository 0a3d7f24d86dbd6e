// SPDX-License-Identifier: MIT
// The coefficients of one step. All transcendental work of the model is here, in double, once per material and step
// length.
#pragma once

#include "host/core/description/element.hpp"
#include "host/core/simd/model.hpp"

namespace dermis::model {

// p0 = e^-z, p1 = (1 - e^-z)/z, p2 = (e^-z - 1 + z)/z^2, p3 = (1 - z + z^2/2 - e^-z)/z^3; at z = 0 they are 1/k!.
// z >= 0, infinity included. T is double or long double.
template <class T> struct Phi { T p0, p1, p2, p3; };
template <class T> Phi<T> phi(T z);

using scene::Element;

// The rule by which SA2 and FA2 follow from a strain, the same for every material.
struct ResponseRule {
    double sa2_adaptation; // s; infinity: plain integral
    bool step_mean;        // FA2 is the mean over the step; otherwise its density at the step's end
};

// The exact method, for a pressure that jumps at the step's start and then runs linearly; dt >= 0 s.
f64::Coefficients exact_coefficients(const Element&, const ResponseRule&, double dt);
// The same in K, f64 or another precision (coefficients_in.hpp).
template <class K>
typename K::Coefficients exact_coefficients_in(const Element&, const ResponseRule&, typename K::real dt);

// Bends the pressure of a step: it runs along the parabola through the frames at the step's end, at its start and
// `before` seconds earlier; linearly where that is 0. Adds to k, the coefficients of an element, the share of ds, and
// returns the element's second coefficients (kernels/layout.h).
template <class C, class T> C bend(C& k, const Element&, const ResponseRule&, T dt, T before);

// Moves what the load adds to integral, rate and acceleration of n elements in series into the first element's
// coefficients. spring: the last element is a spring; it gets the coefficients of a spring (kernels/layout.h), for a
// step of dt seconds.
template <class K> void join_loads(typename K::Coefficients* elements, size_t n, bool spring, typename K::real dt);

// Rounds coefficients to the precision of a backend, K = f32 or f64.
template <class K> typename K::Coefficients rounded(const f64::Coefficients& k) {
    typename K::Coefficients r;
#define ROUND(name) r.name = static_cast<typename K::real>(k.name);
    COEFFICIENTS(ROUND)
#undef ROUND
    return r;
}

} // namespace dermis::model
