// SPDX-License-Identifier: MIT
// The traces of a result, where they peak, and what its numbers say about the skin.
#include "dermis/run.hpp"
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/press/report.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/waveform.hpp"

#include <cmath>

namespace dermis {
namespace {

constexpr double rounding = 1e-4; // A value below this share of the greatest has no sign.

// The least and the greatest value of a trace over all times and cells, and 0.
struct Extremes {
    double least = 0, greatest = 0;
    double size() const { return std::max(std::abs(least), std::abs(greatest)); }
    bool pulled() const { return least < -rounding * size(); }
    bool pressed() const { return greatest > rounding * size(); }
};

Extremes extremes_of(const Trace& t) {
    Extremes range;
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

// If all strains have one sign, only the curvature can give SA1 or SA2 the other sign. If also the strain is one map
// times a function of time, the rates of all cells have one sign at each time, and so have their accelerations.
std::vector<Quantity> sign_changed(const Scene& s, const Result& r) {
    std::vector<Quantity> changed;
    const Trace* strain = trace_with_extremes(r, Quantity::strain);
    if (!strain) return changed;
    const Extremes strains = extremes_of(*strain);
    if (strains.pulled() && strains.pressed()) return changed;
    const bool rectified = s.receptors.fa2_gains[0] != -s.receptors.fa2_gains[1];
    const bool product = scene::is_uniform(s.material) && !scene::is_framed(s.load) && !scene::is_sum(s);
    for (const scene::ReceptorClass& c : scene::receptor_classes) {
        const Trace* trace = trace_with_extremes(r, c.type);
        if (!trace) continue;
        const Extremes range = extremes_of(*trace);
        const bool sustained = c.type == Quantity::sa1 || c.type == Quantity::sa2;
        if (sustained ? (strains.pulled() ? range.pressed() : range.pulled())
                      : product && !(c.type == Quantity::fa2 && rectified) &&
                            both_signs_at_once(*trace, rounding * range.size()))
            changed.push_back(c.type);
    }
    return changed;
}

// The depth of a punch or a ball, m: the strain at its rim is not the depth over the thickness.
double greatest_depth(const Scene& s, const Result& r) {
    const scene::Waveform envelope(s.load.envelope, s.time);
    double greatest = 0;
    for (size_t n = 0; n < r.time.size(); ++n)
        greatest = std::max(greatest, std::abs(envelope.before(scene::Instant::multiple(double(n), s.time.step))));
    return std::abs(s.load.intensity) * greatest;
}

} // namespace

const Trace& Result::trace(Quantity q) const {
    return scene::guarded("a trace of a result", [&]() -> const Trace& {
        const auto t = std::ranges::find_if(traces, [q](auto& trace) { return trace.quantity == q; });
        if (t == traces.end())
            throw Error(Error::Code::bad_input, "output.traces",
                        std::string("output.traces has no \"") + name(q) + "\"; allowed: what the scene asked for");
        return *t;
    });
}

std::vector<TraceColumn> trace_columns(const Result& r) {
    std::vector<TraceColumn> columns;
    for (const Trace& t : r.traces)
        for (auto [statistic, values] : {std::pair{"_mean", &t.mean}, {"_min", &t.min}, {"_max", &t.max}})
            if (!values->empty()) columns.push_back({std::string(name(t.quantity)) + statistic, values});
    for (const Trace& t : r.traces)
        for (size_t p = 0; p < t.probes.size(); ++p)
            columns.push_back({std::string(name(t.quantity)) + "_probe" + std::to_string(p), &t.probes[p]});
    return columns;
}

std::vector<TraceOutcome> outcomes(const Result& r) {
    std::vector<TraceOutcome> all;
    for (const TraceColumn& column : trace_columns(r)) {
        const std::vector<double>& v = *column.values;
        const auto peak = std::ranges::max_element(v, {}, [](double x) { return std::abs(x); });
        if (peak == v.end()) continue;
        all.push_back({column.name + "_final", v.back()});
        all.push_back({column.name + "_peak", *peak});
        all.push_back({column.name + "_peak_time", r.time[size_t(peak - v.begin())]});
    }
    return all;
}

Report report(const Scene& s, const Result& r) {
    return scene::guarded("the report of a result", [&] {
        const DefaultFloats guard;
        Report report = report_of(s, {.min = r.tau_min, .max = r.tau_max}, r.cells_per_ridge, r.greatest_gain);
        report.fine_load.value = r.fine_load;
        if (const Trace* strain = trace_with_extremes(r, Quantity::strain)) {
            report.strain.value = extremes_of(*strain).size();
            if (s.grid.spacing) report.indentation.value = report.strain.value * s.material.thickness.value_or(0);
        }
        if (scene::is_indenter(s.load)) report.indentation.value = greatest_depth(s, r);
        report.sign_changed = sign_changed(s, r);
        if (s.load.interval) report.vibration.value = vibration_between(*s.load.interval);
        return report;
    });
}

} // namespace dermis
