// SPDX-License-Identifier: MIT
// The coefficients of the exact method in K, f64 or another precision: for files that instantiate them.
#pragma once

#include "host/core/model/coefficients.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace dermis::model {

// P3 for z <= 1. Each is defined in the file that instantiates its coefficients.
double p3_of(double z);
long double p3_of(long double z);

template <class T> Phi<T> phi(T z) {
    Phi<T> p;
    if (z <= 1) {
        p.p3 = p3_of(z);
        p.p2 = T(0.5) - z * p.p3;
        p.p1 = 1 - z * p.p2;
        p.p0 = 1 - z * p.p1;
        return p;
    }
    p.p0 = std::exp(-z);
    p.p1 = (1 - p.p0) / z;
    p.p2 = (1 - p.p1) / z;
    p.p3 = (T(0.5) - p.p2) / z;
    return p;
}

// Divided differences of e^x over {-z, -y}, {0, -z, -y}, {0, 0, -z, -y} and {0, 0, 0, -z, -y}, for an adapting integral
// of a relaxing strain. At y = 0 they are P1 to P4 of z.
template <class T> struct Divided { T d1, d2, d3, d4; };

template <class T> Divided<T> divided(T z, T y) {
    const T small = std::min(z, y), large = std::max(z, y);
    const Phi<T> p = phi(small);
    Divided<T> d;
    d.d1 = p.p0 == 0 ? 0 : p.p0 * phi(large - small).p1;
    if (large > 1) {
        d.d2 = (p.p1 - d.d1) / large;
        d.d3 = (p.p2 - d.d2) / large;
        d.d4 = (p.p3 - d.d3) / large;
        return d;
    }
    // d3 = sum over k of (-1)^k h_k/(k + 3)!, h_k the sum of all products of k factors small or large; d4 with (k + 4)!
    constexpr int terms = std::is_same_v<T, double> ? 18 : 32;
    T h = 1, power = 1, factorial = 6, sign = 1;
    d.d3 = d.d4 = 0;
    for (int k = 0; k < terms; ++k) {
        d.d3 += sign * h / factorial;
        d.d4 += sign * h / (factorial * (k + 4));
        power *= small;
        h = large * h + power;
        factorial *= k + 4;
        sign = -sign;
    }
    d.d2 = p.p2 - large * d.d3;
    return d;
}

template <class K>
typename K::Coefficients exact_coefficients_in(const Element& m, const ResponseRule& rule, typename K::real dt) {
    using T = typename K::real;
    typename K::Coefficients k{};
    const T E = m.modulus, eta = m.viscosity;
    k.E = E;
    if (dt == 0) {
        k.v0 = eta > 0 ? 1 / eta : 0;
        k.a0 = rule.step_mean ? 0 : -E * k.v0 * k.v0;
        return k;
    }
    const T z = is_elastic(m) ? T(INFINITY) : E * dt / eta, y = dt / rule.sa2_adaptation;
    const Phi<T> p = phi(z);
    const Divided<T> d = divided(z, y);
    // b and f are dt/eta times a function of z; above 1 the recurrence divides by E instead, so that viscosity 0 is a
    // limit and no case of its own.
    const T q = z <= 1 ? dt / eta : 0;
    k.b = z <= 1 ? q * p.p1 : (1 - p.p0) / E;
    k.f = z <= 1 ? q * p.p2 : (1 - p.p1) / E;
    k.i0 = dt * d.d1;
    if (std::max(z, y) > 1 && z >= y) { // the recurrence of divided(), divided by E instead of z
        k.i1 = dt * ((phi(y).p1 - d.d1) / E);
        k.i2 = dt * ((phi(y).p2 - d.d2) / E);
    } else {
        k.i1 = dt * (dt / eta * d.d2);
        k.i2 = dt * (dt / eta * d.d3);
    }
    k.leak = y * phi(y).p1;
    k.v0 = p.p0 > 0 ? p.p0 / eta : 0;
    k.v1 = k.b / dt;
    if (!rule.step_mean) {
        k.a0 = k.v0 > 0 ? -E * k.v0 / eta : 0;
        k.a1 = k.v0 / dt;
    } else if (eta > 0) {
        k.a0 = z <= 1 ? -E * k.v1 / eta : -(1 - p.p0) / (eta * dt); // at e^-z = 0 the jump's own term, exactly
        k.a1 = k.v1 / dt;
        k.a2 = 1 / (eta * dt);
    }
    return k;
}
template <class K> void join_loads(typename K::Coefficients* elements, size_t n, bool spring, typename K::real dt) {
    using Coefficients = typename K::Coefficients;
    Coefficients &first = elements[0], &last = elements[n - 1];
    const auto rate = last.v1;
    for (size_t e = 1; e < n; ++e)
        for (auto factor :
             {&Coefficients::i1, &Coefficients::i2, &Coefficients::v1, &Coefficients::a1, &Coefficients::a2}) {
            first.*factor += elements[e].*factor;
            elements[e].*factor = 0;
        }
    if (!spring) return;
    first.v0 += last.v0; // for the impulse of a pressure on a skin at rest: each excess stress is the pressure
    last.v0 = dt == 0;
    last.v1 = rate;
    last.a1 = dt == 0 ? 0 : 1 / dt;
    if (dt == 0 && last.E > 0) last.b = 1 / last.E; // E = 0: all coefficients are 0, at rest
}

template <class C, class T> C bend(C& k, const Element& m, const ResponseRule& rule, T dt, T before) {
    C past{};
    if (dt == 0 || before == 0) return past;
    const T E = m.modulus, eta = m.viscosity;
    const T z = is_elastic(m) ? T(INFINITY) : E * dt / eta, y = dt / rule.sa2_adaptation;
    const Phi<T> p = phi(z), of_y = phi(y);
    const Divided<T> d = divided(z, y);
    // What a pressure of u*u - u adds, u from 0 to 1. As in exact_coefficients_in, what grows with z is divided by E.
    const T strain = z <= 1 ? dt / eta * (2 * p.p3 - p.p2) : (p.p1 - 2 * p.p2) / E,
            integral = dt * (std::max(z, y) > 1 && z >= y ? (2 * (of_y.p3 - d.d3) - (of_y.p2 - d.d2)) / E
                                                          : dt / eta * (2 * d.d4 - d.d3)),
            rate = z <= 1 ? z * (p.p2 - 2 * p.p3) / eta : (1 - 2 * p.p1 + p.p0) / (E * dt),
            at_end = eta > 0 ? (2 * p.p1 - p.p0) / (eta * dt) : 0, mean = eta > 0 ? rate / dt : 0;
    // The pressure bends by c times that; c = share*ds - past_share*(what changed over the step before).
    const T share = dt / (dt + before), past_share = share * dt / before;
    const auto add = [&](T C::*factor, T bow) {
        k.*factor += share * bow;
        past.*factor = -past_share * bow;
    };
    add(&C::f, strain);
    add(&C::i2, integral);
    add(&C::v1, rate);
    add(&C::a1, rule.step_mean ? mean : at_end);
    return past;
}

} // namespace dermis::model
