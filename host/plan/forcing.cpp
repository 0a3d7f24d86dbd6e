// SPDX-License-Identifier: MIT
#include "host/plan/forcing.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::plan {

std::vector<Segment> segments_of(const scene::Waveform& load, scene::Instant from, scene::Instant to) {
    const auto later = [](const scene::Instant& t, const scene::Knot& k) { return t < k.time; };
    auto knot = std::upper_bound(load.knots().begin(), load.knots().end(), from, later);
    std::vector<Segment> segments;
    for (scene::Instant begin = from; begin < to;) {
        const scene::Instant end = knot == load.knots().end() ? to : std::min(to, (knot++)->time);
        const double u0 = load.after(begin) - load.after(from);
        segments.push_back({end - begin, u0, load.rise(begin, end)});
        begin = end;
    }
    return segments;
}

namespace {

void force_straight(f64::Coefficients& whole, const Element& element, const ResponseRule& rule,
                    const std::vector<Segment>& segments, double dt) {
    if (segments.size() == 1) return scale_change(whole, segments[0].du);
    const ResponseRule density{.sa2_adaptation = rule.sa2_adaptation, .step_mean = false};
    double eps = 0, sum = 0, rate = 0, acceleration = 0;
    for (const Segment& s : segments) {
        const f64::LaneCoefficients k = f64::lanes_of(exact_coefficients(element, density, s.length));
        const f64::Load load = f64::load(s.u0, s.du, 0);
        rate = f64::rate_after(eps, load, k);
        acceleration = f64::acceleration_after(eps, load, k);
        sum += f64::integral_step(f64::integral_gained(eps, load, k), sum, k);
        eps += f64::strain_step(eps, load, k);
    }
    whole.f = eps;
    whole.i2 = sum;
    whole.v1 = rate;
    whole.a1 = rule.step_mean ? rate / dt : acceleration;
}

using Complex = std::complex<double>;

// a/b by Smith's method. That of std::complex depends on the compiler, and calls a function.
Complex quotient(Complex a, Complex b) {
    if (std::abs(b.real()) < std::abs(b.imag())) {
        const double ratio = b.real() / b.imag(), denominator = b.real() * ratio + b.imag();
        return {(a.real() * ratio + a.imag()) / denominator, (a.imag() * ratio - a.real()) / denominator};
    }
    const double ratio = b.imag() / b.real(), denominator = b.imag() * ratio + b.real();
    return {(a.imag() * ratio + a.real()) / denominator, (a.imag() - a.real() * ratio) / denominator};
}

// The real part of a*b.
double real_product(Complex a, Complex b) { return a.real() * b.real() - a.imag() * b.imag(); }

// The steady-state response to the sine, less the decayed rest of its value at the step's start.
void force_sine(f64::Coefficients& k, const Element& m, const ResponseRule& rule, const Sine& s, double dt) {
    const Complex turn = s.turn, rate_of_turn(-s.w * turn.imag(), s.w * turn.real()); // i w turn
    const Complex eps0 = quotient({s.start.imag(), -s.start.real()}, {m.modulus, s.w * m.viscosity});
    const Complex sum0 = quotient(eps0, {1 / rule.sa2_adaptation, s.w});
    const double left = k.v0 * m.viscosity; // e^-z, the factor by which a strain decays over the step
    const double wave = s.start.imag();     // the held pressure, whose effect the coefficients contain: subtracted
    k.f = real_product(eps0, turn - left) - k.b * wave;
    k.i2 = (real_product(sum0, turn - (1 - k.leak)) - eps0.real() * k.i0) - k.i1 * wave;
    k.v1 = real_product(eps0, rate_of_turn + m.modulus * k.v0) - k.v0 * wave;
    const double acceleration = real_product(eps0, -s.w * s.w * turn + k.E * k.a0) - k.a0 * wave;
    k.a1 = rule.step_mean ? k.v1 / dt : acceleration;
}

// Writes the impulses of a jump. whole: the pressure of the step is the jump; held: the load does not change before it.
void force_impulse(f64::Coefficients& k, const Element& m, double jump, bool whole, bool held) {
    const double fa1 = is_elastic(m) ? final_strain(m, jump) : 0, fa2 = is_elastic(m) ? 0 : strain_rate(m, jump);
    if (held) k.f = k.i2 = 0;
    k.v0 = whole ? fa1 : 0; // r = sj = the pressure
    k.v1 = whole ? 0 : fa1;
    k.a0 = 0;
    k.a1 = whole ? 0 : fa2;
    k.a2 = whole ? fa2 : 0;
}

} // namespace

void scale_change(f64::Coefficients& k, double du) {
    for (double* factor : {&k.f, &k.i2, &k.v1, &k.a1}) *factor *= du;
}

void force(f64::Coefficients& k, const Element& m, const ResponseRule& rule, const Forcing& forcing) {
    if (forcing.sine) force_sine(k, m, rule, *forcing.sine, forcing.dt);
    else if (!forcing.segments.empty()) force_straight(k, m, rule, forcing.segments, forcing.dt);
    if (forcing.slope && is_elastic(m)) k.a1 = (k.v1 - final_strain(m, *forcing.slope)) / forcing.slope_length;
    if (forcing.impulse) force_impulse(k, m, *forcing.impulse, forcing.framed, forcing.held);
}

} // namespace dermis::plan
