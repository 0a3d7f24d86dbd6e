// SPDX-License-Identifier: MIT
#include "host/plan/forcing.hpp"

#include <algorithm>

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

void force_straight(f64::Coefficients& whole, const Element& element, const ResponseRule& rule,
                    const std::vector<Segment>& segments, double dt) {
    if (segments.size() == 1) { // whole's factors are those of a linear rise by 1
        for (double* factor : {&whole.f, &whole.i2, &whole.v1, &whole.a1}) *factor *= segments[0].du;
        return;
    }
    const ResponseRule density{.sa2_adaptation = rule.sa2_adaptation, .step_mean = false};
    double eps = 0, sum = 0, rate = 0, acceleration = 0;
    for (const Segment& s : segments) {
        const f64::LaneCoefficients k = f64::lanes_of(exact_coefficients(element, density, s.length));
        const f64::Load load = f64::load(s.u0, s.du, 0);
        rate = f64::rate_after(eps, load, k);
        acceleration = f64::acceleration_after(eps, load, k);
        sum += f64::integral_step(eps, sum, load, k);
        eps += f64::strain_step(eps, load, k);
    }
    whole.f = eps;
    whole.i2 = sum;
    whole.v1 = rate;
    whole.a1 = rule.step_mean ? rate / dt : acceleration;
}

// The steady-state response to the sine, less the decayed rest of its value at the step's start.
void force_sine(f64::Coefficients& k, const Element& m, const ResponseRule& rule, const Sine& s, double dt) {
    using Complex = std::complex<double>;
    const Complex iw(0, s.w);
    const Complex eps0 = Complex(0, -1) * s.start / (m.modulus + iw * m.viscosity);
    const Complex sum0 = eps0 / (1 / rule.sa2_adaptation + iw);
    const double left = k.v0 * m.viscosity; // e^-z, the factor by which a strain decays over the step
    const double wave = s.start.imag();     // the held pressure, whose effect the coefficients contain: subtracted
    k.f = (eps0 * (s.turn - left)).real() - k.b * wave;
    k.i2 = (sum0 * (s.turn - (1 - k.leak)) - eps0 * k.i0).real() - k.i1 * wave;
    k.v1 = (eps0 * (iw * s.turn + m.modulus * k.v0)).real() - k.v0 * wave;
    const double acceleration = (eps0 * (-s.w * s.w * s.turn + k.E * k.a0)).real() - k.a0 * wave;
    k.a1 = rule.step_mean ? k.v1 / dt : acceleration;
}

void force_change(f64::Coefficients& k, const Element& m, double slope, double dt) {
    k.a1 = (k.v1 - final_strain(m, slope)) / dt;
}

void force_impulse(f64::Coefficients& k, const Element& m, double jump, bool whole, bool held) {
    const double fa1 = is_elastic(m) ? final_strain(m, jump) : 0, fa2 = is_elastic(m) ? 0 : strain_rate(m, jump);
    if (held) k.f = k.i2 = 0;
    k.v0 = whole ? fa1 : 0; // r = sj = the pressure
    k.v1 = whole ? 0 : fa1;
    k.a0 = 0;
    k.a1 = whole ? 0 : fa2;
    k.a2 = whole ? fa2 : 0;
}

} // namespace dermis::plan
