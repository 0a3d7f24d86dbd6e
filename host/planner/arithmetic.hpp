// SPDX-License-Identifier: MIT
// The step of kernels/step.h and kernels/responses.h in arithmetic that keeps count of what it may be off by.
#pragma once

#include "host/plan/coefficients.hpp"

#include <cmath>

namespace dermis::planner {

// One element of a cell under unit pressure (between frames: a bound over all cells): exact values, and in d_* a
// running bound of the rounding error at unit roundoff u. Of elements in series that the kernel adds up, the first one
// has the sum, rate and acceleration of all, and a spring the rate that its state holds.
struct CountedCell {
    double eps = 0, sum = 0, rate = 0, acceleration = 0;
    double d_eps = 0, d_sum = 0, d_rate = 0, d_acceleration = 0;
    double spring_rate = 0, d_spring_rate = 0;

    // The signal of a quantity.
    double value(int q) const {
        const double of[] = {eps, eps, sum, rate, acceleration};
        return of[q];
    }
    double error(int q) const {
        const double of[] = {d_eps, d_eps, d_sum, d_rate, d_acceleration};
        return of[q];
    }
};

// A value, and what it may be off by.
struct Counted {
    double value, off;
};

// The pressures of a step per unit of the map, or between frames their greatest magnitudes.
struct CountedLoad {
    Counted s0, ds, sj;
    f64::Coefficients cancelled{}; // what factors of ds are off by where they are small differences (under a sine)
};

// Returns what plan::force_sine may leave the factors of ds off by, because it takes differences of terms that are each
// rounded. w: angular frequency, 1/s.
f64::Coefficients cancelled_under_sine(const f64::Coefficients&, const plan::Element&, const plan::ResponseRule&,
                                       double w, double amplitude);

// The step of one element. z is dt/tau.
struct CountedStep {
    f64::Coefficients k;
    CountedLoad load;
    double z = 0;
    bool spring = false; // in series with others: the last one, which keeps no strain
};

struct CountedArithmetic {
    double u;           // unit roundoff
    double peak;        // greatest pressure: values are per unit of it
    bool single, bound; // rounded to float; values are bounds and never cancel, as between frames
    double carried;     // share of an addition's rounding that stays in the sum: 1, or 2u compensated
    double flush;       // magnitude below which results are stored as 0
    double least = 0;   // least pressure that is not 0, per unit of the peak: 0 where it is not known

    // Half a unit in the last place of the greatest cell's value; of no other cell is it more.
    double rounding(double x) const {
        int exponent = 0;
        std::frexp(peak * std::abs(x) * (1 + 1e-5), &exponent);
        return x == 0 || peak == 0 ? 0 : std::ldexp(u, exponent - 1) / peak;
    }
    // A coefficient as it comes to the kernel: so many units of 2^-53 off in double, and rounded to float there.
    Counted of(double coefficient, double units, double cancelled = 0) const {
        const double in_double = units * 0x1p-53 * std::abs(coefficient) + cancelled;
        return {coefficient, in_double + (single ? std::abs(double(float(coefficient)) - coefficient) : 0)};
    }
    Counted times(Counted a, Counted b) const {
        const double x = a.value * b.value, off = std::abs(a.value) * b.off + std::abs(b.value) * a.off;
        return {x, off + (std::abs(a.value) == 1 ? 0 : rounding(x))};
    }
    Counted plus(Counted a, Counted b) const {
        const double x = bound ? std::abs(a.value) + std::abs(b.value) : a.value + b.value;
        return {x, a.off + b.off + (a.value == 0 || b.value == 0 ? 0 : rounding(x))};
    }

    // One step of n elements in series, whose coefficients are joined (plan::join_loads) and stand in `steps`. What eps
    // and sum were off by before is carried on linearly, where the kernel's terms cancel.
    void press(const CountedStep* steps, size_t n, const CountedCell* before, CountedCell* after) const;

  private:
    struct Pressures; // of an element over a step
    Pressures pressures(const CountedLoad&) const;
    void strain(const CountedStep&, const Pressures&, const CountedCell& before, CountedCell& after) const;
    void spring(const CountedStep&, const Pressures&, const CountedCell& before, CountedCell& after) const;
    double flushed(double x) const { return x != 0 && (bound || least * std::abs(x) < flush) ? flush : 0; }
    // A compensated sum keeps a part of each addition's rounding, and what of it is too small to be carried.
    double left(double x) const {
        return carried < 1 ? carried * rounding(x) + std::min(rounding(x), flush) : rounding(x);
    }
};

} // namespace dermis::planner
