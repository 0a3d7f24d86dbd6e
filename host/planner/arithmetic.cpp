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
    Units(const f64::Coefficients& k, double z)
        : b(z > 1 ? 2.5 : 3), v0(2 + 2 * z), a0(k.a2 == 0 ? 5 + 2 * z
                                                : z > 1   ? 3
                                                          : 7) {}
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

CountedCell CountedArithmetic::pressed(const CountedCell& c, const f64::Coefficients& k, const CountedLoad& load,
                                       double z) const {
    const Units units(k, z);
    const Counted p{1, (bound ? 4 : 1) * (single ? u : 0)}; // rounded to float; frames are joined in it
    const auto pressure = [&](const Counted& share) {
        return times({share.value, share.off + of(share.value, 0).off}, p);
    };
    const Counted s0 = pressure(load.s0), ds = pressure(load.ds), sj = pressure(load.sj);
    const Counted eps{c.eps, 0}, sum{c.sum, 0};
    const Counted r = plus(s0, times(of(-k.E, 0), eps));
    const Counted step = plus(times(of(k.b, units.b), r), times(of(k.f, units.changes, load.cancelled.f), ds));
    const Counted held = plus(times(of(k.i0, units.i0), eps), times(of(k.i1, units.i1), s0));
    const Counted gained = plus(held, times(of(k.i2, units.i2, load.cancelled.i2), ds));
    const Counted leaked = plus(gained, times(of(-k.leak, units.leak), sum));
    const Counted rate = plus(times(of(k.v0, units.v0), r), times(of(k.v1, units.changes, load.cancelled.v1), ds));
    const Counted acceleration =
        plus(plus(times(of(k.a0, units.a0), r), times(of(k.a1, units.changes, load.cancelled.a1), ds)),
             times(of(k.a2, units.a2), sj));
    const double keep = std::abs(1 - k.b * k.E), keep_sum = std::abs(1 - k.leak);
    CountedCell n;
    n.eps = bound ? keep * c.eps + std::abs(k.b * s0.value) + std::abs(k.f * ds.value) : c.eps + step.value;
    n.sum = bound ? keep_sum * c.sum + gained.value : c.sum + leaked.value;
    n.rate = rate.value;
    n.acceleration = acceleration.value;
    // The flush acts where the least pressed cell stores less than it, but not 0.
    const auto flushed = [&](double x) { return x != 0 && (bound || least * std::abs(x) < flush) ? flush : 0; };
    // A compensated sum keeps a part of each addition's rounding, and what of it is too small to be carried.
    const auto left = [&](double x) {
        return carried < 1 ? carried * rounding(x) + std::min(rounding(x), flush) : rounding(x);
    };
    n.d_eps = keep * c.d_eps + step.off + left(n.eps) + flushed(n.eps);
    n.d_sum = keep_sum * c.d_sum + std::abs(k.i0) * c.d_eps + leaked.off + left(n.sum) + flushed(n.sum);
    const double d_eps = c.d_eps + (carried < 1 ? rounding(c.eps) : 0); // rates take the rounded strain
    n.d_rate = rate.off + std::abs(k.v0 * k.E) * d_eps;
    n.d_acceleration = acceleration.off + std::abs(k.a0 * k.E) * d_eps;
    return n;
}

} // namespace dermis::planner
