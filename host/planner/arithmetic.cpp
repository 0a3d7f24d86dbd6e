// SPDX-License-Identifier: MIT
#include "host/planner/arithmetic.hpp"

#include <algorithm>

namespace dermis::planner {

namespace {

// Bounds of what coefficients are off by in double, in units of 2^-53; tests/coefficients_test.cpp measures b, i0, i1
// and a0, and the factors of ds before they contain the load's change. e^-z is off by as many more as z has units; the
// a0 of a step mean, whose a2 is not 0, does not contain it.
struct Units {
    double b, i0 = 3.5, i1 = 4.5, leak = 4, v0, a0, a2 = 2, changes = 8, i2 = 14;
    // joined: the elements whose shares are added up.
    Units(double z, bool step_mean, double joined)
        : b(z > 1 ? 2.5 : 3), v0(2 + 2 * z), a0(!step_mean ? 5 + 2 * z
                                                : z > 1    ? 3
                                                           : 7) {
        for (double* sum : {&i1, &a2, &changes, &i2}) *sum += joined - 1;
    }
};

} // namespace

f64::Coefficients cancelled_under_sine(const f64::Coefficients& k, const plan::Element& m,
                                       const plan::ResponseRule& rule, double w, double amplitude) {
    const double eps = 8 * 0x1p-53 * std::abs(amplitude) / std::hypot(m.modulus, w * m.viscosity);
    f64::Coefficients off{};
    off.f = eps;
    off.i2 = eps * (1 / std::hypot(1 / rule.sa2_adaptation, w) + k.i0);
    off.v1 = eps * (w + m.modulus * k.v0);
    off.a1 = rule.step_mean ? off.v1 * k.a2 * m.viscosity // a2 is 1/(eta*dt)
                            : eps * (w * w + m.modulus * std::abs(k.a0));
    return off;
}

struct CountedArithmetic::Pressures {
    Counted s0, ds, sj;
};

CountedArithmetic::Pressures CountedArithmetic::pressures(const CountedLoad& load) const {
    const Counted p{1, (bound ? 4 : 1) * (single ? u : 0)}; // rounded to float; frames are joined in it
    const auto pressure = [&](const Counted& share) {
        return times({share.value, share.off + of(share.value, 0).off}, p);
    };
    return {pressure(load.s0), pressure(load.ds), pressure(load.sj)};
}

void CountedArithmetic::strain(const CountedStep& step, const Pressures& p, const CountedCell& c,
                               CountedCell& n) const {
    const f64::Coefficients& k = step.k;
    const Units units(step.z, false, 1);
    const Counted r = plus(p.s0, times(of(-k.E, 0), {c.eps, 0}));
    const Counted moved = plus(times(of(k.b, units.b), r), times(of(k.f, units.changes, step.load.cancelled.f), p.ds));
    const double keep = std::abs(1 - k.b * k.E);
    n.eps = bound ? keep * c.eps + std::abs(k.b * p.s0.value) + std::abs(k.f * p.ds.value) : c.eps + moved.value;
    n.d_eps = keep * c.d_eps + moved.off + left(n.eps) + flushed(n.eps);
}

void CountedArithmetic::spring(const CountedStep& step, const Pressures& p, const CountedCell& c,
                               CountedCell& n) const {
    const f64::Coefficients& k = step.k;
    const Counted eps = plus(times(of(k.b, 1), p.s0), times(of(k.f, 8, step.load.cancelled.f), p.ds));
    n.eps = eps.value;
    n.d_eps = eps.off + flushed(eps.value);
    const Counted rate = plus({k.v0 * c.spring_rate, k.v0 * c.d_spring_rate}, times(of(k.v1, 2), p.ds));
    n.spring_rate = rate.value;
    n.d_spring_rate = rate.off + flushed(rate.value);
}

void CountedArithmetic::press(const CountedStep* steps, size_t count, const CountedCell* before,
                              CountedCell* after) const {
    const Pressures p = pressures(steps[0].load);
    const f64::Coefficients& first = steps[0].k;
    Counted gained{0, 0}, rate{0, 0}, acceleration{0, 0};
    double keep_off = 0, rate_off = 0, acceleration_off = 0; // from what the strains are off by
    for (size_t e = 0; e < count; ++e) {
        const CountedStep& step = steps[e];
        const f64::Coefficients& k = step.k;
        const CountedCell& c = before[e];
        CountedCell& n = after[e] = {};
        if (step.spring) {
            spring(step, p, c, n);
            const Counted change = plus({n.spring_rate, n.d_spring_rate}, {-c.spring_rate, c.d_spring_rate});
            acceleration = plus(acceleration, times(of(k.a1, 1), change));
            continue;
        }
        strain(step, p, c, n);
        const Units units(step.z, first.a2 != 0, double(count));
        const Counted eps{c.eps, 0}, r = plus(p.s0, times(of(-k.E, 0), eps));
        gained = plus(gained, times(of(k.i0, units.i0), eps));
        rate = plus(rate, times(of(k.v0, units.v0), r));
        acceleration = plus(acceleration, times(of(k.a0, units.a0), r));
        if (e == 0) { // the load's share in all of them
            const f64::Coefficients& off = step.load.cancelled;
            gained = plus(plus(gained, times(of(k.i1, units.i1), p.s0)), times(of(k.i2, units.i2, off.i2), p.ds));
            rate = plus(rate, times(of(k.v1, units.changes, off.v1), p.ds));
            acceleration =
                plus(plus(acceleration, times(of(k.a1, units.changes, off.a1), p.ds)), times(of(k.a2, units.a2), p.sj));
        }
        const double d_eps = c.d_eps + (carried < 1 ? rounding(c.eps) : 0); // rates take the rounded strain
        keep_off += std::abs(k.i0) * c.d_eps;
        rate_off += std::abs(k.v0 * k.E) * d_eps;
        acceleration_off += std::abs(k.a0 * k.E) * d_eps;
    }
    const CountedCell& c = before[0];
    CountedCell& n = after[0];
    const Counted leaked = plus(gained, times(of(-first.leak, Units(0, false, 1).leak), {c.sum, 0}));
    const double keep = std::abs(1 - first.leak);
    n.sum = bound ? keep * c.sum + gained.value : c.sum + leaked.value;
    n.d_sum = keep * c.d_sum + keep_off + leaked.off + left(n.sum) + flushed(n.sum);
    n.rate = rate.value;
    n.d_rate = rate.off + rate_off;
    n.acceleration = acceleration.value;
    n.d_acceleration = acceleration.off + acceleration_off;
}

} // namespace dermis::planner
