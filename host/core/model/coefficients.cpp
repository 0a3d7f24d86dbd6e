// SPDX-License-Identifier: MIT
#include "host/core/model/coefficients_in.hpp"

#include "host/core/base/refusal.hpp"

namespace dermis::plan {
namespace {

// P3 on [0, 1] as a polynomial of degree 12, with an error of 6e-5 units of 2^-53.
constexpr double p3_series[] = {0.16666666666666666,     -0.041666666666666664,  0.008333333333333314,
                                -0.0013888888888884815,  0.0001984126984080311,  -2.480158726973578e-05,
                                2.7557317827207793e-06,  -2.755727811568642e-07, 2.505127832212774e-08,
                                -2.0865204732880175e-09, 1.594972230606643e-10,  -1.0793584416656275e-11,
                                5.114980229101037e-13};

} // namespace

double p3_of(double z) {
    double p3 = 0;
    for (int i = 12; i >= 0; --i) p3 = p3 * z + p3_series[i];
    return p3;
}

template Phi<double> phi(double);
template f64::Coefficients exact_coefficients_in<f64>(const Element&, const ResponseRule&, double);
template void join_loads<f64>(f64::Coefficients*, size_t, bool, double);

f64::Coefficients exact_coefficients(const Element& m, const ResponseRule& rule, double dt) {
    return exact_coefficients_in<f64>(m, rule, dt);
}

f64::Coefficients bend(f64::Coefficients& k, const Element& m, const ResponseRule& rule, double dt, double before) {
    f64::Coefficients past{};
    if (dt == 0 || before == 0) return past;
    const double E = m.modulus, eta = m.viscosity;
    const double z = is_elastic(m) ? INFINITY : E * dt / eta, y = dt / rule.sa2_adaptation;
    const Phi<double> p = phi(z), of_y = phi(y);
    const Divided<double> d = divided(z, y);
    // What a pressure of u*u - u adds, u from 0 to 1. As in exact_coefficients_in, what grows with z is divided by E.
    const bool fast = std::max(z, y) > 1 && z >= y;
    const double strain = z <= 1 ? dt / eta * (2 * p.p3 - p.p2) : (p.p1 - 2 * p.p2) / E,
                 integral = dt * (fast ? (2 * (of_y.p3 - d.d3) - (of_y.p2 - d.d2)) / E : dt / eta * (2 * d.d4 - d.d3)),
                 rate = z <= 1 ? z * (p.p2 - 2 * p.p3) / eta : (1 - 2 * p.p1 + p.p0) / (E * dt),
                 at_end = eta > 0 ? (2 * p.p1 - p.p0) / (eta * dt) : 0, mean = eta > 0 ? rate / dt : 0;
    // The pressure bends by c times that; c = share*ds - past_share*(what changed over the step before).
    const double share = dt / (dt + before), past_share = share * dt / before;
    const auto add = [&](double f64::Coefficients::*factor, double bow) {
        k.*factor += share * bow;
        past.*factor = -past_share * bow;
    };
    add(&f64::Coefficients::f, strain);
    add(&f64::Coefficients::i2, integral);
    add(&f64::Coefficients::v1, rate);
    add(&f64::Coefficients::a1, rule.step_mean ? mean : at_end);
    return past;
}

bool round_to_float(const f64::Coefficients& k, f32::Coefficients& to) {
    to = rounded<f32>(k);
    bool all = true;
#define CHECK_FINITE(name) all = all && finite(double(to.name));
    COEFFICIENTS(CHECK_FINITE)
#undef CHECK_FINITE
    return all;
}

} // namespace dermis::plan
