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
    for (double t : times)
        report.retardation_times.push_back(units ? Figure{.value = t, .least = shortest_time, .greatest = longest_time}
                                                 : Figure{.value = t});
    return report;
}

} // namespace dermis
