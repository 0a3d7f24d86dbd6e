// SPDX-License-Identifier: MIT
#include "host/core/model/coefficients_in.hpp"

namespace dermis::model {
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
template f64::Coefficients bend(f64::Coefficients&, const Element&, const ResponseRule&, double, double);

f64::Coefficients exact_coefficients(const Element& m, const ResponseRule& rule, double dt) {
    return exact_coefficients_in<f64>(m, rule, dt);
}

} // namespace dermis::model
