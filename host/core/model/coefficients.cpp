// SPDX-License-Identifier: MIT
#include "host/core/model/coefficients.hpp"

#include "host/core/base/refusal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace dermis::plan {
namespace {

// P3 on [0, 1] as a polynomial of degree 12, with an error of 6e-5 units of 2^-53.
constexpr double p3_series[] = {0.16666666666666666,     -0.041666666666666664,  0.008333333333333314,
                                -0.0013888888888884815,  0.0001984126984080311,  -2.480158726973578e-05,
                                2.7557317827207793e-06,  -2.755727811568642e-07, 2.505127832212774e-08,
                                -2.0865204732880175e-09, 1.594972230606643e-10,  -1.0793584416656275e-11,
                                5.114980229101037e-13};

// Divided differences of e^x over {-z, -y}, {0, -z, -y} and {0, 0, -z, -y}, for an adapting integral of a relaxing
// strain. At y = 0 they are P1, P2, P3 of z.
template <class T> struct Divided { T d1, d2, d3; };

template <class T> Divided<T> divided(T z, T y) {
    const T small = std::min(z, y), large = std::max(z, y);
    const Phi<T> p = phi(small);
    Divided<T> d;
    d.d1 = p.p0 == 0 ? 0 : p.p0 * phi(large - small).p1;
    if (large > 1) {
        d.d2 = (p.p1 - d.d1) / large;
        d.d3 = (p.p2 - d.d2) / large;
        return d;
    }
    // d3 = sum over k of (-1)^k h_k/(k + 3)!, h_k the sum of all products of k factors small or large
    constexpr int terms = std::is_same_v<T, double> ? 18 : 32;
    T h = 1, power = 1, factorial = 6, sign = 1;
    d.d3 = 0;
    for (int k = 0; k < terms; ++k) {
        d.d3 += sign * h / factorial;
        power *= small;
        h = large * h + power;
        factorial *= k + 4;
        sign = -sign;
    }
    d.d2 = p.p2 - large * d.d3;
    return d;
}

// P3 up to z = 1.
double p3_of(double z) {
    double p3 = 0;
    for (int i = 12; i >= 0; --i) p3 = p3 * z + p3_series[i];
    return p3;
}
long double p3_of(long double z) { // its power series, to 2^-113
    long double sum = 1;
    for (int k = 28; k > 3; --k) sum = 1 - z / k * sum;
    return sum / 6;
}

} // namespace

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
template Phi<double> phi(double);
template Phi<long double> phi(long double);

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
f64::Coefficients exact_coefficients(const Element& m, const ResponseRule& rule, double dt) {
    return exact_coefficients_in<f64>(m, rule, dt);
}
template f64::Coefficients exact_coefficients_in<f64>(const Element&, const ResponseRule&, double);
template extended::Coefficients exact_coefficients_in<extended>(const Element&, const ResponseRule&, long double);

Relaxation relaxation(Method method, double z) {
    Relaxation r{};
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

f64::Coefficients baseline_coefficients(Method method, const Element& m, const ResponseRule& rule, double dt) {
    f64::Coefficients k{};
    const double q = dt / m.viscosity;
    const Relaxation r = relaxation(method, m.modulus * q);
    k.E = m.modulus;
    k.b = q * r.S;
    k.i0 = dt * r.S; // the same method for I' = eps
    k.i1 = dt * q * r.T;
    k.leak = dt / rule.sa2_adaptation; // that of forward Euler; the other methods are refused
    k.v0 = r.R / m.viscosity;
    k.a0 = -m.modulus / m.viscosity * (rule.step_mean ? r.S / m.viscosity : k.v0);
    k.a2 = rule.step_mean ? 1 / (m.viscosity * dt) : 0;
    return k;
}

f64::Coefficients published_coefficients(const Element& m, double dt) {
    f64::Coefficients k{};
    k.E = m.modulus;
    k.b = dt / m.viscosity;
    k.i0 = dt * (1 - m.modulus * k.b);
    k.i1 = dt * k.b;
    k.v0 = 1 / m.viscosity;
    k.a2 = 1;
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
    first.v0 += last.v0; // of the impulse of a pressure that meets a skin at rest: every excess stress is the pressure
    last.v0 = dt == 0;
    last.v1 = rate;
    last.a1 = dt == 0 ? 0 : 1 / dt;
    if (dt == 0 && last.E > 0) last.b = 1 / last.E; // all are 0 at rest
}

template void join_loads<f64>(f64::Coefficients*, size_t, bool, double);
template void join_loads<extended>(extended::Coefficients*, size_t, bool, long double);

f64::Coefficients difference(const f64::Coefficients& a, const extended::Coefficients& b) {
    f64::Coefficients d;
#define SUBTRACT(name) d.name = double(a.name - b.name);
    COEFFICIENTS(SUBTRACT)
#undef SUBTRACT
    return d;
}

bool round_to_float(const f64::Coefficients& k, f32::Coefficients& to) {
    to = rounded<f32>(k);
    bool all = true;
#define CHECK_FINITE(name) all = all && scene::finite(double(to.name));
    COEFFICIENTS(CHECK_FINITE)
#undef CHECK_FINITE
    return all;
}

} // namespace dermis::plan
