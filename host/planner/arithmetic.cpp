// SPDX-License-Identifier: MIT
#include "host/planner/arithmetic.hpp"

namespace dermis::planner {

CountedCell CountedArithmetic::pressed(const CountedCell& c, const f64::Coefficients& k, double s0_, double ds_,
                                       double sj_) const {
    // The pressure is rounded to float, in which frames are interpolated too.
    const Counted p{1, (bound ? 4 : 1) * (single ? u : 0)};
    const Counted s0 = times(of(s0_), p), ds = times(of(ds_), p), sj = times(of(sj_), p);
    const Counted eps{c.eps, 0}, sum{c.sum, 0};
    const Counted r = plus(s0, times(of(-k.E), eps));
    const Counted step = plus(times(of(k.b), r), times(of(k.f), ds));
    const Counted gained = plus(plus(times(of(k.i0), eps), times(of(k.i1), s0)), times(of(k.i2), ds));
    const Counted leaked = plus(gained, times(of(-k.leak), sum));
    const Counted rate = plus(times(of(k.v0), r), times(of(k.v1), ds));
    const Counted acceleration = plus(plus(times(of(k.a0), r), times(of(k.a1), ds)), times(of(k.a2), sj));
    const double keep = std::abs(1 - k.b * k.E), keep_sum = std::abs(1 - k.leak);
    CountedCell n;
    n.eps = bound ? keep * c.eps + std::abs(k.b * s0_) + std::abs(k.f * ds_) : c.eps + step.value;
    n.sum = bound ? keep_sum * c.sum + gained.value : c.sum + leaked.value;
    n.rate = rate.value;
    n.acceleration = acceleration.value;
    n.d_eps = keep * c.d_eps + step.off + carried * rounding(n.eps) + flush;
    n.d_sum = keep_sum * c.d_sum + std::abs(k.i0) * c.d_eps + leaked.off + carried * rounding(n.sum) + flush;
    n.d_rate = rate.off + std::abs(k.v0 * k.E) * c.d_eps;
    n.d_acceleration = acceleration.off + std::abs(k.a0 * k.E) * c.d_eps;
    return n;
}

} // namespace dermis::planner
