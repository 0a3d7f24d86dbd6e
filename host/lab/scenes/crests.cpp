// SPDX-License-Identifier: MIT
// Contact on the crests of the surface: of fingerprint ridges, whose grooves do not touch what is flat.
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/spline.hpp"

#include <algorithm>

namespace dermis::scene {

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
    constexpr double reach = 6; // standard deviations, beyond which 2e-9 of a Gaussian lies
    const double sigma = *s.load.contact_length / s.grid.spacing.value_or(1);
    std::vector<double> mean = over;
    each_line(mean, s.grid.width, s.grid.height, [&](auto& line) { line = smoothed(line, sigma, reach); });
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
