// SPDX-License-Identifier: MIT
// The checks of grid, time, surface, load and output, and the order of all checks.
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/checks.hpp"
#include "host/lab/scenes/waveform.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dermis::scene {
namespace {

std::string text(Cell c) { return "[" + std::to_string(c.x) + ", " + std::to_string(c.y) + "]"; }

bool is_inside(Cell c, const Grid& g) { return c.x >= 0 && c.y >= 0 && c.x < g.width && c.y < g.height; }

void need_inside(const std::string& parameter, Cell c, const Grid& g) {
    if (!is_inside(c, g))
        refuse(parameter, text(c),
               "[x, y] with x in 0.." + std::to_string(g.width - 1) + ", y in 0.." + std::to_string(g.height - 1));
}

void check_grid(const Grid& grid) {
    for (auto [key, cells] : {std::pair{"grid.width", grid.width}, {"grid.height", grid.height}})
        need(cells >= 1 && cells <= 16384, key, cells, "whole cells, 1..16384");
    if (grid.spacing) need_positive("grid.spacing", *grid.spacing);
}

// Turns a ridge_period into the number of ridges that has it.
void take_ridge_period(SkinDescription& s) {
    Surface& f = s.surface;
    if (!f.ridge_period) return;
    const double period = *f.ridge_period;
    need(s.grid.spacing.has_value(), "surface.ridge_period", period, "only with grid.spacing");
    need(!f.ridges, "surface.ridges", f.ridges.value_or(0), "not beside surface.ridge_period");
    need_positive("surface.ridge_period", period);
    const double periods = s.grid.width * *s.grid.spacing / period;
    f.ridges = f.kind == Surface::Kind::wave ? periods : 2 * std::numbers::pi * periods; // see cells_per_ridge()
    need(finite(*f.ridges), "surface.ridge_period", period, "a period whose ridges can be counted");
    f.ridge_period.reset();
}

void check_surface(SkinDescription& s) {
    Surface& f = s.surface;
    const bool ridged = f.kind == Surface::Kind::wave || f.kind == Surface::Kind::spiral;
    for (auto [key, value] : {std::pair{"surface.ridges", &f.ridges},
                              {"surface.ridge_period", &f.ridge_period},
                              {"surface.noise", &f.noise},
                              {"surface.noise_length", &f.noise_length}})
        need(ridged || !*value, key, value->value_or(0), "only with surface.kind \"wave\" or \"spiral\"");
    take_ridge_period(s);
    const bool wave = f.kind == Surface::Kind::wave;
    if (!f.ridges) f.ridges = wave ? 15 : 25;
    if (!f.noise) f.noise = wave ? 2 : 0.5;
    if (!f.noise_length) f.noise_length = wave ? 50 : 40;
    need_finite("surface.ridges", *f.ridges);
    need_not_negative("surface.noise", *f.noise);
    need_positive("surface.noise_length", *f.noise_length);
    if (f.kind == Surface::Kind::map) need_map("surface.path", f.map, s.grid);
}

// A scene with grid.spacing has units, and its lengths are required; without it they are 1.
void check_lengths(SkinDescription& s) {
    for (auto [key, value] : {std::pair{"surface.relief", &s.surface.relief},
                              {"material.thickness", &s.material.thickness},
                              {"material.curvature_length", &s.material.curvature_length}}) {
        if (s.grid.spacing && !*value) refuse(key, "(not given)", "a number of metres, required with grid.spacing");
        need(s.grid.spacing || !*value, key, value->value_or(0),
             "only with grid.spacing; without it the scene is dimensionless");
        if (!*value) *value = 1;
    }
    need_positive("surface.relief", *s.surface.relief);
    need_not_negative("material.thickness", *s.material.thickness);
    need_finite("material.curvature_length", *s.material.curvature_length);
}

void check_sequence(const Scene& s) {
    const Load& l = s.load;
    const std::string allowed = "only without load.kind = \"sequence\", which is all of the load";
    if (l.envelope.kind != Envelope::Kind::step || l.envelope.start != 0) refuse("load.envelope", "(given)", allowed);
    if (s.method != Method::exact)
        refuse("method", std::string("\"") + name(s.method) + "\"", "\"exact\" with load.kind = \"sequence\"");
    if (!l.interval) refuse("load.interval", "(not given)", "seconds between frames, required with a sequence");
    need_positive("load.interval", *l.interval);
    need(s.time.duration / *l.interval <= 1e8, "load.interval", *l.interval, "at most 1e8 frames within time.duration");
}

void check_load(Scene& s) {
    Load& l = s.load;
    const bool sequence = l.kind == Load::Kind::sequence, shaped = l.kind != Load::Kind::map && !sequence;
    if (!shaped && l.center)
        refuse("load.center", text(*l.center), "only with load.kind \"circular\", \"point\" or \"linear\"");
    need(shaped || !l.radius, "load.radius", l.radius.value_or(0),
         "only with load.kind \"circular\", \"point\" or \"linear\"");
    need(sequence || !l.interval, "load.interval", l.interval.value_or(0), "only with load.kind = \"sequence\"");
    if (!l.center) l.center = Cell{s.grid.width / 2, s.grid.height / 2};
    need_inside("load.center", *l.center, s.grid);
    if (!l.radius) l.radius = std::max(1, std::min(s.grid.width, s.grid.height) / 4);
    need(*l.radius >= 1 && *l.radius <= 65536, "load.radius", *l.radius, "whole cells, 1..65536");
    need_finite("load.intensity", l.intensity);
    check_envelope(l.envelope, s.time);
    if (l.kind == Load::Kind::map) need_map("load.path", l.map, s.grid);
    if (sequence) check_sequence(s);
}

void check_time(const Scene& s) {
    need_positive("time.step", s.time.step);
    need(finite(s.time.duration) && s.time.duration >= s.time.step, "time.duration", s.time.duration,
         "at least time.step = " + shortest(s.time.step) + " s");
    const double times = s.time.duration / s.time.step;
    const double bytes = times * 8 * (s.output.traces.size() * (3 + s.output.probes.size()) + s.sites.size());
    need(times <= 1e8 && bytes <= 8e9, "time.step", s.time.step,
         "duration/step = " + shortest(times) +
             " outputs of the traces and sites asked for must be at most 1e8 and fit into 8 GB");
}

void check_sites(const SkinDescription& s) {
    for (size_t i = 0; i < s.sites.size(); ++i) {
        const Site& site = s.sites[i];
        if (is_inside(site.cell, s.grid) && is_receptor_class(site.type)) continue;
        const std::string parameter = "sites[" + std::to_string(i) + "]"; // only here: there may be millions
        need_inside(parameter, site.cell, s.grid);
        refuse(parameter, std::string("\"") + name(site.type) + "\"", receptor_class_names());
    }
}

void check_output(const Scene& s) {
    for (size_t i = 0; i < s.output.probes.size(); ++i)
        need_inside("output.probes[" + std::to_string(i) + "]", s.output.probes[i], s.grid);
    check_sites(s);
    for (Quantity q : s.output.traces)
        if (q > Quantity::fa2)
            refuse("output.traces", std::string("\"") + name(q) + "\"",
                   "strain, " + receptor_class_names() + "; curvature and deformation as fields");
    for (const FieldRequest& f : s.output.fields) {
        if (std::count(f.what.begin(), f.what.end(), Quantity::indentation))
            refuse("output.fields.what", "\"indentation\"",
                   "strain, " + receptor_class_names() +
                       ", curvature, deformation; indentation is thickness*strain, and a Skin's response");
        need(finite(f.at) && f.at >= 0 && f.at <= s.time.duration, "output.fields.at", f.at,
             "0.." + shortest(s.time.duration) + ", within time.duration");
        const double n = std::round(f.at / s.time.step);
        const bool at_output = snapped(f.at, s.time.step) == Instant::multiple(n, s.time.step);
        need(s.method == Method::exact || (at_output && n < double(outputs(s.time))), "output.fields.at", f.at,
             std::string("an output time (a multiple of time.step, before duration) with method = \"") +
                 name(s.method) + "\"");
    }
}

// Opens the file of a sequence; null with any other load.
std::shared_ptr<NpyFile> open_frames(const Scene& s) {
    if (s.load.kind != Load::Kind::sequence) return nullptr;
    return std::make_shared<NpyFile>(s.load.path, s.grid.width, s.grid.height, true, "load.path");
}

} // namespace

