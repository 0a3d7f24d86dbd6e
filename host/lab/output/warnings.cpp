// SPDX-License-Identifier: MIT
#include "host/lab/output/output.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/ranges.h>

namespace dermis::output {
namespace {

using Sentences = std::vector<std::string>;

// The greatest |curvature| of a measured surface in the two outermost cells and further in, 1/m.
std::pair<double, double> curvature_at_border(const Scene& s) {
    double at_border = 0, within = 0;
    for (int i = 0; i < int(s.surface.curvature.size()); ++i) {
        const int x = i % s.grid.width, y = i / s.grid.width;
        const bool border = std::min({x, y, s.grid.width - 1 - x, s.grid.height - 1 - y}) < 2;
        double& greatest = border ? at_border : within;
        greatest = std::max(greatest, std::abs(s.surface.curvature[size_t(i)] * s.surface.relief.value_or(1)));
    }
    return {at_border, within};
}

void add_curvature(Sentences& all, const Scene& s, const Result& r, const Report& report) {
    if (s.material.curvature_length == 0.0 && std::ranges::none_of(s.output.fields, [](auto& f) {
            return std::ranges::find(f.what, Quantity::curvature) != f.what.end();
        }))
        return; // nothing is made of it
    if (const auto [at_border, within] = curvature_at_border(s); within > 0 && at_border > 1.2 * within)
        all.push_back(fmt::format("the surface is curved by {:.3g}/m within two cells of the border and by {:.3g}/m "
                                  "further in: a measured surface goes on as its reflection, which bends it there; "
                                  "measure beyond the grid, or read no sites there",
                                  at_border, within));
    if (report.gain.outside())
        all.push_back(fmt::format("|l*C| reaches {:.3g}: above {} responses change sign; {}", report.gain.value,
                                  report.gain.greatest,
                                  s.grid.spacing ? "lower material.curvature_length or surface.relief"
                                                 : "take a smoother surface or a weaker load, or give grid.spacing and "
                                                   "material.curvature_length"));
    const double cells = double(s.grid.width) * s.grid.height;
    if (r.kinks > 0)
        all.push_back(fmt::format(
            "the curvature has a kink in {} of {} cells ({:.2g} %{}): it does not converge there on a finer grid; "
            "smooth the surface or the load's map",
            r.kinks, cells, 100 * double(r.kinks) / cells,
            r.pressed_cells < 0 ? "" : fmt::format("; {} cells are pressed", r.pressed_cells)));
    if (r.kinks == 0 && s.stencil != Stencil::fourth_order && r.stencil_estimate > 0.1 * r.greatest_curvature)
        all.push_back(fmt::format("the stencil estimate is {:.2g} % of the greatest |C|: take a finer grid, or "
                                  "curvature.stencil = \"fourth-order\"",
                                  100 * r.stencil_estimate / r.greatest_curvature));
    if (report.cells_per_ridge.outside())
        all.push_back(fmt::format("{:.2g} cells per ridge: curvature is coarse below {}; take a finer grid or fewer "
                                  "surface.ridges",
                                  report.cells_per_ridge.value, report.cells_per_ridge.least));
}

// Lengths and times that hint at another unit than the scene's.
void add_units(Sentences& all, const Scene& s, const Report& report) {
    if (s.grid.spacing && s.surface.kind == Surface::Kind::map && s.surface.relief && *s.surface.relief < 1e-3) {
        const auto [least, greatest] = std::minmax_element(s.surface.map.begin(), s.surface.map.end());
        const double span = *greatest - *least;
        if (span > 0 && span < 1e-3)
            all.push_back(fmt::format("surface.relief = {:.3g} multiplies heights that span {:.3g}: together {:.3g} m; "
                                      "with heights in metres set surface.relief = 1",
                                      *s.surface.relief, span, *s.surface.relief * span));
    }
    for (const Figure& tau : report.retardation_times)
        if (tau.outside()) {
            all.push_back(
                fmt::format("the retardation time viscosity/modulus is {:.3g} s, and skin's lie in {:.3g} ms to "
                            "{} s: material.modulus is in Pa, material.viscosity in Pa s",
                            tau.value, 1e3 * tau.least, tau.greatest));
            break;
        }
}

void add_indentation(Sentences& all, const Load& l, const Report& report) {
    if (report.indentation.outside())
        all.push_back(fmt::format("the indentation reaches {:.3g} m, beyond material.thickness = {:.3g} m: lower "
                                  "load.intensity{}",
                                  report.indentation.value, report.indentation.greatest,
                                  l.control == Control::depth ? "" : " or raise material.modulus"));
}

// A cubic spline passes a step by 11 % of it on either side.
void add_texture(Sentences& all, const Load& l) {
    if (!l.texture || l.texture->map.empty()) return;
    const Texture& t = *l.texture;
    const auto [least, greatest] = std::ranges::minmax(t.map);
    double step = 0;
    for (size_t i = 0, width = size_t(t.width); i < t.map.size(); ++i)
        for (size_t next : {i - i % width + (i + 1) % width, (i + width) % t.map.size()})
            step = std::max(step, std::abs(t.map[next] - t.map[i]));
    if (step > 0.5 * (greatest - least))
        all.push_back(fmt::format("neighbouring numbers of load.texture differ by up to {:.3g}, and the spline through "
                                  "them passes such a step by about {:.2g} on either side, from {:.3g} to {:.3g}: let "
                                  "steps take several numbers",
                                  step, 0.11 * step, least - 0.11 * step, greatest + 0.11 * step));
}

void add_depths(Sentences& all, const Load& l) {
    if (l.control == Control::depth && l.kind != Load::Kind::punch && l.kind != Load::Kind::ball)
        all.push_back(
            "the load is a depth of each cell, and cells do not couple: the skin beside a contact stays as it "
            "is; load.kind = \"punch\" or \"ball\" presses a half-space");
}

// Ridges act on spikes through the contact alone: fibres have no gain by curvature.
void add_unfelt_ridges(Sentences& all, const Scene& s, const Report& report) {
    const auto on_crests = [](const Load& l) { return l.contact == Load::Contact::crests; };
    if (s.afferents.empty() || !std::isfinite(report.cells_per_ridge.value) || on_crests(s.load) ||
        std::ranges::any_of(s.more_loads, on_crests))
        return;
    all.push_back("the ridges of the surface change no spike, because they touch as their valleys do: with a pressure "
                  "load.contact = \"crests\" lets the crests touch alone");
}

void add_interval(Sentences& all, const Scene& s) {
    if (s.load.kind != Load::Kind::sequence || !s.load.interval) return;
    const double interval = *s.load.interval, frames = std::floor(s.time.duration / interval) + 1; // frames reached
    if (frames > 1 && (frames < 3 || interval < 10)) return;
    const std::string reached = frames == 1
                                    ? fmt::format("a run of {:.6g} s ends before the second frame", s.time.duration)
                                    : fmt::format("a run of {:.6g} s has {:.0f}", s.time.duration, frames);
    all.push_back(
        fmt::format("load.interval = {:.6g} is in seconds from frame to frame, so that {}; with {:.6g} frames "
                    "a second it is {:.3g}",
                    interval, reached, interval, 1 / interval));
}

struct Greatest {
    double value = 0;
    size_t row = 0; // of the result's times
    std::optional<Cell> cell;
    bool known = false;

