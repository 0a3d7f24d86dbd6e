// SPDX-License-Identifier: MIT
// The checks of the method, which depend on material, stencil, edges and receptors.
#include "host/core/base/refusal.hpp"
#include "host/lab/scenes/scene.hpp"

#include <cmath>

namespace dermis::scene {
namespace {

// Returns the greatest dt/tau at which a method is stable; beyond it the strain grows without bound.
double stability_limit(Method m) {
    if (m == Method::euler || m == Method::rk2 || m == Method::published) return 2;
    return m == Method::rk4 ? 2.785293563405282 : INFINITY;
}

// Refuses FA2 of a sequence where it is not defined: without viscosity, and as the mean over a step of frames that do
// not fall on output times.
void check_fa2_of_sequence(const Scene& s, const MaterialSurvey& material) {
    if (s.load.control == Control::depth) // the strain jumps in its rate at each frame, as that of a spring does
        refuse("load.control", "\"depth\"",
               "\"pressure\" for FA2 where the load is known by frames; or leave fa2 out of [output] and [sites]");
    if (material.elastic)
        refuse("material.viscosity", "0" + where_in(s, *material.elastic),
               "> 0 for FA2 of a sequence; with viscosity 0 leave fa2 out of [output]");
    if (*s.receptors.fa2 == Fa2::step_mean && !steps_per_frame(*s.load.interval, s.time.step))
        refuse("load.interval", shortest(*s.load.interval),
               "a whole multiple of time.step = " + shortest(s.time.step) +
                   " s for FA2 as a mean over a step; or receptors.fa2 = \"point\", or leave fa2 out of [output]");
}

void check_stability(const Scene& s, const Element& m, const std::string& where) {
    if (s.method == Method::exact) return;
    const double z = z_of(m, s.time.step), limit = stability_limit(s.method);
    need(z <= limit || s.allow_unstable, "time.step", s.time.step,
         "at most " + shortest(limit) + "*viscosity/modulus = " + shortest(limit * m.viscosity / m.modulus) +
             " s with method = \"" + name(s.method) + "\", which is stable up to dt/tau = " + shortest(limit) +
             " (here " + shortest(z) + where + "); or method = \"exact\", or allow_unstable = true");
}

// Method::published determines stencil, edges, FA2 and SA2, so that none of their parameters may be given beside it.
void set_published(Scene& s) {
    const std::string allowed = "not beside method = \"published\", which sets it";
    if (s.stencil) refuse("curvature.stencil", "(given)", allowed);
    if (s.edges) refuse("curvature.edges", "(given)", allowed);
    if (s.receptors.fa2) refuse("receptors.fa2", "(given)", allowed);
    need(!s.receptors.sa2_adaptation, "receptors.sa2_adaptation", s.receptors.sa2_adaptation.value_or(0), allowed);
    if (has_depth(s.receptors)) refuse("receptors.depth", "(given)", allowed);
    s.stencil = published_stencil;
    s.edges = published_edges;
}

// Forward Euler of tau_a*y' = -y + tau_a*eps is stable up to dt = 2*tau_a. The other baselines have no formula for y.
void check_adaptation(const Scene& s) {
    if (s.method == Method::exact) return;
    const double adaptation = s.receptors.sa2_adaptation.value_or(INFINITY);
    need(s.time.step <= 2 * adaptation || s.allow_unstable, "time.step", s.time.step,
         "at most 2*receptors.sa2_adaptation = " + shortest(2 * adaptation) +
             " s with method = \"euler\"; or allow_unstable = true");
    need(!s.receptors.sa2_adaptation || s.method == Method::euler, "receptors.sa2_adaptation",
         s.receptors.sa2_adaptation.value_or(0), "only with method = \"exact\" or \"euler\"");
}

void check_material(const Scene& s, const MaterialSurvey& material) {
    if (is_chain(s.material) && s.method == Method::published)
        refuse("method", "\"published\"", "another one with material.elements");
    if (!is_uniform(s.material) && s.method == Method::published)
        refuse(s.material.modulus_map.empty() ? "material.viscosity" : "material.modulus", "(a map)",
               "one number with method = \"published\"");
    if (material.spring && s.method != Method::exact)
        refuse_spring(s.material, "no spring but with method = \"exact\"");
    if (material.elastic && s.method != Method::exact)
        refuse("material.viscosity", "0" + where_in(s, *material.elastic),
               std::string("> 0 with method = \"") + name(s.method) + "\"");
    if (wants(s, Quantity::fa2)) {
        if (is_framed(s.load)) check_fa2_of_sequence(s, material);
        check_fa2_density(s, material);
    }
    const Series series = series_at(s.material, material.stiffest);
    const std::string where = (is_chain(s.material) ? " in material.elements" : "") + where_in(s, material.stiffest);
    for (size_t e = 0; e < series.length; ++e) check_stability(s, series.elements[e], where);
}

} // namespace

void check_material(const Scene& validated, const Material& material) {
    Scene s = validated;
    take_elements(s.material, material);
    check_material(s, survey_material(s));
}

void check_method(Scene& s) {
    if (s.method == Method::published) set_published(s);
    const MaterialSurvey material = survey_material(s);
    const bool depth = s.load.control == Load::Control::depth;
    const bool mean = is_framed(s.load) || material.elastic || material.spring || depth;
    s.receptors.fa2 = s.receptors.fa2.value_or(mean ? Fa2::step_mean : Fa2::point);
    if (depth && *s.receptors.fa2 == Fa2::point && wants(s, Quantity::fa2))
        refuse("receptors.fa2", "\"point\"", "\"step-mean\" with load.control = \"depth\"");
    check_material(s, material);
    check_adaptation(s);
    check_curvature_and_receptors(s);
}

} // namespace dermis::scene
