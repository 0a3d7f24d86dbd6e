// SPDX-License-Identifier: MIT
// Cubic splines through the numbers of a map.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace dermis::scene {

// How a map goes on beyond its border: it repeats itself, or is reflected (d c b a | a b c d | d c b a).
enum class Border { periodic, mirrored };

// Replaces the numbers of a map by the coefficients of the cubic spline that runs through them.
void to_spline(std::vector<double>& map, int width, int height, Border);

// The four spline coefficients around a place along an axis, and their weights. Number i lies at the place i.
struct SplineTaps {
    long long first;
    double weights[4];
};
inline SplineTaps spline_taps(double place) {
    const double whole = std::floor(place), t = place - whole, u = 1 - t;
    return {static_cast<long long>(whole) - 1,
            {u * u * u / 6, 2.0 / 3 - t * t * (2 - t) / 2, 2.0 / 3 - u * u * (2 - u) / 2, t * t * t / 6}};
}

// The index along an axis of n numbers at which a map that goes on has its number i.
inline size_t index_beyond(long long i, int n, Border border) {
    const long long period = border == Border::periodic ? n : 2LL * n, at = ((i % period) + period) % period;
    return size_t(at < n ? at : period - 1 - at);
}

} // namespace dermis::scene
