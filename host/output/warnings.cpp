// SPDX-License-Identifier: MIT
#include "host/output/warnings.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace dermis::output {
namespace {

using Sentences = std::vector<std::string>;

void add_curvature(Sentences& all, const Scene& s, const Result& r) {
    if (r.greatest_gain > 1)
        all.push_back(fmt::format("|l*C| reaches {:.3g}: above 1 responses change sign; {}", r.greatest_gain,
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
    if (r.cells_per_ridge < 8)
        all.push_back(fmt::format("{:.2g} cells per ridge: curvature is coarse below 8; take a finer grid or fewer "
                                  "surface.ridges",
                                  r.cells_per_ridge));
}

// Lengths and times that hint at another unit than the scene's.
void add_units(Sentences& all, const Scene& s, const Result& r) {
    if (s.surface.kind == Surface::Kind::map && s.surface.relief && *s.surface.relief < 1e-3) {
        const auto [least, greatest] = std::minmax_element(s.surface.map.begin(), s.surface.map.end());
        const double span = *greatest - *least;
        if (span > 0 && span < 1e-3)
            all.push_back(fmt::format("surface.relief = {:.3g} multiplies heights that span {:.3g}: together {:.3g} m; "
                                      "with heights in metres set surface.relief = 1",
                                      *s.surface.relief, span, *s.surface.relief * span));
    }
    for (double tau : {r.tau_min, r.tau_max}) // 0 and infinity are meant: no viscosity, no modulus
        if (tau > 0 && std::isfinite(tau) && (tau < 1e-4 || tau > 20)) {
            all.push_back(fmt::format("the retardation time viscosity/modulus is {:.3g} s, and skin's lie in 0.1 ms to "
                                      "20 s: material.modulus is in Pa, material.viscosity in Pa s",
                                      tau));
            break;
        }
}

void add_indentation(Sentences& all, const Scene& s, const Result& r) {
    double strain = 0;
    for (const Trace& t : r.traces)
        if (t.quantity == Quantity::strain)
            for (const auto* column : {&t.min, &t.max})
                for (double v : *column) strain = std::max(strain, std::abs(v));
    const double thickness = s.material.thickness.value_or(0);
    if (strain > 1 && thickness > 0)
        all.push_back(fmt::format("the indentation reaches {:.3g} m, beyond material.thickness = {:.3g} m: lower "
                                  "load.intensity or raise material.modulus",
                                  strain * thickness, thickness));
}

void add_interval(Sentences& all, const Scene& s) {
    if (s.load.kind != Load::Kind::sequence || !s.load.interval) return;
    const double interval = *s.load.interval, frames = std::floor(s.time.duration / interval) + 1; // those reached
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
    add_curvature(all, scene, result);
    if (scene.grid.spacing) {
        add_units(all, scene, result);
        add_indentation(all, scene, result);
    }
    add_interval(all, scene);
    return all;
}

} // namespace dermis::output
