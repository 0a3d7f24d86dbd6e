// SPDX-License-Identifier: MIT
#include "host/core/press/report.hpp"

#include <cmath>

namespace dermis {
namespace {

// Retardation times of skin, s: elastography finds 0.1 ms, and the contact of ridges settles within 20 s.
constexpr double shortest_time = 1e-4, longest_time = 20;
constexpr double fewest_cells_per_ridge = 8; // The five-point curvature of a sine is then 5 % too small.

} // namespace

Report report_of(const SkinDescription& s, scene::TauRange tau, double cells_per_ridge, double gain) {
    const bool units = s.grid.spacing.has_value();
    std::vector<double> times = {tau.min, tau.max};
    if (scene::is_chain(s.material) && scene::is_uniform(s.material)) {
        times.clear();
        for (const scene::Element& e : scene::chain_of(s.material)) times.push_back(e.viscosity / e.modulus);
    }
    std::erase_if(times, [](double t) { return !(t > 0 && std::isfinite(t)); });
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    Report report;
    report.strain.greatest = units ? 1 : HUGE_VAL;
    report.indentation.greatest = units ? s.material.thickness.value_or(HUGE_VAL) : HUGE_VAL;
    report.gain = {.value = gain, .greatest = 1};
    report.cells_per_ridge = {.value = cells_per_ridge, .least = fewest_cells_per_ridge};
    report.fine_load.greatest = scene::has_depth(s.receptors) ? 1 : 0.1;
    for (double t : times)
        report.retardation_times.push_back(units ? Figure{.value = t, .least = shortest_time, .greatest = longest_time}
                                                 : Figure{.value = t});
    return report;
}

double fine_load_of(const SkinDescription& s, const std::vector<double>& pressure) {
    if (!s.grid.spacing) return std::nan("");
    const Depths depths = scene::has_depth(s.receptors) ? s.receptors.depth : fingertip_depths();
    double deepest = 0;
    for (const auto& c : scene::receptor_classes) deepest = std::max(deepest, (depths.*c.depth).value_or(0));
    const int w = s.grid.width, h = s.grid.height;
    const int reach = int(std::min(std::round(deepest / *s.grid.spacing), double(std::max(w, h)))); // cells
    std::vector<double> sums(size_t(w + 1) * size_t(h + 1));
    const auto before = [&](int x, int y) -> double& { return sums[size_t(y) * size_t(w + 1) + size_t(x)]; };
    const double* p = pressure.data();
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) before(x + 1, y + 1) = *p++ + before(x, y + 1) + (before(x + 1, y) - before(x, y));
    double all = 0, even = 0;
    p = pressure.data();
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x, ++p) {
            const int left = std::max(x - reach, 0), right = std::min(x + reach + 1, w), low = std::max(y - reach, 0),
                      high = std::min(y + reach + 1, h);
            const double sum = before(right, high) - before(left, high) - (before(right, low) - before(left, low)),
                         mean = sum / (double(right - left) * (high - low));
            all += std::abs(*p);
            even += std::abs(std::clamp(mean, std::min(*p, 0.0), std::max(*p, 0.0)));
        }
    return 1 - even / all;
}

} // namespace dermis
