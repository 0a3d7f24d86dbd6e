// SPDX-License-Identifier: MIT
// Points in time with twice the digits of a double: at late times, differences between outputs and breakpoints, and the
// phase of a vibration, would otherwise be rounded away.
#pragma once

#include <cmath>

namespace dermis::scene {

// The time t + rest, s; |rest| is at most half a unit in the last place of t.
struct Instant {
    double t = 0, rest = 0;

    Instant() = default;
    Instant(double time) : t(time) {}
    Instant(double time, double remainder) : t(time + remainder), rest((time - t) + remainder) {}

    // n*step without rounding.
    static Instant multiple(double n, double step) {
        const double product = n * step;
        return {product, std::fma(n, step, -product)};
    }

    friend Instant operator+(const Instant& a, double b) {
        const double sum = a.t + b, part = sum - a.t;
        return {sum, (a.t - (sum - part)) + (b - part) + a.rest};
    }
    friend double operator-(const Instant& a, const Instant& b) { return (a.t - b.t) + (a.rest - b.rest); }
    friend bool operator==(const Instant& a, const Instant& b) { return a.t == b.t && a.rest == b.rest; }
    friend bool operator<(const Instant& a, const Instant& b) { return a.t < b.t || (a.t == b.t && a.rest < b.rest); }
    friend bool operator<=(const Instant& a, const Instant& b) { return !(b < a); }
};

// a - b in T, double or long double.
template <class T> T difference(const Instant& a, const Instant& b) { return (T(a.t) - b.t) + (T(a.rest) - b.rest); }

// Returns the multiple of `step` that is within a few units in the last place of `time`, or else `time`.
inline Instant snapped(const Instant& time, double step) {
    const Instant output = Instant::multiple(std::round(time.t / step), step);
    return std::abs(time - output) <= 4 * 0x1p-52 * time.t ? output : time;
}

} // namespace dermis::scene
