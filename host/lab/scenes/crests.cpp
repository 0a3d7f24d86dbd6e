// SPDX-License-Identifier: MIT
// Contact on the crests of the surface: of fingerprint ridges, whose grooves do not touch what is flat.
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/scene.hpp"

#include <algorithm>

namespace dermis::scene {
namespace {

// Smooths the rows of a map, then its columns.
std::vector<double> smoothed_map(const std::vector<double>& map, const Grid& grid, double sigma) {
    constexpr double reach = 6; // standard deviations, beyond which 2e-9 of a Gaussian lies
    const size_t width = size_t(grid.width), height = size_t(grid.height);
    std::vector<double> smooth(map.size()), line;
    for (size_t y = 0; y < height; ++y) {
        line.assign(map.begin() + long(y * width), map.begin() + long((y + 1) * width));
        std::ranges::copy(smoothed(line, sigma, reach), smooth.begin() + long(y * width));
    }
    line.resize(height);
    for (size_t x = 0; x < width; ++x) {
        for (size_t y = 0; y < height; ++y) line[y] = smooth[y * width + x];
        line = smoothed(line, sigma, reach);
        for (size_t y = 0; y < height; ++y) smooth[y * width + x] = line[y];
    }
    return smooth;
}

} // namespace

Map crest_factors(const Scene& s, const std::vector<double>& heights) {
    std::vector<double> sorted = heights, over = heights;
    const auto at = sorted.begin() + long((1 - s.load.contact_share) * double(sorted.size() - 1));
    std::ranges::nth_element(sorted, at);
    double level = *at;
    const double top = std::ranges::max(heights);
    if (level == top) // more cells share the greatest height: all of them are crests
        for (level = std::ranges::min(heights); double h : heights)
            if (h < top) level = std::max(level, h);
    if (level == top) refuse("load.contact", "\"crests\"", "\"even\" on a flat surface");
    for (double& v : over) v = std::max(0.0, v - level);
    const std::vector<double> mean = smoothed_map(over, s.grid, *s.load.contact_length / s.grid.spacing.value_or(1));
    for (size_t i = 0; i < over.size(); ++i)
        if (over[i] > 0) over[i] /= mean[i];
    if (!s.load.texture) return over;
    // Scaled frame by frame, a texture would lose what it does to all crests at once.
    const Map map = shape_of(s);
    double before = 0, after = 0;
    for (size_t i = 0; i < over.size(); ++i) before += map[i], after += map[i] * over[i];
    for (double& factor : over)
        if (after != 0) factor *= before / after;
    return over;
}

void press_crests(const Load& load, const Map& factors, int width, double unit, std::vector<double>& pressure) {
    double before = 0, after = 0;
    for (size_t i = 0; i < pressure.size(); ++i) {
        if (pressure[i] * unit < 0)
            refuse("load.contact", "\"crests\"", "\"even\" where a cell is pulled, as " + cell_text(i, width) + " is");
        before += pressure[i];
        after += pressure[i] *= factors[i];
    }
    for (double& p : pressure)
        if (after != 0 && !load.texture) p *= before / after;
}

} // namespace dermis::scene
