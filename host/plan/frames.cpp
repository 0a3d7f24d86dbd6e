// SPDX-License-Identifier: MIT
#include "host/plan/frames.hpp"

#include "host/scene/refusal.hpp"

#include <algorithm>

namespace dermis::plan {
namespace {

constexpr size_t field_alignment = 64; // floats: 256 bytes, the most that a device may ask of an offset
constexpr int sample_width = 67, sample_height = 13;

// What kernels take as float must be one: a product with infinity could be NaN, and that a wrong 0.
void check_float(const Plan& p) {
    const auto need = [](const char* parameter, double v) {
        scene::need(scene::finite(double(float(v))), parameter, v, "up to 3.4e38 for a skin in float");
    };
    for (const Medium& m : p.media) need("material.modulus", m.modulus);
    const f64::Constants& c = p.constants;
    scene::need(scene::finite(double(float(c.bend))), "grid.spacing", p.scene.grid.spacing.value_or(1),
                "material.thickness/spacing^2 up to 3.4e38 for a skin in float");
    need("material.curvature_length", c.curvature_length);
    for (double gain : {c.gain_plus, c.gain_minus}) need("receptors.fa2_gains", gain);
    for (const Site& site : p.scene.sites) // fields are checked as they are made
        need("surface.relief", laplacian_at(p.maps.surface, site.cell, p.scene.grid, p.stencil, p.edges));
}

std::vector<double> noise(uint32_t random) {
    std::vector<double> map;
    for (int i = 0; i < sample_width * sample_height; ++i) {
        random = random * 1664525u + 1013904223u;
        map.push_back((double(random >> 8) / (1 << 24) - 0.25) * (i % 7 ? 1 : 1e-18));
    }
    return map;
}

} // namespace

bool in_float(const std::vector<Medium>& media, double dt) {
    const auto finite = [](float x) { return scene::finite(double(x)); };
    return finite(float(dt)) && std::all_of(media.begin(), media.end(), [&](const Medium& m) {
               const f32::Coefficients k = rounded<f32::Coefficients>(exact_coefficients(m, dt));
               return finite(k.E) && finite(k.b) && finite(k.f) && finite(k.i0) && finite(k.i1) && finite(k.i2) &&
                      finite(k.leak) && finite(k.v0) && finite(k.v1) && finite(k.a0) && finite(k.a1) && finite(k.a2);
           });
}

Plan skin_plan(const SkinDescription& description, const SkinOptions& options) {
    Scene s;
    static_cast<SkinDescription&>(s) = description;
    if (!s.receptors.fa2) s.receptors.fa2 = Fa2::step_mean;
    s.output.traces.clear();
    s.time.duration = s.time.step; // time is the caller's: nothing is kept
    for (Quantity q : options.responses) {
        if (q < Quantity::sa1 || q > Quantity::fa2 || std::count(s.output.traces.begin(), s.output.traces.end(), q))
            scene::refuse("responses", std::string("\"") + name(q) + "\"", "sa1, sa2, fa1, fa2, each at most once");
        if (s.sites.empty()) s.output.traces.push_back(q);
    }
    if (options.responses.empty() && s.sites.empty())
        scene::refuse("responses", "(none)", "some of sa1, sa2, fa1, fa2, or sites in the description");
    if (options.precision == Precision::f64)
        scene::refuse("precision", "\"f64\"", "f32, f32-compensated: a skin pressed frame by frame is in float");
    Plan p = prepare(s, true);
    const bool grows = p.wanted[int(Quantity::sa2)] && !s.receptors.sa2_adaptation;
    p.precision = options.precision.value_or(grows ? Precision::f32_compensated : Precision::f32);
    p.compensated = p.precision == Precision::f32_compensated;
    p.keeps_maps = true;
    for (const Medium& m : p.media)
        if (m.viscosity == 0 && p.wanted[int(Quantity::fa2)])
            scene::refuse("material.viscosity", "0", "> 0 for FA2 of frames; with viscosity 0 do without fa2");
    check_float(p);
    if (s.sites.empty()) complete(p);
    return p;
}

ResponseLayout response_layout_of(const Plan& plan) {
    ResponseLayout a;
    const std::vector<Site>& sites = plan.scene.sites;
    for (int q = 1; q < REDUCED_MAPS; ++q) {
        a.of[size_t(q)].first = a.all;
        if (!plan.wanted[q]) continue;
        const size_t count =
            sites.empty()
                ? size_t(plan.pitch) * size_t(plan.constants.height)
                : size_t(std::count_if(sites.begin(), sites.end(), [q](auto& site) { return int(site.type) == q; }));
        a.of[size_t(q)].count = count;
        a.all += sites.empty() ? (count + field_alignment - 1) / field_alignment * field_alignment : count;
    }
    std::array<size_t, REDUCED_MAPS> next{};
    for (const Site& site : sites) a.site.push_back(a.of[size_t(site.type)].first + next[size_t(site.type)]++);
    return a;
}

SkinDescription sample_skin(Stencil stencil, Edges edges, bool materials) {
    SkinDescription d;
    d.grid = {sample_width, sample_height, {}};
    d.stencil = stencil;
    d.edges = edges;
    d.material.modulus = 2.5;
    d.material.viscosity = 0.75;
    d.receptors = {0.5, Fa2::step_mean, {0.75, -0.375}};
    d.surface.kind = Surface::Kind::map;
    d.surface.map = noise(12345);
    if (materials) {
        d.material.modulus_map = noise(54321);
        for (double& E : d.material.modulus_map.edit()) E += 1.5;
    }
    return d;
}

Map sample_pressure() { return noise(99); }

} // namespace dermis::plan
