// SPDX-License-Identifier: MIT
// This file computes the numbers and verdicts of claims.md. Their text is claims.md.in.
#include "host/lab/study/fields.hpp"
#include "host/lab/study/study.hpp"

#include "claims_template.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

namespace dermis::study {
namespace {

constexpr size_t last = 999;
constexpr double spiral_period = 2 * std::numbers::pi * 150 / 25; // cells between ridges of the study's spiral

double percent(double value, double reference) { return 100 * (value / reference - 1); }

const std::vector<double>& mean(const StudyRuns& runs, std::string_view folder, Quantity q) {
    return runs.at(std::string(folder)).result.trace(q).mean;
}

void displacement(const StudyRuns& runs, Fields& fields) {
    std::map<std::string, double> greatest, average;
    for (const std::string load : {"circular", "linear", "point"}) {
        const StudyRun& run = runs.at("published/flat_" + load);
        const Trace& strain = run.result.trace(Quantity::strain);
        double force = 0;
        for (double v : maps(run.scene).pressure) force += v;
        greatest[load] = strain.max[last];
        average[load] = strain.mean[last];
        const bool point = load == "point"; // its values are small
        fields.set("strain_" + load + "_max", point ? "{:.5f}" : "{:.4f}", greatest[load]);
        fields.set("strain_" + load + "_mean", point ? "{:.2e}" : "{:.4f}", average[load]);
        fields.set("force_" + load, point ? "{:.3f}" : "{:.0f}", force);
        fields.set("strain_per_force_" + load, "{:.3e}", average[load] / force);
    }
    fields.verdict("circular_and_linear_alike", std::abs(percent(greatest["circular"], greatest["linear"])) < 1 &&
                                                    average["linear"] > average["circular"]);
    fields.verdict("point_least", greatest["point"] < greatest["circular"]);

    const std::vector<double>& curvature = runs.at("exact/flat_circular").result.fields[1].values;
    const auto [low, high] = std::minmax_element(curvature.begin(), curvature.end());
    fields.set("flat_curvature_min", "{:.4f}", *low);
    fields.set("flat_curvature_max", "{:.4f}", *high);
    fields.verdict("flat_uncurved", *high < 1e-12);
}

// A Reading is SA1 at the end of the circular load. `plotted` is the average of five points as the study's plots take
// it; `mean` and `rms` are over the pressed cells.
struct Reading {
    double plotted = 0, points = 0, mean = 0, rms = 0;
};

Reading read(const StudyRun& run) {
    constexpr double plotted_weights[] = {1 / 3125., 1 / 625., 1 / 125., 1 / 25., 1 / 5.};
    Reading r;
    for (int p = 0; p < 5; ++p) {
        const double v = run.result.trace(Quantity::sa1).probes[p][last];
        r.plotted += plotted_weights[p] * v;
        r.points += v / 5;
    }
    const std::vector<double> pressure = maps(run.scene).pressure;
    const auto sa1 = std::ranges::find_if(run.result.fields, [](auto& f) { return f.quantity == Quantity::sa1; });
    double cells = 0;
    for (size_t i = 0; i < pressure.size(); ++i)
        if (pressure[i] > 0) {
            cells += 1;
            r.mean += sa1->values[i];
            r.rms += sa1->values[i] * sa1->values[i];
        }
    r.mean /= cells;
    r.rms = std::sqrt(r.rms / cells);
    return r;
}

void set_pressed_cells(Fields& fields, const std::string& run, const Reading& r, const Reading& flat) {
    fields.set(run + "_mean", "{:.5f}", r.mean);
    fields.set(run + "_mean_change", "{:+.3f}", percent(r.mean, flat.mean));
    fields.set(run + "_rms", "{:.5f}", r.rms);
    fields.set(run + "_rms_change", "{:+.2f}", percent(r.rms, flat.rms));
}

void amplification(const StudyRuns& runs, Fields& fields) {
    std::map<std::string, Reading> readings;
    for (const std::string method : {"published", "exact"})
        for (const std::string surface : {"flat", "wave", "spiral"}) {
            const std::string run = method + "_" + surface;
            const Reading& r = readings[run] = read(runs.at(method + "/" + surface + "_circular"));
            const Reading& flat = readings[method + "_flat"];
            fields.set(run + "_plotted", "{:.6f}", r.plotted);
            fields.set(run + "_plotted_change", "{:+.2f}", percent(r.plotted, flat.plotted));
            fields.set(run + "_points", "{:.5f}", r.points);
            fields.set(run + "_points_change", "{:+.2f}", percent(r.points, flat.points));
            set_pressed_cells(fields, run, r, flat);
        }
    const Reading &flat = readings["published_flat"], &wave = readings["published_wave"],
                  &spiral = readings["published_spiral"];
    fields.set("points_over_plotted", "{:.1f}", flat.points / flat.plotted);
    fields.verdict("spiral_amplifies", spiral.mean > 1.01 * flat.mean);
    fields.verdict("spiral_above_wave", spiral.plotted > wave.plotted && spiral.points > wave.points &&
                                            spiral.mean > wave.mean && spiral.rms > wave.rms);
}

// Runs a wave or spiral without noise, with the given cells from ridge to ridge.
StudyRun at_period(Surface::Kind kind, double cells) {
    Scene s = study_scene(kind, Load::Kind::circular, Method::exact);
    s.surface.ridges = (kind == Surface::Kind::wave ? 1 : 2 * std::numbers::pi) * s.grid.width / cells;
    s.surface.noise = 0;
    return {s, in_double(s)};
}

void equal_periods(const StudyRuns& runs, Fields& fields) {
    const Reading flat = read(runs.at("exact/flat_circular"));
    for (auto [period, cells] : {std::pair<std::string, double>{"10", 10.0}, {"spiral", spiral_period}})
        for (auto [surface, kind] : {std::pair{"wave", Surface::Kind::wave}, {"spiral", Surface::Kind::spiral}})
            set_pressed_cells(fields, fmt::format("period_{}_{}", period, surface), read(at_period(kind, cells)), flat);
    fields.set("spiral_period", "{:.1f}", spiral_period);
}

// These are the means of the curvature at rest on crests (S > 0.8) and in valleys (S < 0.2), and its rms.
struct RestCurvature {
    double crest = 0, valley = 0, rms = 0;
};

RestCurvature rest_curvature(Surface::Kind kind) {
    const SceneMaps m = maps(study_scene(kind, Load::Kind::circular, Method::exact));
    double crest = 0, crests = 0, valley = 0, valleys = 0, squares = 0;
    for (size_t i = 0; i < m.surface.size(); ++i) {
        if (m.surface[i] > 0.8) crest += m.rest_curvature[i], ++crests;
        if (m.surface[i] < 0.2) valley += m.rest_curvature[i], ++valleys;
        squares += m.rest_curvature[i] * m.rest_curvature[i];
    }
    return {crest / crests, valley / valleys, std::sqrt(squares / double(m.surface.size()))};
}

void curvature_at_rest(Fields& fields) {
    const RestCurvature wave = rest_curvature(Surface::Kind::wave), spiral = rest_curvature(Surface::Kind::spiral);
    for (const auto& [surface, c] : {std::pair<std::string, RestCurvature>{"wave", wave}, {"spiral", spiral}}) {
        fields.set(surface + "_crest_curvature", "{:+.4f}", c.crest);
        fields.set(surface + "_valley_curvature", "{:+.4f}", c.valley);
        fields.set(surface + "_rms_curvature", "{:.4f}", c.rms);
    }
    fields.verdict("crests_positive", wave.crest > 0 && spiral.crest > 0);
    fields.verdict("spiral_more_curved", spiral.rms > wave.rms);
}

void sustained_and_transient(const StudyRuns& runs, Fields& fields) {
    const auto& sa1 = mean(runs, "exact/wave_circular", Quantity::sa1);
    fields.set("sa1_at_5", "{:.5f}", sa1[500]);
    fields.set("sa1_end", "{:.5f}", sa1[last]);
    fields.verdict("sa1_settles", std::abs(sa1[last] / sa1[500] - 1) < 1e-3);

    const auto& sa2 = mean(runs, "exact/wave_circular", Quantity::sa2);
    fields.set("sa2_slope_end", "{:.5f}", (sa2[last] - sa2[899]) / 1.0);
    fields.set("sa2_end", "{:.4f}", sa2[last]);
    fields.verdict("sa2_climbs", sa2[last] > sa2[899] * 1.05);

    const auto& fa1 = mean(runs, "exact/wave_circular", Quantity::fa1);
    fields.set("fa1_first", "{:.5f}", fa1[1]);
    fields.set("fa1_end", "{:.1e}", fa1[last]);
    fields.verdict("fa1_peaks_first", *std::max_element(fa1.begin(), fa1.end()) == fa1[1] && fa1[last] < 1e-5 * fa1[1]);

    const auto& fa2 = mean(runs, "published/wave_circular", Quantity::fa2);
    const auto decayed =
        std::find_if(fa2.begin() + 2, fa2.end(), [&](double v) { return std::abs(v) < 0.01 * std::abs(fa2[2]); });
    fields.set("fa2_published_first", "{:+.4f}", fa2[1]);
    fields.set("fa2_published_second", "{:+.5f}", fa2[2]);
    fields.set("fa2_published_decayed", "{:.2f}", 0.01 * double(decayed - fa2.begin()));
    fields.verdict("fa2_returns_sharply", decayed - fa2.begin() < 10); // a tenth of a second
}

// A Sweep gives the means over all cells in the runs of a sweep, one value of the material after the other.
class Sweep {
  public:
    Sweep(const StudyRuns& runs, const char* folder, std::vector<std::string> values)
        : runs_(runs), folder_(folder), values_(std::move(values)) {}

