// SPDX-License-Identifier: MIT
// Cubic splines through the numbers of a map.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace dermis::scene {

// How a map goes on beyond its border: it repeats itself, or is reflected (d c b a | a b c d | d c b a).
enum class Border { periodic, mirrored };

// Replaces each row of a map, and then each column, by what f makes of it; f may leave more numbers, which are dropped.
template <class F> void each_line(std::vector<double>& map, int width, int height, F&& f) {
    std::vector<double> line;
    const auto replace = [&](size_t first, size_t step, int count) {
        line.resize(size_t(count));
        for (size_t i = 0; i < size_t(count); ++i) line[i] = map[first + i * step];
        f(line);
        for (size_t i = 0; i < size_t(count); ++i) map[first + i * step] = line[i];
    };
    for (int y = 0; y < height; ++y) replace(size_t(y) * size_t(width), 1, width);
    for (int x = 0; x < width; ++x) replace(size_t(x), size_t(width), height);
}

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
