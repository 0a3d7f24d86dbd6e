// SPDX-License-Identifier: MIT
#include "host/core/model/coefficients.hpp"
#include "tests/support.hpp"

#include <random>

using namespace test;

namespace {

using Long = long double;

// P0..P4 in 64 bits of mantissa: the power series, or where it needs too many terms the recurrence.
Long phi_reference(int k, Long z) {
    if (z > 3) {
        Long p = std::exp(-z), one_over_factorial = 1;
        for (int i = 1; i <= k; ++i) {
            p = (one_over_factorial - p) / z;
            one_over_factorial /= i;
        }
        return p;
    }
    Long term = 1, sum = 0;
    for (int i = 1; i <= k; ++i) term /= i;
    for (int i = 0; i < 60; ++i) {
        sum += term;
        term *= -z / (i + 1 + k);
    }
    return sum;
}

double units(double x, Long reference) {
    return reference == 0 ? (x == 0 ? 0 : INFINITY) : double(std::abs((Long(x) - reference) / reference)) * 0x1p53;
}

} // namespace

TEST_CASE("coefficients are within a few units of 2^-53 over all moduli, times and steps") {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto decades = [&](double low, double high) { return std::pow(10, low + (high - low) * unit(random)); };
    double worst_b = 0, worst_b_slow = 0, worst_mean = 0, worst_mean_slow = 0, worst_f = 0, worst_i0 = 0, worst_i1 = 0,
           worst_i2 = 0, worst_decay = 0;
    for (int i = 0; i < 40000; ++i) {
        const double E = decades(-9, 9), eta = E * decades(-12, 12), dt = decades(-9, 6);
        const auto k = model::exact_coefficients({E, eta}, {INFINITY, false}, dt),
                   mean = model::exact_coefficients({E, eta}, {INFINITY, true}, dt);
        const Long q = Long(dt) / eta, z = E * q;
        double &of_b = z > 1 ? worst_b_slow : worst_b, &of_mean = z > 1 ? worst_mean_slow : worst_mean;
        of_b = std::max(of_b, units(k.b, q * phi_reference(1, z)));
        of_mean = std::max(of_mean, units(mean.a0, -phi_reference(1, z) * E / (Long(eta) * eta)));
        worst_f = std::max(worst_f, units(k.f, q * phi_reference(2, z)));
        worst_i0 = std::max(worst_i0, units(k.i0, dt * phi_reference(1, z)));
        worst_i1 = std::max(worst_i1, units(k.i1, dt * q * phi_reference(2, z)));
        worst_i2 = std::max(worst_i2, units(k.i2, dt * q * phi_reference(3, z)));
        if (z < 700) worst_decay = std::max(worst_decay, units(k.v0 * eta, std::exp(-z)) / double(6 + 2 * z));
    }
    CHECK(worst_b <= 3);
    CHECK(worst_b_slow <= 2.5);
    CHECK(worst_f <= 4.5);
    CHECK(worst_i0 <= 3.5);
    CHECK(worst_i1 <= 4.5);
    CHECK(worst_mean <= 7);
    CHECK(worst_mean_slow <= 3);
    CHECK(worst_i2 <= 10);
    CHECK(worst_decay <= 1);
}

TEST_CASE("modulus 0 and viscosity 0 are limits, not errors") {
    const auto dashpot = model::exact_coefficients({0, 2}, {INFINITY, false}, 0.5);
    CHECK(dashpot.b == 0.25);
    CHECK(dashpot.i0 == 0.5);
    CHECK(dashpot.i1 == 0.0625);
    CHECK(dashpot.v0 == 0.5);
    const auto spring = model::exact_coefficients({4, 0}, {INFINITY, true}, 0.5);
    CHECK(spring.b == 0.25);
    CHECK(spring.f == 0.25);
    CHECK(spring.i0 == 0);
    CHECK(spring.i1 == 0.125);
    CHECK(spring.i2 == 0.0625);
    CHECK(spring.v0 == 0);
    CHECK(spring.v1 == 0.5);
    f64::Coefficients bent = spring; // the pressure bows by (ds - past)/2, from 0 at the start to 0 at the end
    const f64::Coefficients past = model::bend(bent, {4, 0}, {INFINITY, true}, 0.5, 0.5);
    CHECK(bent.f == spring.f);
    CHECK(past.f == 0);
    CHECK(past.v1 == -0.25);
    CHECK(bent.v1 == 0.75);
    CHECK(past.i2 == relative(0.5 / (6 * 4) / 2, 1e-15));
    CHECK(bent.i2 == relative(0.0625 - 0.5 / (6 * 4) / 2, 1e-15));
}