    void take(double x, size_t at, std::optional<Cell> in = {}) {
        if (known && !(std::abs(x) > std::abs(value))) return;
        value = x, row = at, cell = in, known = true;
    }
};

Greatest greatest_of(Quantity q, const Scene& scene, const Result& r) {
    Greatest greatest;
    for (const Trace& t : r.traces)
        for (size_t n = 0; t.quantity == q && n < t.min.size(); ++n)
            greatest.take(t.min[n], n), greatest.take(t.max[n], n);
    if (greatest.known) return greatest;
    const std::vector<Site>& sites = scene.sites;
    for (size_t i = 0; i < r.responses.size(); ++i)
        if (const Site& site = sites[i % sites.size()]; site.type == q)
            greatest.take(r.responses[i], i / sites.size(), site.cell);
    return greatest;
}

} // namespace

std::vector<std::string> warnings(const Scene& scene, const Result& result) {
    Sentences all;
    if (!result.device.exact)
        all.push_back(fmt::format("the bits of {} differ from the CPU path's", result.device.name));
    const Report judged = report(scene, result);
    add_curvature(all, scene, result, judged);
    add_units(all, scene, judged);
    add_indentation(all, scene.load, judged);
    add_texture(all, scene.load);
    add_depths(all, scene.load);
    add_unfelt_ridges(all, scene, judged);
    add_interval(all, scene);
    return all;
}

std::vector<std::string> greatest_responses(const Scene& scene, const Result& r) {
    std::vector<std::string> lines;
    using Named = std::tuple<Quantity, const char*, const char*>; // with its unit
    for (const auto& pair : {std::array{Named{Quantity::sa1, "SA1", ""}, Named{Quantity::sa2, "SA2", " s"}},
                             std::array{Named{Quantity::fa1, "FA1", " 1/s"}, Named{Quantity::fa2, "FA2", " 1/s^2"}}}) {
        std::vector<std::string> parts;
        for (const auto& [q, called, unit] : pair) {
            const Greatest g = greatest_of(q, scene, r);
            if (!g.known) continue;
            parts.push_back(fmt::format("{} {:.4g}{} at {:.6g} s{}", called, g.value, unit, r.time[g.row],
                                        g.cell ? fmt::format(" in cell [{}, {}]", g.cell->x, g.cell->y) : ""));
        }
        if (!parts.empty()) lines.push_back(fmt::format("greatest {}", fmt::join(parts, ", ")));
    }
    return lines;
}

} // namespace dermis::output
