// SPDX-License-Identifier: MIT
// Skins, pressures and answers of them that several suites ask for.
#pragma once

#include "dermis/dermis.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstring>
#include <span>
#include <vector>

namespace test {

using namespace dermis;

inline constexpr Quantity all_responses[] = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};

// Wave ridges under a circular load, small and quick.
Scene small_scene(int width, int height);
// A skin of such ridges.
SkinDescription ridged(int width, int height);
// Ridges of a fingertip 1 mm thick; spacing of cells in m.
SkinDescription finger(int width, int height, double spacing = 5e-4);
// A square of flat fingertip, pressed by depth, probed in its middle.
Scene flat_finger(int cells, double spacing);
// A flat strip of 50 x 8 cells of 0.1 mm, evenly loaded: what a grating or texture moves over.
Scene flat_strip(double step, double duration);
SkinDescription with_sites(SkinDescription, int count);
// A modulus for each cell.
SkinDescription with_materials(SkinDescription);
// Three elements in series, of which the second has the moduli of the given skin, a spring and a dashpot.
SkinDescription with_chain(SkinDescription);

// The nth pressure on such a skin, width*height.
std::vector<float> frame(const SkinDescription&, int n);
// Pressures n, n + 1, .., of as many pads.
std::vector<float> frames_of(const SkinDescription&, int n, size_t pads);

// The responses of all pads, one quantity after the other.
std::vector<float> answers(const Skin&, std::span<const Quantity> = all_responses);
inline std::vector<float> answers(const Skin& skin, Quantity q) { return answers(skin, {&q, 1}); }
std::vector<Spike> spikes_of(const Skin&);

// The sum in double, in order, and the greatest magnitude; a map or a vector.
double sum_of(const auto& values) {
    double sum = 0;
    for (double v : values) sum += v;
    return sum;
}
double greatest_of(const auto& values) {
    double most = 0;
    for (double v : values) most = std::max(most, std::abs(v));
    return most;
}

// Whether these are the same bits, or NaN in both.
template <class T> bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return std::ranges::equal(a, b, [](const T& x, const T& y) {
        if constexpr (std::floating_point<T>)
            if (std::isnan(x) && std::isnan(y)) return true;
        return std::memcmp(&x, &y, sizeof x) == 0;
    });
}

} // namespace test
