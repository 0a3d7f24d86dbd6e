// SPDX-License-Identifier: MIT
#include "host/lab/output/warnings.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace dermis::output {
namespace {

using Sentences = std::vector<std::string>;

void add_curvature(Sentences& all, const Scene& s, const Result& r, const Report& report) {
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
    const bool fourth_order = s.stencil == Stencil::fourth_order;
    if (r.kinks == 0 && !fourth_order && r.stencil_estimate > 0.1 * r.greatest_curvature)
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

void add_indentation(Sentences& all, const Report& report) {
    if (report.indentation.outside())
        all.push_back(fmt::format("the indentation reaches {:.3g} m, beyond material.thickness = {:.3g} m: lower "
                                  "load.intensity or raise material.modulus",
                                  report.indentation.value, report.indentation.greatest));
}

void add_depths(Sentences& all, const Load& l) {
    if (l.control == Control::depth && l.kind != Load::Kind::punch && l.kind != Load::Kind::ball)
        all.push_back(
            "the load is a depth of each cell, and cells do not couple: the skin beside a contact stays as it "
            "is; load.kind = \"punch\" or \"ball\" presses a half-space");
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

} // namespace

std::vector<std::string> warnings(const Scene& scene, const Result& result) {
    Sentences all;
    if (!result.device.exact)
        all.push_back(fmt::format("the bits of {} differ from the CPU path's", result.device.name));
    const Report judged = report(scene, result);
    add_curvature(all, scene, result, judged);
    add_units(all, scene, judged);
    add_indentation(all, judged);
    add_depths(all, scene.load);
    add_interval(all, scene);
    return all;
}

} // namespace dermis::output