void need_map(const char* parameter, const Map& map, const Grid& g) {
    const size_t cells = size_t(g.width) * g.height;
    need(map.size() == cells, parameter, double(map.size()),
         "width*height = " + std::to_string(cells) + " cells, row 0 first");
    bool all = true; // no early exit, so that the loop vectorises
    for (double v : map) all &= finite(v);
    for (size_t i = 0; !all && i < cells; ++i)
        if (!finite(map[i]))
            refuse(parameter, shortest(map[i]) + " in cell " + cell_text(i, g.width), "finite numbers");
}

bool wants(const Scene& s, Quantity q) {
    const Output& o = s.output;
    const auto in = [q](const std::vector<Quantity>& list) { return std::count(list.begin(), list.end(), q) > 0; };
    return in(o.traces) || std::any_of(s.sites.begin(), s.sites.end(), [q](auto& site) { return site.type == q; }) ||
           std::any_of(o.fields.begin(), o.fields.end(), [&](auto& f) { return in(f.what); });
}

long long steps_per_frame(double interval, double step) {
    const double ratio = interval / step, whole = std::round(ratio);
    return whole >= 1 && whole <= 1e9 && std::abs(ratio - whole) <= 4 * 0x1p-52 * whole ? static_cast<long long>(whole)
                                                                                        : 0;
}

long long outputs(const Time& t) { return static_cast<long long>(std::ceil(t.duration / t.step - 1e-9)); }

ValidatedScene validate(const Scene& scene) {
    Scene s = scene;
    check_grid(s.grid);
    if (s.tolerance) need_positive("tolerance", *s.tolerance);
    check_time(s);
    check_surface(s);
    check_lengths(s);
    check_load(s);
    std::shared_ptr<NpyFile> frames = open_frames(s);
    check_method(s);
    check_output(s);
    return {std::move(s), std::move(frames)};
}

void check_material(const SkinDescription& validated, const Material& material, const std::vector<Quantity>& asked) {
    SkinDescription s = validated;
    take_elements(s.material, material);
    const MaterialSurvey survey = survey_material(s);
    if (std::count(asked.begin(), asked.end(), Quantity::fa2)) check_fa2_density(s, survey);
}

SkinDescription validate_skin(const SkinDescription& description, const std::vector<Quantity>& asked) {
    SkinDescription s = description;
    check_grid(s.grid);
    check_surface(s);
    check_lengths(s);
    s.receptors.fa2 = s.receptors.fa2.value_or(Fa2::step_mean);
    check_material(s, s.material, asked);
    check_curvature_and_receptors(s);
    check_sites(s);
    return s;
}

} // namespace dermis::scene
