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
const char* name(Model m) noexcept {
    static constexpr const char* names[] = {"moments", "maps", "sites", "march"};
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
    bool all = true; // without a way out, for the compiler's vectors
    for (double v : map) all &= finite(v);
    for (size_t i = 0; !all && i < cells; ++i)
        if (!finite(map[i]))
            refuse(parameter, shortest(map[i]) + " in cell " + cell_text(i, g.width), "finite numbers");
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

void check_sequence(const Scene& s) {
    const Load& l = s.load;
    const std::string allowed = "only without load.kind = \"sequence\", which is all of the load";
    if (l.envelope.kind != Envelope::Kind::step || l.envelope.start != 0) refuse("load.envelope", "(given)", allowed);
    if (s.method != Method::exact)
        refuse("method", std::string("\"") + name(s.method) + "\"", "\"exact\" with load.kind = \"sequence\"");
    if (!l.interval) refuse("load.interval", "(not given)", "seconds between frames, required with a sequence");
    need_positive("load.interval", *l.interval);
    need(s.time.duration / *l.interval <= 1e8, "load.interval", *l.interval, "at most 1e8 frames within time.duration");
    NpyFile(l.path, s.grid.width, s.grid.height, true, "load.path");
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

// Of dt/tau: beyond it an explicit method grows without end.
double stability_limit(Method m) {
    if (m == Method::euler || m == Method::rk2 || m == Method::published) return 2;
    return m == Method::rk4 ? 2.785293563405282 : INFINITY;
}

// What FA2 is formed from must be there. `where` is a cell without viscosity.
void check_fa2(const Scene& s, bool elastic, const std::string& where) {
    if (!wants(s, Quantity::fa2)) return;
    const bool mean = *s.receptors.fa2 == Fa2::step_mean, sequence = s.load.kind == Load::Kind::sequence;
    if (elastic && (sequence || !mean))
        refuse("material.viscosity", "0" + where,
               sequence ? "> 0 for FA2 of a sequence; with viscosity 0 leave fa2 out of [output]"
                        : "> 0 for FA2 as a density; with viscosity 0 set receptors.fa2 = \"step-mean\" or leave fa2 "
                          "out of [output]");
    if (sequence && mean && !steps_per_frame(s))
        refuse("load.interval", shortest(*s.load.interval),
               "a whole multiple of time.step = " + shortest(s.time.step) +
                   " s for FA2 as a mean over a step; or receptors.fa2 = \"point\", or leave fa2 out of [output]");
}

void check_stability(const Scene& s, double modulus, double viscosity, const std::string& where) {
    if (s.method == Method::exact) return;
    const double z = modulus * s.time.step / viscosity, limit = stability_limit(s.method);
    need(z <= limit || s.allow_unstable, "time.step", s.time.step,
         "at most " + shortest(limit) + "*viscosity/modulus = " + shortest(limit * viscosity / modulus) +
             " s with method = \"" + name(s.method) + "\", which is stable up to dt/tau = " + shortest(limit) +
             " (here " + shortest(z) + where + "); or method = \"exact\", or allow_unstable = true");
}

void check_method(Scene& s) {
    if (s.method == Method::published) {
        const std::string allowed = "not beside method = \"published\", which sets it";
        if (s.stencil) refuse("curvature.stencil", "(given)", allowed);
        if (s.edges) refuse("curvature.edges", "(given)", allowed);
        if (s.receptors.fa2) refuse("receptors.fa2", "(given)", allowed);
        need(!s.receptors.sa2_adaptation, "receptors.sa2_adaptation", s.receptors.sa2_adaptation.value_or(0), allowed);
        s.stencil = Stencil::published;
        s.edges = Edges::published;
    }
    if (!s.receptors.fa2) s.receptors.fa2 = s.load.kind == Load::Kind::sequence ? Fa2::step_mean : Fa2::point;
    check_material(s);
    if (s.method != Method::exact) {
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
    if (s.receptors.sa2_adaptation) need_positive("receptors.sa2_adaptation", *s.receptors.sa2_adaptation);
    for (double gain : s.receptors.fa2_gains) need_finite("receptors.fa2_gains", gain);
}

void check_time(const Scene& s) {
    need_positive("time.step", s.time.step);
    need(finite(s.time.duration) && s.time.duration >= s.time.step, "time.duration", s.time.duration,
         "at least time.step = " + shortest(s.time.step) + " s");
    const double rows = s.time.duration / s.time.step;
    const double bytes = rows * 8 * (s.output.traces.size() * (3 + s.output.probes.size()) + s.sites.size());
    need(rows <= 1e8 && bytes <= 8e9, "time.step", s.time.step,
         "duration/step = " + shortest(rows) +
             " outputs of the traces and sites asked for must be at most 1e8 and fit into 8 GB");
}

void check_output(const Scene& s) {
    for (size_t i = 0; i < s.output.probes.size(); ++i)
        need_inside("output.probes[" + std::to_string(i) + "]", s.output.probes[i], s.grid);
    for (size_t i = 0; i < s.sites.size(); ++i) {
        const std::string site = "sites[" + std::to_string(i) + "]";
        need_inside(site, s.sites[i].cell, s.grid);
        if (s.sites[i].type < Quantity::sa1 || s.sites[i].type > Quantity::fa2)
            refuse(site, std::string("\"") + name(s.sites[i].type) + "\"", "sa1, sa2, fa1, fa2");
    }
    for (Quantity q : s.output.traces)
        if (q >= Quantity::curvature)
            refuse("output.traces", std::string("\"") + name(q) + "\"",
                   "strain, sa1, sa2, fa1, fa2; curvature and deformation as fields");
    for (const FieldRequest& f : s.output.fields) {
        need(finite(f.at) && f.at >= 0 && f.at <= s.time.duration, "output.fields.at", f.at,
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

bool wants(const Scene& s, Quantity q) {
    const Output& o = s.output;
    const auto in = [q](const std::vector<Quantity>& list) { return std::count(list.begin(), list.end(), q) > 0; };
    return in(o.traces) || std::any_of(s.sites.begin(), s.sites.end(), [q](auto& site) { return site.type == q; }) ||
           std::any_of(o.fields.begin(), o.fields.end(), [&](auto& f) { return in(f.what); });
}

void check_material(const Scene& s) {
    const Material& m = s.material;
    const bool maps = !m.modulus_map.empty() || !m.viscosity_map.empty();
    if (!m.modulus_map.empty()) need_map("material.modulus", m.modulus_map, s.grid);
    if (!m.viscosity_map.empty()) need_map("material.viscosity", m.viscosity_map, s.grid);
    if (maps && s.method == Method::published)
        refuse(m.modulus_map.empty() ? "material.viscosity" : "material.modulus", "(a map)",
               "one number with method = \"published\"");
    const size_t cells = maps ? size_t(s.grid.width) * s.grid.height : 1;
    const size_t none = cells;
    size_t worst = 0, elastic = none; // the cell of the greatest dt/tau; one without viscosity
    double greatest = -1;
    const auto where = [&](size_t i) { return maps ? " in cell " + cell_text(i, s.grid.width) : ""; };
    for (size_t i = 0; i < cells; ++i) {
        const double E = modulus_at(m, i), eta = viscosity_at(m, i);
        if (!(finite(E) && E >= 0)) refuse("material.modulus", shortest(E) + where(i), "a finite number >= 0");
        if (!(finite(eta) && eta >= 0)) refuse("material.viscosity", shortest(eta) + where(i), "a finite number >= 0");
        if (E == 0 && eta == 0) refuse("material.viscosity", "0" + where(i), "> 0 where material.modulus is 0");
        if (eta == 0) elastic = i;
        const double z = eta > 0 ? E / eta : INFINITY;
        if (z > greatest) greatest = z, worst = i;
    }
    if (elastic != none && s.method != Method::exact)
        refuse("material.viscosity", "0" + where(elastic), std::string("> 0 with method = \"") + name(s.method) + "\"");
    check_fa2(s, elastic != none, where(elastic));
    check_stability(s, modulus_at(m, worst), viscosity_at(m, worst), where(worst));
}

long long steps_per_frame(const Scene& s) {
    const double ratio = *s.load.interval / s.time.step, whole = std::round(ratio);
    return whole >= 1 && whole <= 1e9 && std::abs(ratio - whole) <= 1e-9 * whole ? static_cast<long long>(whole) : 0;
}

long long outputs(const Time& t) { return static_cast<long long>(std::ceil(t.duration / t.step - 1e-9)); }

Scene validated(const Scene& scene) {
    Scene s = scene;
    for (auto [key, cells] : {std::pair{"grid.width", s.grid.width}, {"grid.height", s.grid.height}})
        need(cells >= 1 && cells <= 16384, key, cells, "whole cells, 1..16384");
    if (s.grid.spacing) need_positive("grid.spacing", *s.grid.spacing);
    if (s.tolerance) need_positive("tolerance", *s.tolerance);
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
