// SPDX-License-Identifier: MIT
// The kernels in arithmetic that counts its own errors: a third `real` for the text of kernels/*.h, beside those of f32
// and f64.
#pragma once

#include "host/core/simd/model.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace dermis {
namespace planner {

// How a cell's numbers are rounded and stored. They are per unit of its pressure.
struct Rounding {
    double u = 0x1p-53;       // unit roundoff
    double peak = 1;          // the greatest pressure
    bool single = false;      // numbers are rounded to float
    bool bound = false;       // values are bounds, as between frames: what cancels in them need not do so in the run
    bool compensated = false; // sums carry their rounding errors
    double flush = 0;         // magnitude below which results are stored as 0, per unit of the pressure that is read
    double denormal = 0;      // rounding of a float that is no normal number, over the share of the peak that is read
    double least = 0;         // least pressure that is not 0, per unit of the pressure that is read; 0: not known

    // Half a unit in the last place of the most pressed cell's value, infinite if that is beyond the precision. In
    // every other cell it is at most this.
    double of(double size) const {
        const double greatest = peak * size * (1 + 1e-5);
        if (greatest > (single ? 3e38 : 1e308)) return INFINITY;
        const double binade = std::bit_cast<double>(std::bit_cast<std::uint64_t>(greatest) & 0x7ff0000000000000);
        return greatest == 0 ? 0 : std::max(u * binade, denormal) / peak;
    }
    // The error of a value that is stored as 0. off: how much smaller the run's value may be.
    double flushed(double size, double off = 0) const {
        return size != 0 && (bound || least * size < flush + off) ? flush : 0;
    }
    // What a compensated sum's value has lost to rounding: the kernel gives it back only in the next addition.
    double lost(double size) const { return compensated ? of(size) : 0; }
};

struct Counted;

// What is known of a number that the kernel's text does not say.
struct Known {
    const Counted* change = nullptr; // of a pressure: what is between it and another one, of which magnitudes are known
    double excess = INFINITY;        // of an element's stress between frames: the greatest |pressure less that stress|
    bool sum = false;                // of the state: what it is rounded by is counted where it is stored
    const Known* product = nullptr;  // of a product with it
};

// A value and its error. shift is the part of the error with a known sign, because coefficients and load differ from
// their references; shifts cancel where the values do. off is a bound of the rest. size is the value's magnitude, or
// between frames a bound of it; the value is then that of a cell under the greatest pressures.
struct Counted {
    double value = 0, off = 0, shift = 0, size = 0;
    const Rounding* by = nullptr; // null: a constant
    const Known* known = nullptr;

    Counted() = default;
    Counted(double x) : value(x), size(std::abs(x)) {}
    Counted(double x, double error, double shifted, const Rounding* rounding, const Known* beside = nullptr)
        : value(x), off(error), shift(shifted), size(std::abs(x)), by(rounding), known(beside) {}
    double most() const { return size + off + std::abs(shift); }
};

inline Counted operator-(const Counted& a) {
    Counted negative(-a.value, a.off, -a.shift, a.by);
    negative.size = a.size;
    return negative;
}

inline Counted operator+(const Counted& a, const Counted& b) {
    const Rounding* by = a.by ? a.by : b.by;
    Counted sum(a.value + b.value, a.off + b.off, a.shift + b.shift, by);
    if (by && by->bound) sum.size = a.size + b.size;
    // The rounding is no more than either term, and there is none where they cancel down to less than the smaller one.
    const bool cancels = sum.size < 0.9 * std::min(a.size, b.size);
    if (by && !(a.known && a.known->sum) && !cancels) {
        const double rounded = by->of(sum.size);
        sum.off += rounded < INFINITY ? std::min({rounded, a.most(), b.most()}) : INFINITY;
    }
    return sum;
}

inline Counted operator-(const Counted& a, const Counted& b) {
    for (const Known* known : {a.known, b.known})
        if (known && known->change) return *known->change;
    Counted difference = a + -b;
    if (b.known) difference.size = std::min(difference.size, b.known->excess);
    return difference;
}

inline Counted operator*(const Counted& a, const Counted& b) {
    const Rounding* by = a.by ? a.by : b.by;
    Counted product(a.value * b.value, a.size * b.off + b.size * a.off,
                    a.value * b.shift + b.value * a.shift + a.shift * b.shift, by,
                    b.known ? b.known->product : nullptr);
    product.size = a.size * b.size;
    if (by && a.size != 1) product.off += by->of(product.size);
    return product;
}

inline Counted abs(const Counted& x) { return x.value < 0 ? -x : x; }
inline bool lessThan(const Counted& a, const Counted& b) { return a.value < b.value; }
// With 0 as the second it is a flush, because kernels select nothing else during a step; the first one is kept, and may
// be off by what is stored as 0.
inline Counted mix(Counted a, const Counted& b, bool second) {
    if (second) return b;
    if (a.by && !b.by) a.off += a.by->flushed(a.size);
    return a;
}

} // namespace planner

namespace kernels {

struct counted {
    using real = planner::Counted;
    using scalar = planner::Counted;
#include "kernels/model.h"
};

} // namespace kernels

using kernels::counted;

} // namespace dermis
