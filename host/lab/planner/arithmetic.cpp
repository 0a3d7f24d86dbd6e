// SPDX-License-Identifier: MIT
#include "host/lab/planner/arithmetic.hpp"

#include <algorithm>

namespace dermis::planner {

namespace {

// Bounds of the errors of coefficients, in units of their arithmetic. tests/kernels/coefficients_test.cpp measures b,
// i0, i1 and a0 in double, and the factors of ds before they contain the load's change. The rounding of z adds up to z
// units to e^-z; the a0 of a step mean, which has an a2 that is not 0, does not contain e^-z.
struct Units {
    double b, i0 = 3.5, i1 = 4.5, leak = 4, v0, a0, a2 = 2, changes = 8, i2 = 14;
    // joined: the number of elements whose shares are added up.
    Units(double z, bool step_mean, double joined)
        : b(z > 1 ? 2.5 : 3), v0(2 + 2 * z), a0(step_mean ? (z > 1 ? 3 : 7) : 5 + 2 * z) {
        for (double* sum : {&i1, &a2, &changes, &i2}) *sum += joined - 1;
    }
};

} // namespace

f64::Coefficients cancelled_under_sine(const f64::Coefficients& k, const plan::Element& m,
                                       const plan::ResponseRule& rule, double w, double amplitude, double unit) {
    const double eps = 12 * unit * std::abs(amplitude) / std::hypot(m.modulus, w * m.viscosity);
    f64::Coefficients off{};
    off.f = eps;
    off.i2 = eps * (1 / std::hypot(1 / rule.sa2_adaptation, w) + k.i0);
    off.v1 = eps * (w + m.modulus * k.v0);
    off.a1 = rule.step_mean ? off.v1 * k.a2 * m.viscosity // a2 is 1/(eta*dt)
                            : eps * (w * w + m.modulus * std::abs(k.a0));
    return off;
}

// The terms are bounded by what they are in a step without length. The strain's error in one segment passes into the
// rates of the next.
f64::Coefficients cancelled_under_window(const plan::Element& m, const plan::ResponseRule& rule,
                                         const std::vector<plan::Segment<double>>& segments, double amplitude,
                                         double dt, double unit) {
    f64::Coefficients off{};
    const double relaxes = is_elastic(m) ? 0 : z_of(m, 1); // 1/s
    for (const plan::Segment<double>& s : segments) {
        if (!s.wave) continue;
        const double w = s.wave->w, T = s.length, compliance = 1 / std::hypot(m.modulus, w * m.viscosity),
                     lag = m.viscosity * compliance, leaky = 1 / std::hypot(1 / rule.sa2_adaptation, w), // s
            eps = 12 * unit * std::abs(amplitude) * compliance, held = eps * std::abs(s.wave->weight),
                     grown = eps * std::abs(s.wave->slope);
        off.f += 2 * held + grown * (2 * lag + T);
        off.i2 += held * (2 * leaky + dt) + grown * leaky * (2 * (lag + leaky) + T) + grown * lag * dt;
        off.v1 += held * (w + relaxes) + grown * (lag * (w + relaxes) + 1 + w * T);
        off.a1 += held * (w * w + relaxes * relaxes) + grown * (lag * (w * w + relaxes * relaxes) + 2 * w + w * w * T);
    }
    off.i2 += off.f * dt;
    off.a1 += off.v1 * relaxes + off.f * relaxes * relaxes;
    off.v1 += off.f * relaxes;
    if (rule.step_mean) off.a1 = off.v1 / dt;
    return off;
}

void add_of_elastic(f64::Coefficients& off, const f64::Coefficients& k, const plan::Element& m,
                    const plan::Forcing<double>* forcing, double unit) {
    if (!is_elastic(m)) return;
    using C = f64::Coefficients;
    for (double C::*factor : {&C::b, &C::f, &C::i1, &C::i2, &C::v1, &C::a1, &C::a2})
        off.*factor += unit_of_double * std::abs(k.*factor);
    if (forcing && forcing->slope)
        off.a1 += 12 * unit * (std::abs(k.v1) + final_strain(m, std::abs(*forcing->slope))) / forcing->slope_length;
}

CountedLoad CountedArithmetic::pressures(const CountedLoad& load) const {
    if (bound) return load; // their whole error is counted
    // The rounding of the map is the same in all responses.
    const auto pressure = [&](const Counted& share) { return times(stored(share), {1, 0}); };
    return {pressure(load.s0), pressure(load.ds), pressure(load.sj)};
}

using C = f64::Coefficients;

void CountedArithmetic::strain(const CountedStep& step, const CountedLoad& p, const CountedCell& c,
                               CountedCell& n) const {
    const Units units(step.z, false, 1);
    const double b = step.k.b, E = step.k.E, before = c.eps.value;
    const Counted r = excess_stress(step, p, c);
    Counted moved = plus(times(factor(step, &C::b, units.b), r), times(factor(step, &C::f, units.changes), p.ds));
    if (step.past) moved = plus(moved, times(factor(*step.past, &C::f, units.changes), p.past));
    const double keep = contraction(b * E);
    n.eps.value = before + moved.value;
    if (bound) { // 0 <= f <= b
        const double past = step.past ? std::abs(step.past->k.f) * p.past.value : 0;
        const double s0 = p.s0.value, f = step.k.f;
        n.eps.value = keep * before + std::min(b * s0 + f * p.ds.value, (b - f) * s0 + f * p.end) + past;
        n.excess = (std::abs(1 - b * E) + 0x1p-50) * r.value + (std::abs(1 - f * E) + 0x1p-50) * p.ds.value + E * past;
    }
    n.eps.shift = c.eps.shift + moved.shift;
    n.eps.off = keep * c.eps.off + std::abs(b * E) * lost(c.eps) + moved.off + left(n.eps.value, c.eps, moved);
    const double flush = flushed(n.eps.value, c.flushed, n.eps.off);
    n.eps.off += flush;
    n.flushed = c.flushed || flush > 0;
}

// The bound of the strain's error does not enter: strain() and press() carry it on beside the value.
Counted CountedArithmetic::excess_stress(const CountedStep& step, const CountedLoad& p, const CountedCell& c) const {
    Counted r = plus(p.s0, times(factor(step, &C::E, 0), {-c.eps.value, 0, -c.eps.shift}));
    if (bound) r.value = std::min(r.value, c.excess + p.sj.value);
    return r;
}

void CountedArithmetic::spring(const CountedStep& step, const CountedLoad& p, const CountedCell& c,
                               CountedCell& n) const {
    n.eps = plus(times(factor(step, &C::b, 1), p.s0), times(factor(step, &C::f, 8), p.ds));
    n.eps.off += flushed(n.eps.value);
    const double keep = step.k.v0; // 0 or 1
    const Counted kept{keep * c.spring_rate.value, keep * c.spring_rate.off, keep * c.spring_rate.shift};
    n.spring_rate = plus(kept, times(factor(step, &C::v1, 2), p.ds));
    if (step.past) n.spring_rate = plus(n.spring_rate, times(factor(*step.past, &C::v1, 2), p.past));
    n.spring_rate.off += flushed(n.spring_rate.value);
}

void CountedArithmetic::press(const CountedStep* steps, size_t count, const CountedCell* before,
                              CountedCell* after) const {
    const CountedLoad p = pressures(steps[0].load);
    const f64::Coefficients& first = steps[0].k;
    Counted gained{0, 0}, rate{0, 0}, acceleration{0, 0};
    double keep_off = 0, rate_off = 0, acceleration_off = 0; // from the strains' errors
    bool any_flushed = false;
    for (size_t e = 0; e < count; ++e) {
        const CountedStep& step = steps[e];
        const f64::Coefficients& k = step.k;
        const CountedCell& c = before[e];
        CountedCell& n = after[e] = {};
        any_flushed = any_flushed || c.flushed;
        if (step.spring) {
            spring(step, p, c, n);
            if (!bound) continue; // under an envelope the first element's coefficients have it
            const Counted change = plus(n.spring_rate, -c.spring_rate);
            acceleration = plus(acceleration, times(factor(step, &C::a1, 1), change));
            continue;
        }
        strain(step, p, c, n);
        const Units units(step.z, first.a2 != 0, double(count));
        const Counted eps{c.eps.value, 0, c.eps.shift}, r = excess_stress(step, p, c);
        gained = plus(gained, times(factor(step, &C::i0, units.i0), eps));
        rate = plus(rate, times(factor(step, &C::v0, units.v0), r));
        acceleration = plus(acceleration, times(factor(step, &C::a0, units.a0), r));
        if (e == 0) { // the load's share in all elements
            gained = plus(gained, times(factor(step, &C::i1, units.i1), p.s0));
            gained = plus(gained, times(factor(step, &C::i2, units.i2), p.ds));
            if (bound) gained.value -= std::max(0.0, k.i2 * (p.s0.value + p.ds.value - p.end)); // 0 <= i2 <= i1
            rate = plus(rate, times(factor(step, &C::v1, units.changes), p.ds));
            acceleration = plus(acceleration, times(factor(step, &C::a1, units.changes), p.ds));
            acceleration = plus(acceleration, times(factor(step, &C::a2, units.a2), p.sj));
            for (const auto& [sum, name] : {std::pair{&gained, &C::i2}, {&rate, &C::v1}, {&acceleration, &C::a1}})
                if (step.past) *sum = plus(*sum, times(factor(*step.past, name, units.changes), p.past));
        }
        const double d_eps = (1 + 4 * u) * (c.eps.off + lost(c.eps)); // integral and rates take the rounded strain
        keep_off += std::abs(k.i0) * d_eps;
        rate_off += std::abs(k.v0 * k.E) * d_eps;
        acceleration_off += std::abs(k.a0 * k.E) * d_eps;
    }
    const Counted& sum = before[0].sum;
    CountedCell& n = after[0];
    const Counted leak = factor(steps[0], &C::leak, Units(0, false, 1).leak);
    const Counted leaked = plus(gained, times(leak, {-sum.value, 0, -sum.shift}));
    const double keep = contraction(first.leak);
    n.sum.value = bound ? std::abs(1 - first.leak) * sum.value + gained.value : sum.value + leaked.value;
    n.sum.shift = sum.shift + leaked.shift;
    n.sum.off =
        keep * sum.off + std::abs(first.leak) * lost(sum) + keep_off + leaked.off + left(n.sum.value, sum, leaked);
    const double flush = flushed(n.sum.value, any_flushed, n.sum.off);
    n.sum.off += flush;
    n.flushed = n.flushed || flush > 0;
    n.rate = rate;
    n.rate.off += rate_off;
    n.acceleration = acceleration;
    n.acceleration.off += acceleration_off;
}

} // namespace dermis::planner
