// SPDX-License-Identifier: MIT
// Expected values with a tolerance: CHECK(x == relative(0.8, 1e-12)).
// doctest::Approx adds 1 to the greater magnitude before it multiplies by the tolerance: it checks little of a value
// well below 1, and nothing of a value below the tolerance.
#pragma once

#include <doctest/doctest.h>

#include <cmath>

namespace test {

struct Expected {
    double value;
    double tolerance;              // the greatest difference
    mutable double difference = 0; // of the last comparison, for the message of a failure
};

// A value of 0 is met by 0 alone, and one that is not finite by itself alone: neither has a relative difference.
inline Expected relative(double value, double tolerance) { return {value, tolerance * std::abs(value)}; }

// For a value that is 0, passes through 0, or is what is left of greater ones that cancel: the tolerance has its unit.
inline Expected absolute(double value, double tolerance) { return {value, tolerance}; }

inline bool operator==(double x, const Expected& e) {
    e.difference = x - e.value;
    return x == e.value || (std::isfinite(e.value) && std::abs(e.difference) <= e.tolerance);
}

inline doctest::String toString(const Expected& e) {
    return doctest::toString(e.value) + " +- " + doctest::toString(e.tolerance) + ", off by " +
           doctest::toString(e.difference);
}

} // namespace test
