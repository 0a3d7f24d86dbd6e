// SPDX-License-Identifier: MIT
#include "host/core/press/report.hpp"
#include "host/core/base/float_environment.hpp"

#include "host/core/base/memory.hpp"

#include <cmath>

namespace dermis {
namespace {

// Retardation times of skin, s: elastography finds 0.1 ms, and the contact of ridges settles within 20 s.
constexpr double shortest_time = 1e-4, longest_time = 20;
constexpr double fewest_cells_per_ridge = 8; // The five-point curvature of a sine is then 5 % too small.
constexpr double rounding = 1e-4;            // A value below this share of the greatest has no sign.

// The least and the greatest value of a trace over all times and cells, and 0.
struct Range {
    double least = 0, greatest = 0;
    double size() const { return std::max(std::abs(least), std::abs(greatest)); }
    bool pulled() const { return least < -rounding * size(); }
    bool pressed() const { return greatest > rounding * size(); }
};

Range range_of(const Trace& t) {
    Range range;
    for (const auto* column : {&t.min, &t.max})
        for (double v : *column) {
            range.least = std::min(range.least, v);
            range.greatest = std::max(range.greatest, v);
        }
    return range;
}

// Returns the trace where it has extremes, else null.
const Trace* trace_with_extremes(const Result& r, Quantity q) {
    for (const Trace& t : r.traces)
        if (t.quantity == q && !t.min.empty()) return &t;
    return nullptr;
}

// Returns whether the least and the greatest value of one output have different signs.
bool both_signs_at_once(const Trace& t, double size) {
    for (size_t n = 0; n < t.min.size(); ++n)
        if (t.min[n] < -size && t.max[n] > size) return true;
    return false;
}

// Strains of one sign leave the other sign of SA1 and SA2 to the curvature. Where besides the strain is one map times a
// function of time, all cells' rates have one sign at a time, and so have their accelerations.
std::vector<Quantity> sign_changed(const Scene& s, const Result& r) {
    std::vector<Quantity> changed;
    const Trace* strain = trace_with_extremes(r, Quantity::strain);
    if (!strain) return changed;
    const Range strains = range_of(*strain);
    if (strains.pulled() && strains.pressed()) return changed;
    const bool rectified = s.receptors.fa2_gains[0] != -s.receptors.fa2_gains[1];
    const bool product = scene::is_uniform(s.material) && s.load.kind != Load::Kind::sequence;
    for (const scene::ReceptorClass& c : scene::receptor_classes) {
        const Trace* trace = trace_with_extremes(r, c.type);
        if (!trace) continue;
        const Range range = range_of(*trace);
        const bool sustained = c.type == Quantity::sa1 || c.type == Quantity::sa2;
        if (sustained ? (strains.pulled() ? range.pressed() : range.pulled())
                      : product && !(c.type == Quantity::fa2 && rectified) &&
                            both_signs_at_once(*trace, rounding * range.size()))
            changed.push_back(c.type);
    }
    return changed;
}

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

Report report(const Scene& s, const Result& r) try {
    const DefaultFloats guard;
    Report report = report_of(s, {.min = r.tau_min, .max = r.tau_max}, r.cells_per_ridge, r.greatest_gain);
    if (const Trace* strain = trace_with_extremes(r, Quantity::strain)) {
        report.strain.value = range_of(*strain).size();
        if (s.grid.spacing) report.indentation.value = report.strain.value * s.material.thickness.value_or(0);
    }
    report.sign_changed = sign_changed(s, r);
    return report;
} catch (const std::bad_alloc&) {
    scene::out_of_memory([] { return "the report of a result"; });
}

} // namespace dermis
