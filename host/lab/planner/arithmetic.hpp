// SPDX-License-Identifier: MIT
// The step of kernels/step.h and kernels/responses.h in arithmetic that counts its own errors.
#pragma once

#include "host/lab/schedule/extended.hpp"
#include "host/lab/schedule/forcing.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::planner {

// A value and its error. shift is the part of the error with a known sign, because coefficients and load differ from
// their references; shifts cancel where the values do. off is a bound of the rest.
struct Counted {
    double value, off, shift = 0;
};

inline Counted operator-(const Counted& a) { return {-a.value, a.off, -a.shift}; }

// One element of a cell under unit pressure (between frames: a bound over all cells), at unit roundoff u. Of elements
// in series, whose motion the kernel adds up, the first one has the sum, rate and acceleration of all elements, and a
// spring has the rate that its state holds.
struct CountedCell {
    Counted eps{0, 0}, sum{0, 0}, rate{0, 0}, acceleration{0, 0}, spring_rate{0, 0};
    double excess = 0;    // between frames: greatest |pressure less the spring's stress|
    bool flushed = false; // the errors contain a value that was too small to be stored

    // The signal of a quantity.
    const Counted& signal(int q) const {
        const Counted* const of[] = {&eps, &eps, &sum, &rate, &acceleration};
        return *of[q];
    }
    double value(int q) const { return signal(q).value; }
    double error(int q) const { return signal(q).off + std::abs(signal(q).shift); }
};

// The pressures of a step per unit of the map; between frames their greatest magnitudes.
struct CountedLoad {
    Counted s0{0, 0}, ds{0, 0}, sj{0, 0};
    double end = 0; // of s0 + ds, between frames
    Counted past{0, 0};
};

// Returns the error of the factors of ds under a sine (schedule/forcing.cpp) at a unit roundoff: they are differences
// of terms that are each rounded. w: angular frequency, 1/s.
f64::Coefficients cancelled_under_sine(const f64::Coefficients&, const plan::Element&, const plan::ResponseRule&,
                                       double w, double amplitude, double unit);

// The same under the waves of a window, one in each segment of a step of dt seconds (gains_of_growth).
f64::Coefficients cancelled_under_window(const plan::Element&, const plan::ResponseRule&,
                                         const std::vector<plan::Segment<double>>&, double amplitude, double dt,
                                         double unit);

// Adds the errors of an elastic element's coefficients beside their own roundings: its modulus is rounded, because it
// may stand for several springs in series, and its mean acceleration is the small difference of two rates.
void add_of_elastic(f64::Coefficients& off, const f64::Coefficients&, const plan::Element&,
                    const plan::Forcing<double>*, double unit);

// The step of one element. z is dt/tau.
struct CountedStep {
    f64::Coefficients k;           // in double
    f64::Coefficients shift{};     // k less its references
    f64::Coefficients cancelled{}; // the error of references that are small differences of large terms
    double unit = 0x1p-53;         // the unit roundoff of the references
    CountedLoad load;
    double z = 0;
    bool spring = false;               // the last of several elements in series, which keeps no strain
    const CountedStep* past = nullptr; // the second coefficients, under parabolic hold
};

struct CountedArithmetic {
    double u;            // unit roundoff
    double peak;         // greatest pressure: values are per unit of it
    bool single, bound;  // rounded to float; values are bounds and never cancel, as between frames
    double carried;      // share of an addition's rounding that stays in the sum: 1, or 2u compensated
    double flush;        // magnitude below which results are stored as 0, per unit of the pressure that is read
    double denormal = 0; // rounding of a float that is no normal number, over the share of the peak that is read
    double least = 0;    // least pressure that is not 0, per unit of the pressure that is read; 0: not known

    // Half a unit in the last place of the most pressed cell's value. In every other cell it is at most this.
    double rounding(double x) const {
        const double greatest = peak * std::abs(x) * (1 + 1e-5);
        return greatest == 0 ? 0 : std::max(std::ldexp(u, std::ilogb(greatest)), denormal) / peak;
    }
    // A number as the kernel gets it, rounded to float where the kernel is in float.
    Counted stored(Counted a) const {
        const double rounded = single ? double(float(a.value)) : a.value;
        if (!std::isfinite(rounded)) return {a.value, INFINITY};
        a.shift += rounded - a.value;
        return bound ? Counted{a.value, a.off + std::abs(a.shift)} : a;
    }
    // A coefficient. units: the error of its reference.
    Counted factor(const CountedStep& step, double f64::Coefficients::*name, double units) const {
        return stored(
            {step.k.*name, units * step.unit * std::abs(step.k.*name) + step.cancelled.*name, step.shift.*name});
    }
    Counted times(Counted a, Counted b) const {
        const double x = a.value * b.value, off = std::abs(a.value) * b.off + std::abs(b.value) * a.off;
        return {x, off + (std::abs(a.value) == 1 ? 0 : rounding(x)),
                a.value * b.shift + b.value * a.shift + a.shift * b.shift};
    }
    Counted plus(Counted a, Counted b) const {
        const double x = bound ? std::abs(a.value) + std::abs(b.value) : a.value + b.value;
        return {x, a.off + b.off + rounding_of_sum(x, a, b), a.shift + b.shift};
    }

    // One step of n elements in series. steps: their coefficients, joined by plan::join_loads. The errors that eps and
    // sum had before are carried on linearly, because the kernel's terms cancel.
    void press(const CountedStep* steps, size_t n, const CountedCell* before, CountedCell* after) const;

  private:
    CountedLoad pressures(const CountedLoad&) const;
    Counted excess_stress(const CountedStep&, const CountedLoad&, const CountedCell&) const;
    void strain(const CountedStep&, const CountedLoad&, const CountedCell& before, CountedCell& after) const;
    void spring(const CountedStep&, const CountedLoad&, const CountedCell& before, CountedCell& after) const;
    static double most(const Counted& a) { return std::abs(a.value) + a.off + std::abs(a.shift); }
    // The rounding of a sum is no more than either of its terms, and there is none where they cancel down to less than
    // the smaller one.
    double rounding_of_sum(double x, const Counted& a, const Counted& b) const {
        if (!bound && std::abs(x) < 0.9 * std::min(std::abs(a.value), std::abs(b.value))) return 0;
        return std::min({rounding(x), most(a), most(b)});
    }
    // The factor by which a step reduces the error that a sum had before, if its own roundings are counted too: the
    // step takes a part of the sum back.
    double contraction(double part) const { return std::abs(1 - part) + 4 * u * std::abs(part); }
    // What a compensated sum's value has lost to rounding: the kernel gives it back only in the next addition.
    double lost(const Counted& sum) const { return carried < 1 ? rounding(sum.value) : 0; }
    // The error of a value that is stored as 0. before: strains or sums have been stored as 0; the run's value may then
    // be smaller than x by its error `off`.
    double flushed(double x, bool before = false, double off = 0) const {
        const double most = flush + (before ? off : 0);
        return x != 0 && (bound || least * std::abs(x) < most) ? flush : 0;
    }
    // The rounding that stays in a sum x after a step. In a compensated sum: a small part of it, what is too small to
    // be carried, the step's rounding of what was lost before, and of what is lost now if the step exceeds the sum.
    double left(double x, const Counted& before, const Counted& step) const {
        const double rounded = std::min(rounding(x), most(before));
        if (carried == 1) return rounded;
        const double of_step = std::min(rounding(step.value), most(before));
        return carried * rounded + std::min(rounded, flush) + std::min(of_step, lost(before)) +
               (most(step) > std::abs(before.value) ? of_step : 0);
    }
};

} // namespace dermis::planner