TEST_CASE("frames on a parabola give its strain, integral, rate and acceleration, at any z and any steps") {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto decades = [&](double low, double high) { return std::pow(10, low + (high - low) * unit(random)); };
    double worst[5] = {};
    for (int i = 0; i < 20000; ++i) {
        const double E = decades(-3, 3), dt = decades(-3, 3), eta = E * dt / decades(-12, 6),
                     before = dt * decades(-1, 1);
        // The pressure is a + b*u + c*u*u, u = t/dt, on a skin at rest at t = 0; frames at -before, 0 and dt.
        const double a = 2 * unit(random) - 1, b = 2 * unit(random) - 1, c = 2 * unit(random) - 1, u = -before / dt;
        const double ds = b + c, past = -(b * u + c * u * u);
        const Long q = Long(dt) / eta, z = E * q;
        const auto sum = [&](int k) {
            return a * phi_reference(k, z) + b * phi_reference(k + 1, z) + 2 * c * phi_reference(k + 2, z);
        };
        const auto check = [&](double& most, double x, Long reference, Long scale) {
            // Frames that are far closer before the step than within it determine the parabola less well.
            most = std::max(most, double(std::abs(Long(x) - reference) / (scale * (1 + 1 / (u * u)))));
        };
        for (bool mean : {false, true}) {
            f64::Coefficients k = model::exact_coefficients({E, eta}, {INFINITY, mean}, dt);
            const f64::Coefficients p = model::bend(k, {E, eta}, {INFINITY, mean}, dt, before);
            const Long of_a = std::abs(a), of_b = std::abs(b), of_c = 2 * std::abs(c);
            const auto size = [&](Long p0, Long p1, Long p2) { return of_a * p0 + of_b * p1 + of_c * p2; };
            const Long p0 = phi_reference(0, z), p1 = phi_reference(1, z), p2 = phi_reference(2, z),
                       p3 = phi_reference(3, z), p4 = phi_reference(4, z);
            check(worst[0], k.b * a + k.f * ds + p.f * past, q * sum(1), q * size(p1, p2, p3));
            check(worst[1], k.i1 * a + k.i2 * ds + p.i2 * past, dt * q * sum(2), dt * q * size(p2, p3, p4));
            check(worst[2], k.v0 * a + k.v1 * ds + p.v1 * past, sum(0) / eta, size(p0, p1, p2) / eta);
            const Long per_step = Long(eta) * dt;
            if (!mean)
                check(worst[3], k.a0 * a + k.a1 * ds + p.a1 * past, (-z * a * p0 + b * p0 + 2 * c * p1) / per_step,
                      size(z * p0, p0, p1) / per_step);
            else
                check(worst[4], k.a0 * a + k.a1 * ds + p.a1 * past, (-z * a * p1 + b * p1 + 2 * c * p2) / per_step,
                      size(z * p1, p1, p2) / per_step);
        }
    }
    for (double w : {worst[0], worst[1], worst[2], worst[4]}) CHECK(w <= 1e-15);
    CHECK(worst[3] <= 2e-13); // contains e^-z, whose error grows with z
}

TEST_CASE("an adapting integral's coefficients solve their equation, at any pair of time constants") {
    // tau_a*y' = -y + tau_a*eps beside eta*eps' + E*eps = s0 + ds*t/dt, by classical Runge-Kutta in long double
    for (double tau : {1e-3, 0.1, 0.5, 0.5000001, 3.0, 1e4})
        for (double adaptation : {0.02, 0.5, 7.0, 1e5}) {
            CAPTURE(tau);
            CAPTURE(adaptation);
            const double dt = 0.4, E = 2, eta = E * tau;
            const auto k = model::exact_coefficients({E, eta}, {adaptation, false}, dt);
            const int n = 20000;
            const Long h = Long(dt) / n;
            f64::Coefficients bent = k;
            const double bow = -2 * model::bend(bent, {E, eta}, {adaptation, false}, dt, dt).i2;
            for (int part = 0; part < 4; ++part) { // eps(0) = 1, or s0 = 1, or ds = 1, or a bow of u*u - u
                Long eps = part == 0, y = 0;
                const auto slope = [&](Long t, Long e, Long v, Long& de, Long& dv) {
                    de = ((part == 1) + (part == 2) * t / dt + (part == 3) * (t / dt) * (t / dt - 1) - E * e) / eta;
                    dv = e - v / adaptation;
                };
                for (int i = 0; i < n; ++i) {
                    Long a, b, c, d, A, B, C, D;
                    slope(i * h, eps, y, a, A);
                    slope((i + 0.5L) * h, eps + h / 2 * a, y + h / 2 * A, b, B);
                    slope((i + 0.5L) * h, eps + h / 2 * b, y + h / 2 * B, c, C);
                    slope((i + 1) * h, eps + h * c, y + h * C, d, D);
                    eps += h / 6 * (a + 2 * b + 2 * c + d);
                    y += h / 6 * (A + 2 * B + 2 * C + D);
                }
                const double computed = part == 0 ? k.i0 : part == 1 ? k.i1 : part == 2 ? k.i2 : bow;
                CHECK(computed == relative(double(y), 1e-10));
            }
            CHECK(k.leak == relative(-std::expm1(-dt / adaptation), 1e-14));
        }
    const auto plain = model::exact_coefficients({1.54, 1}, {INFINITY, false}, 0.01),
               slow = model::exact_coefficients({1.54, 1}, {1e12, false}, 0.01);
    CHECK(slow.i0 == relative(plain.i0, 1e-13));
    CHECK(slow.i1 == relative(plain.i1, 1e-13));
    CHECK(plain.leak == 0);
}