    const std::vector<double>& mean(const std::string& value, Quantity q, Method m) const {
        return study::mean(runs_, fmt::format("{}/{}/{}", folder_, value, name(m)), q);
    }
    std::string list(Quantity q, size_t output, const char* format, Method m = Method::exact) const {
        std::string text;
        for (const std::string& v : values_)
            text += (text.empty() ? "" : ", ") + fmt::format(fmt::runtime(format), mean(v, q, m)[output]);
        return text;
    }
    // Whether the size of a mean falls from each value to the next.
    bool falls(Quantity q, size_t output) const {
        const auto size = [&](size_t i) { return std::abs(mean(values_[i], q, Method::exact)[output]); };
        for (size_t i = 1; i < values_.size(); ++i)
            if (!(size(i) < size(i - 1))) return false;
        return true;
    }
    const std::vector<std::string>& values() const { return values_; }

  private:
    const StudyRuns& runs_;
    std::string folder_;
    std::vector<std::string> values_;
};

// Returns the first output from which on the values stay within 1 % of the last one.
size_t settled(const std::vector<double>& values) {
    size_t n = values.size();
    while (n > 0 && std::abs(values[n - 1] - values[last]) <= 0.01 * std::abs(values[last])) --n;
    return n;
}

// Sets the times at which mean SA1 has settled, one modulus after the other. Returns whether they fall.
bool settling_falls(const Sweep& sweep, Fields& fields) {
    std::vector<double> times;
    for (const std::string& v : sweep.values())
        times.push_back(0.01 * double(settled(sweep.mean(v, Quantity::sa1, Method::exact))));
    fields.set("modulus_sa1_settled", fmt::format("{:.2f}", fmt::join(times, ", ")));
    return std::is_sorted(times.rbegin(), times.rend()) && times.front() > times.back();
}

// Whether the first FA2 of all values of the sweep is the same to 2 %.
bool same_first_fa2(const Sweep& sweep, Method method) {
    double low = INFINITY, high = 0;
    for (const std::string& v : sweep.values()) {
        const double first = std::abs(sweep.mean(v, Quantity::fa2, method)[1]);
        low = std::min(low, first);
        high = std::max(high, first);
    }
    return high < 1.02 * low;
}

// How often the mean rate of strain changes its sign in the runs of the sweep, as it would in an oscillation.
int sign_changes(const Sweep& sweep) {
    int changes = 0;
    for (const std::string& v : sweep.values()) {
        const std::vector<double>& fa1 = sweep.mean(v, Quantity::fa1, Method::exact);
        for (size_t n = 2; n <= last; ++n) changes += fa1[n] * fa1[n - 1] < 0;
    }
    return changes;
}

void modulus(const Sweep& sweep, Fields& fields) {
    fields.set("modulus_sa1_end", sweep.list(Quantity::sa1, last, "{:.4f}"));
    fields.verdict("modulus_lowers_sa1", sweep.falls(Quantity::sa1, last));
    fields.verdict("modulus_settles_sooner", settling_falls(sweep, fields));
    fields.set("modulus_sa2_end", sweep.list(Quantity::sa2, last, "{:.4f}"));
    fields.verdict("modulus_lowers_sa2", sweep.falls(Quantity::sa2, last));
    fields.set("modulus_fa1_first", sweep.list(Quantity::fa1, 1, "{:.5f}"));
    fields.set("modulus_fa1_at_1", sweep.list(Quantity::fa1, 100, "{:.5f}"));
    fields.verdict("modulus_lowers_fa1_at_1", sweep.falls(Quantity::fa1, 100));
    fields.set("modulus_fa2_published_first", sweep.list(Quantity::fa2, 1, "{:.4f}", Method::published));
    fields.set("modulus_fa2_exact_first", sweep.list(Quantity::fa2, 1, "{:.4f}"));
    fields.verdict("modulus_same_spike", same_first_fa2(sweep, Method::published));
    fields.verdict("modulus_same_density", same_first_fa2(sweep, Method::exact));
    fields.set("modulus_sign_changes", std::to_string(sign_changes(sweep)));
    fields.verdict("skin_oscillates", sign_changes(sweep) > 0);
}

void viscosity(const Sweep& sweep, Fields& fields) {
    fields.set("viscosity_sa1_at_0.5", sweep.list(Quantity::sa1, 50, "{:.4f}"));
    fields.set("viscosity_sa1_end", sweep.list(Quantity::sa1, last, "{:.4f}"));
    fields.verdict("viscosity_lowers_sa1_at_0.5", sweep.falls(Quantity::sa1, 50));
    fields.set("viscosity_sa2_end", sweep.list(Quantity::sa2, last, "{:.4f}"));
    fields.verdict("viscosity_lowers_sa2", sweep.falls(Quantity::sa2, last));
    fields.set("viscosity_fa1_first", sweep.list(Quantity::fa1, 1, "{:.4f}"));
    fields.set("viscosity_fa1_at_1", sweep.list(Quantity::fa1, 100, "{:.1e}"));
    fields.verdict("viscosity_lowers_fa1_first", sweep.falls(Quantity::fa1, 1));
    fields.set("viscosity_fa2_first", sweep.list(Quantity::fa2, 1, "{:.4f}"));
    fields.verdict("viscosity_lowers_fa2_size", sweep.falls(Quantity::fa2, 1));
    const auto negative = [&](const std::string& v) { return sweep.mean(v, Quantity::fa2, Method::exact)[1] < 0; };
    fields.verdict("viscosity_fa2_negative", std::ranges::all_of(sweep.values(), negative));
}

void negative_values(const Sweep& sweep, Fields& fields) {
    bool all = true;
    for (const std::string& v : sweep.values()) {
        const auto& published = sweep.mean(v, Quantity::fa2, Method::published);
        const auto& exact = sweep.mean(v, Quantity::fa2, Method::exact);
        const auto negative = [](const std::vector<double>& t) {
            return std::count_if(t.begin() + 2, t.begin() + 101, [](double x) { return x < 0; });
        };
        fields.set("negative_published_" + v, std::to_string(negative(published)));
        fields.set("negative_exact_" + v, std::to_string(negative(exact)));
        fields.set("second_over_first_" + v, "{:.3f}", published[2] / published[1]);
        all &= negative(published) == 99 && negative(exact) == 99;
    }
    fields.verdict("fa2_not_always_negative", !all);
}

void adapted_sa2(const StudyRuns& runs, Fields& fields) {
    Scene s = study_scene(Surface::Kind::wave, Load::Kind::circular, Method::exact);
    s.receptors.sa2_adaptation = 1;
    const auto bounded = in_double(s).trace(Quantity::sa2).mean;
    fields.set("adapted_sa2_at_5", "{:.5f}", bounded[500]);
    fields.set("adapted_sa2_end", "{:.5f}", bounded[last]);

    s.receptors.sa2_adaptation = 1e6;
    const auto slow = in_double(s).trace(Quantity::sa2).mean;
    const auto& plain = mean(runs, "exact/wave_circular", Quantity::sa2);
    double worst = 0;
    for (size_t n = 0; n <= last; ++n) worst = std::max(worst, std::abs(slow[n] - plain[n]));
    fields.set("slow_sa2_difference", "{:.1e}", worst);
}

void spike(Fields& fields) {
    for (double step : {0.02, 0.01, 0.005, 0.001}) {
        Scene s = study_scene(Surface::Kind::flat, Load::Kind::circular, Method::published);
        s.output.fields.clear();
        s.time = {step, 10 * step};
        const double published = in_double(s).trace(Quantity::fa2).probes[0][1];
        s.method = Method::exact;
        const Result exact = in_double(s);
        const std::string row = fmt::format("spike_{}", step);
        fields.set(row + "_published", "{:.3f}", published);
        fields.set(row + "_times_step", "{:.4f}", published * step);
        fields.set(row + "_density", "{:.4f}", exact.trace(Quantity::fa2).probes[0][1]);
        fields.set(row + "_impulse", "{:.4f}", exact.impulses[0].probes[0]);
    }
}

// Returns the greatest difference over the five points from output `first` on, in percent of the greatest value of `b`.
double distance(const Result& a, const Result& b, Quantity q, size_t first) {
    double worst = 0, largest = 0;
    for (int p = 0; p < 5; ++p)
        for (size_t n = first; n < last; ++n) {
            worst = std::max(worst, std::abs(a.trace(q).probes[p][n] - b.trace(q).probes[p][n]));
            largest = std::max(largest, std::abs(b.trace(q).probes[p][n]));
        }
    return 100 * worst / largest;
}

// Compares the curvature after the last step by the two stencils, in the interior and on the two outermost cells, where
// the published rows are inconsistent.
void curvature_difference(const Result& published_stencil, const Result& exact, Fields& fields) {
    double inside = 0, edge = 0, square = 0;
    for (int y = 0; y < 150; ++y)
        for (int x = 0; x < 150; ++x) {
            const size_t i = size_t(y) * 150 + x;
            const double value = exact.fields[1].values[i];
            double& worst = std::min({x, y, 149 - x, 149 - y}) < 2 ? edge : inside;
            worst = std::max(worst, std::abs(published_stencil.fields[1].values[i] - value));
            square += value * value / 22500;
        }
    fields.set("curvature_rms", "{:.3f}", std::sqrt(square));
    fields.set("curvature_difference_inside", "{:.3f}", inside);
    fields.set("curvature_difference_edge", "{:.3f}", edge);
}

void published_error(const StudyRuns& runs, Fields& fields) {
    Scene s = study_scene(Surface::Kind::wave, Load::Kind::circular, Method::exact);
    s.stencil = Stencil::published;
    s.edges = Edges::published;
    const Result stencil = in_double(s);
    const Result &exact = runs.at("exact/wave_circular").result, &published = runs.at("published/wave_circular").result;
    for (Quantity q : {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2}) {
        const size_t first = q == Quantity::fa2 ? 2 : 1; // the first value of FA2 is the spike
        const std::string row = fmt::format("{}_error", name(q));
        fields.set(row + "_both", "{:.3f}", distance(published, exact, q, first));
        fields.set(row + "_stepping", "{:.3f}", distance(published, stencil, q, first));
        fields.set(row + "_stencil", "{:.3f}", distance(stencil, exact, q, first));
    }
    curvature_difference(stencil, exact, fields);
    fields.set("euler_strain_theory", "{:.3f}", 100 * 0.0154 / (2 * std::numbers::e));
}

void printed_units(Fields& fields) {
    Scene s = study_scene(Surface::Kind::flat, Load::Kind::circular, Method::exact);
    s.material.modulus = 1.54e6;
    fields.set("printed_tau", "{:.3g}", 1 / 1.54e6);
    fields.set("printed_z", "{:.0f}", 0.01 * 1.54e6);
    fields.set("printed_exact_strain", "{:.16g}", in_double(s).trace(Quantity::strain).max[1] * 1.54e6);
    std::string refusal = "runs";
    s.method = Method::euler;
    try {
        in_double(s);
    } catch (const Error& e) {
        refusal = e.what();
    }
    fields.set("printed_euler_refusal", refusal);
}

// Returns the template without the comment at its head, which is for its editors.
std::string_view text_of_template() {
    const std::string_view text = claims_template, end_of_comment = "-->\n";
    const size_t end = text.find(end_of_comment);
    if (end == text.npos) throw std::logic_error("claims.md.in has no comment at its head");
    return text.substr(end + end_of_comment.size());
}

} // namespace

std::string claims(const StudyRuns& runs) {
    Fields fields;
    displacement(runs, fields);
    amplification(runs, fields);
    equal_periods(runs, fields);
    curvature_at_rest(fields);
    sustained_and_transient(runs, fields);
    modulus({runs, "sweep_modulus", {"1", "1.25", "1.5", "1.75", "2"}}, fields);
    const Sweep viscosities(runs, "sweep_viscosity", {"0.1", "0.325", "0.55", "0.775", "1"});
    viscosity(viscosities, fields);
    negative_values(viscosities, fields);
    adapted_sa2(runs, fields);
    spike(fields);
    published_error(runs, fields);
    printed_units(fields);
    return fields.filled_in(text_of_template());
}

} // namespace dermis::study
