// SPDX-License-Identifier: MIT
// The errors of a step's coefficients before they are rounded to the run's precision.
#pragma once

#include "host/lab/schedule/extended.hpp"
#include "host/lab/schedule/forcing.hpp"

#include <cmath>

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

// The factors of ds under a sine (schedule/forcing.cpp) are differences of terms that are each rounded.
inline f64::Coefficients under_sine(const f64::Coefficients& k, const model::Element& m, const MadeBy& by) {
    const double w = by.forcing->sine->w, eps = 12 * by.unit * by.amplitude / std::hypot(m.modulus, w * m.viscosity);
    f64::Coefficients off{};
    off.f = eps;
    off.i2 = eps * (1 / std::hypot(1 / by.rule.sa2_adaptation, w) + k.i0);
    off.v1 = eps * (w + m.modulus * k.v0);
    off.a1 = by.rule.step_mean ? off.v1 * k.a2 * m.viscosity // a2 is 1/(eta*dt)
                               : eps * (w * w + m.modulus * std::abs(k.a0));
    return off;
}

// The same under the waves of a window, one in each segment of a step (gains_of_growth). The terms are bounded by what
// they are in a step without length. The strain's error in one segment passes into the rates of the next.
inline f64::Coefficients under_window(const model::Element& m, const MadeBy& by) {
    f64::Coefficients off{};
    const double relaxes = is_elastic(m) ? 0 : z_of(m, 1), dt = by.length; // 1/s, s
    for (const model::Segment<double>& s : by.forcing->segments) {
        if (!s.wave) continue;
        const double w = s.wave->w, T = s.length, compliance = 1 / std::hypot(m.modulus, w * m.viscosity),
                     lag = m.viscosity * compliance, leaky = 1 / std::hypot(1 / by.rule.sa2_adaptation, w), // s
            eps = 12 * by.unit * by.amplitude * compliance, held = eps * std::abs(s.wave->weight),
                     grown = eps * std::abs(s.wave->slope);
        off.f += 2 * held + grown * (2 * lag + T);
        off.i2 += held * (2 * leaky + dt) + grown * leaky * (2 * (lag + leaky) + T) + grown * lag * dt;
        off.v1 += held * (w + relaxes) + grown * (lag * (w + relaxes) + 1 + w * T);
        off.a1 += held * (w * w + relaxes * relaxes) + grown * (lag * (w * w + relaxes * relaxes) + 2 * w + w * w * T);
    }
    off.i2 += off.f * dt;
    off.a1 += off.v1 * relaxes + off.f * relaxes * relaxes;
    off.v1 += off.f * relaxes;
    if (by.rule.step_mean) off.a1 = off.v1 / dt;
    return off;
}

// Bounds of what coefficients are off by beside a few units of each: where they come from more roundings, or are a
// small difference of large terms.
inline f64::Coefficients coefficient_errors(const f64::Coefficients& k, const model::Element& m, const MadeBy& by) {
    f64::Coefficients off{};
    using C = f64::Coefficients;
    if (by.amplitude > 0 && by.forcing) off = by.forcing->sine ? under_sine(k, m, by) : under_window(m, by);
    for (double C::*of_change : {&C::f, &C::v1, &C::a1, &C::i2}) off.*of_change += 4 * by.unit * std::abs(k.*of_change);
    off.i2 += 6 * by.unit * std::abs(k.i2);
    off.a0 += 3 * by.unit * std::abs(k.a0);
    if (!is_elastic(m)) { // the rounding of z adds up to z units to e^-z, which the a0 of a step mean does not contain
        const double of_z = 2 * z_of(m, by.step) * by.unit;
        off.v0 += of_z * std::abs(k.v0);
        if (!by.rule.step_mean) off.a0 += of_z * std::abs(k.a0);
        return off;
    }
    // Its modulus is rounded, because it may stand for several springs in series, and its mean acceleration is the
    // small difference of two rates.
    for (double C::*factor : {&C::b, &C::f, &C::i1, &C::i2, &C::v1, &C::a1, &C::a2})
        off.*factor += unit_of_double * std::abs(k.*factor);
    if (by.forcing && by.forcing->slope)
        off.a1 +=
            12 * by.unit * (std::abs(k.v1) + final_strain(m, std::abs(*by.forcing->slope))) / by.forcing->slope_length;
    return off;
}

} // namespace dermis::planner
