// SPDX-License-Identifier: MIT
#include "host/scene/refusal.hpp"
#include "host/scene/scene.hpp"
#include "host/scene/waveform.hpp"

#include <algorithm>
#include <cmath>

namespace dermis {

const char* name(Quantity q) noexcept {
    static constexpr const char* names[] = {"strain", "sa1", "sa2", "fa1", "fa2", "curvature", "deformation"};
    return names[int(q)];
}
const char* name(Method m) noexcept {
    static constexpr const char* names[] = {"exact",          "euler",          "rk2",    "rk4",
                                            "backward-euler", "crank-nicolson", "sdirk2", "published"};
    return names[int(m)];
}
const char* name(Precision p) noexcept {
    static constexpr const char* names[] = {"f32", "f32-compensated", "f64"};
    return names[int(p)];
}

namespace scene {
namespace {

std::string text(Cell c) { return "[" + std::to_string(c.x) + ", " + std::to_string(c.y) + "]"; }

void need_inside(const std::string& parameter, Cell c, const Grid& g) {
    if (c.x < 0 || c.y < 0 || c.x >= g.width || c.y >= g.height)
        refuse(parameter, text(c),
               "[x, y] with x in 0.." + std::to_string(g.width - 1) + ", y in 0.." + std::to_string(g.height - 1));
}

void need_map(const char* parameter, const std::vector<double>& map, const Grid& g) {
    const size_t cells = size_t(g.width) * g.height;
    need(map.size() == cells, parameter, double(map.size()),
         "width*height = " + std::to_string(cells) + " cells, row 0 first");
    for (size_t i = 0; i < cells; ++i)
        if (!std::isfinite(map[i]))
            refuse(parameter, shortest(map[i]) + " in cell " + text({int(i % g.width), int(i / g.width)}),
                   "finite numbers");
}

void check_surface(Scene& s) {
    Surface& f = s.surface;
    const bool ridged = f.kind == Surface::Kind::wave || f.kind == Surface::Kind::spiral;
    for (auto [key, value] : {std::pair{"surface.ridges", &f.ridges},
                              {"surface.noise", &f.noise},
                              {"surface.noise_length", &f.noise_length}})
        need(ridged || !*value, key, value->value_or(0), "only with surface.kind \"wave\" or \"spiral\"");
    const bool wave = f.kind == Surface::Kind::wave;
    if (!f.ridges) f.ridges = wave ? 15 : 25;
    if (!f.noise) f.noise = wave ? 2 : 0.5;
    if (!f.noise_length) f.noise_length = wave ? 50 : 40;
    need_finite("surface.ridges", *f.ridges);
    need_not_negative("surface.noise", *f.noise);
    need_positive("surface.noise_length", *f.noise_length);
    if (f.kind == Surface::Kind::map) need_map("surface.path", f.map, s.grid);
}

// With spacing a scene has units and its lengths must be given; without, they are 1.
void check_lengths(Scene& s) {
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

void check_load(Scene& s) {
    Load& l = s.load;
    const bool shaped = l.kind != Load::Kind::map;
    if (!shaped && l.center)
        refuse("load.center", text(*l.center), "only with load.kind \"circular\", \"point\" or \"linear\"");
    need(shaped || !l.radius, "load.radius", l.radius.value_or(0),
         "only with load.kind \"circular\", \"point\" or \"linear\"");
    if (!l.center) l.center = Cell{s.grid.width / 2, s.grid.height / 2};
    need_inside("load.center", *l.center, s.grid);
    if (!l.radius) l.radius = std::max(1, std::min(s.grid.width, s.grid.height) / 4);
    need(*l.radius >= 1 && *l.radius <= 65536, "load.radius", *l.radius, "whole cells, 1..65536");
    need_finite("load.intensity", l.intensity);
    check_envelope(l.envelope, s.time);
    if (!shaped) need_map("load.path", l.map, s.grid);
}

// Of dt/tau: beyond it an explicit method grows without end.
double stability_limit(Method m) {
    if (m == Method::euler || m == Method::rk2 || m == Method::published) return 2;
    return m == Method::rk4 ? 2.785293563405282 : INFINITY;
}

bool wants(const Output& o, Quantity q) {
    const auto in = [q](const std::vector<Quantity>& list) { return std::count(list.begin(), list.end(), q) > 0; };
    return in(o.traces) || std::any_of(o.fields.begin(), o.fields.end(), [&](auto& f) { return in(f.what); });
}

void check_method(Scene& s) {
    const Material& m = s.material;
    need_not_negative("material.modulus", m.modulus);
    need_not_negative("material.viscosity", m.viscosity);
    need(m.modulus > 0 || m.viscosity > 0, "material.viscosity", m.viscosity, "> 0 where material.modulus is 0");
    if (s.method == Method::published) {
        const std::string allowed = "not beside method = \"published\", which sets it";
        if (s.stencil) refuse("curvature.stencil", "(given)", allowed);
        if (s.edges) refuse("curvature.edges", "(given)", allowed);
        if (s.receptors.fa2) refuse("receptors.fa2", "(given)", allowed);
        need(!s.receptors.sa2_adaptation, "receptors.sa2_adaptation", s.receptors.sa2_adaptation.value_or(0), allowed);
        s.stencil = Stencil::published;
        s.edges = Edges::published;
    }
    if (s.method != Method::exact) {
        need(m.viscosity > 0, "material.viscosity", m.viscosity,
             std::string("> 0 with method = \"") + name(s.method) + "\"");
        const double z = m.modulus * s.time.step / m.viscosity, limit = stability_limit(s.method);
        need(z <= limit || s.allow_unstable, "time.step", s.time.step,
             "at most " + shortest(limit) + "*viscosity/modulus = " + shortest(limit * m.viscosity / m.modulus) +
                 " s with method = \"" + name(s.method) + "\", which is stable up to dt/tau = " + shortest(limit) +
                 " (here " + shortest(z) + "); or method = \"exact\", or allow_unstable = true");
        const double adaptation = s.receptors.sa2_adaptation.value_or(INFINITY);
        need(s.time.step <= 2 * adaptation || s.allow_unstable, "time.step", s.time.step,
             "at most 2*receptors.sa2_adaptation = " + shortest(2 * adaptation) +
                 " s with method = \"euler\"; or allow_unstable = true");
        need(!s.receptors.sa2_adaptation || s.method == Method::euler, "receptors.sa2_adaptation",
             s.receptors.sa2_adaptation.value_or(0), "only with method = \"exact\" or \"euler\"");
    }
    if (!s.stencil) s.stencil = Stencil::five_point;
    if (!s.edges) s.edges = Edges::mirror;
    if (*s.edges == Edges::published) {
        if (*s.stencil != Stencil::published)
            refuse("curvature.edges", "\"published\"", "only with curvature.stencil = \"published\"");
        need(s.grid.width >= 2, "grid.width", s.grid.width, "at least 2 with the published edges");
        need(s.grid.height >= 2, "grid.height", s.grid.height, "at least 2 with the published edges");
    }
    if (!s.receptors.fa2) s.receptors.fa2 = Fa2::point;
    need(m.viscosity > 0 || *s.receptors.fa2 == Fa2::step_mean || !wants(s.output, Quantity::fa2), "material.viscosity",
         0,
         "> 0 for FA2 as a density; with viscosity 0 set receptors.fa2 = \"step-mean\" or leave fa2 out of [output]");
    if (s.receptors.sa2_adaptation) need_positive("receptors.sa2_adaptation", *s.receptors.sa2_adaptation);
    for (double gain : s.receptors.fa2_gains) need_finite("receptors.fa2_gains", gain);
}

void check_time(const Scene& s) {
    need_positive("time.step", s.time.step);
    need(std::isfinite(s.time.duration) && s.time.duration >= s.time.step, "time.duration", s.time.duration,
         "at least time.step = " + shortest(s.time.step) + " s");
    const double rows = s.time.duration / s.time.step;
    const double bytes = rows * s.output.traces.size() * (3 + s.output.probes.size()) * 8;
    need(rows <= 1e8 && bytes <= 8e9, "time.step", s.time.step,
         "duration/step = " + shortest(rows) +
             " outputs of the traces asked for must be at most 1e8 and fit into 8 GB");
}

void check_output(const Scene& s) {
    for (size_t i = 0; i < s.output.probes.size(); ++i)
        need_inside("output.probes[" + std::to_string(i) + "]", s.output.probes[i], s.grid);
    for (Quantity q : s.output.traces)
        if (q >= Quantity::curvature)
            refuse("output.traces", std::string("\"") + name(q) + "\"",
                   "strain, sa1, sa2, fa1, fa2; curvature and deformation as fields");
    for (const FieldRequest& f : s.output.fields) {
        need(std::isfinite(f.at) && f.at >= 0 && f.at <= s.time.duration, "output.fields.at", f.at,
             "0.." + shortest(s.time.duration) + ", within time.duration");
        const double n = f.at / s.time.step;
        need(s.method == Method::exact ||
                 (std::abs(n - std::round(n)) <= 1e-6 && std::round(n) < double(outputs(s.time))),
             "output.fields.at", f.at,
             std::string("an output time (a multiple of time.step, before duration) with method = \"") +
                 name(s.method) + "\"");
    }
}

} // namespace

long long outputs(const Time& t) { return static_cast<long long>(std::ceil(t.duration / t.step - 1e-9)); }

Scene validated(const Scene& scene) {
    Scene s = scene;
    for (auto [key, cells] : {std::pair{"grid.width", s.grid.width}, {"grid.height", s.grid.height}})
        need(cells >= 1 && cells <= 16384, key, cells, "whole cells, 1..16384");
    if (s.grid.spacing) need_positive("grid.spacing", *s.grid.spacing);
    check_time(s);
    check_surface(s);
    check_lengths(s);
    check_load(s);
    check_method(s);
    check_output(s);
    return s;
}

} // namespace scene
} // namespace dermis
