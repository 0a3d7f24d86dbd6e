// SPDX-License-Identifier: MIT
// The checks of material, stencil, edges and receptors.
#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"
#include "host/core/description/skin_keys.hpp"

namespace dermis::scene {
namespace {

size_t cells_of(const Grid& grid) { return size_t(grid.width) * size_t(grid.height); }

// A material is elements in series, or a modulus and a viscosity, both of which a scene with units has to give.
void check_given(const SkinDescription& s) {
    const Material& m = s.material;
    for (auto [key, number, map] : {std::tuple{"material.modulus", &m.modulus, &m.modulus_map},
                                    {"material.viscosity", &m.viscosity, &m.viscosity_map}}) {
        if (is_chain(m) && !map->empty())
            refuse(key, "(a map)", "not beside material.elements, which take maps of their own");
        if (is_chain(m) && *number) refuse(key, shortest(**number), "not beside material.elements");
        if (s.grid.spacing && !is_chain(m) && !*number && map->empty())
            refuse(key, "(not given)",
                   "material.modulus in Pa and material.viscosity in Pa s, required with grid.spacing; or "
                   "material.elements, material.relaxation, or preset = \"fingertip\"");
    }
}

// Checks the numbers or maps of an element. its_modulus: the words for it where it must not be 0.
void check_element(const KelvinVoigt& e, const std::string& name, const std::string& its_modulus, const Grid& grid) {
    const std::string modulus = name + ".modulus", viscosity = name + ".viscosity";
    if (!e.modulus_map.empty()) need_map(modulus.c_str(), e.modulus_map, grid);
    if (!e.viscosity_map.empty()) need_map(viscosity.c_str(), e.viscosity_map, grid);
    const bool maps = !is_uniform(e);
    const std::string moves = "> 0 where " + its_modulus + " is 0";
    for (size_t i = 0; i < (maps ? cells_of(grid) : 1); ++i) {
        const Element m = element_at(e, i);
        const auto need_number = [&](const std::string& of, double value, bool ok, std::string_view allowed) {
            if (!(finite(value) && ok))
                refuse(of, shortest(value) + (maps ? " in cell " + cell_text(i, grid.width) : ""),
                       std::string(allowed));
        };
        need_number(modulus, m.modulus, m.modulus >= 0, "a finite number >= 0");
        need_number(viscosity, m.viscosity, m.viscosity >= 0, "a finite number >= 0");
        need_number(viscosity, m.viscosity, m.modulus > 0 || m.viscosity > 0, moves);
    }
}

// Checks elements in series.
void check_chain(const Material& m, const Grid& grid) {
    if (m.elements.empty() || m.elements.size() > 8)
        refuse("material.elements", "(" + std::to_string(m.elements.size()) + " elements)",
               "1 to 8, with material.spring and material.dashpot beside them");
    for (size_t i = 0; i < m.elements.size(); ++i)
        check_element(m.elements[i], "material.elements[" + std::to_string(i) + "]", "its modulus", grid);
    check_rows("material.", m);
}

void check_edges(const SkinDescription& s) {
    if (*s.edges != study_edges) return;
    if (*s.stencil != study_stencil)
        refuse("curvature.edges", "\"published\"", "only with curvature.stencil = \"published\"");
    need(s.grid.width >= 2, "grid.width", s.grid.width, "at least 2 with the published edges");
    need(s.grid.height >= 2, "grid.height", s.grid.height, "at least 2 with the published edges");
}

void check_depths(SkinDescription& s) {
    Receptors& r = s.receptors;
    if (reads_poisson(r)) r.poisson = r.poisson.value_or(0.4);
    check_rows("receptors.", r);
    check_rows("receptors.depth.", r.depth);
    const DepthKernels& k = r.kernel;
    const bool alike = k.sa1 == k.sa2 && k.sa1 == k.fa1 && k.sa1 == k.fa2; // a word for all classes that have a depth
    const bool some = has_depth(r);
    for (const ReceptorClass& c : receptor_classes) {
        std::optional<double>& depth = r.depth.*c.depth;
        const std::string of = name(c.type), key = "receptors.depth." + of;
        const DepthKernel kernel = r.kernel.*c.kernel;
        if (!depth && kernel != DepthKernel::stress && !(alike && some))
            refuse("receptors.kernel" + (alike ? "" : "." + of), std::string("\"") + text_of(kernel) + "\"",
                   "\"stress\" without a depth; in [receptors] a line depth." + of +
                       " = \"2 mm\" gives one, depth = \"fingertip\" those of all classes");
        if (!depth) continue;
        need(*depth > 0 || kernel == DepthKernel::stress, key.c_str(), *depth,
             std::string("m, > 0 with receptors.kernel = \"") + text_of(kernel) + "\"");
        need(s.grid.spacing.has_value(), key.c_str(), *depth, "only with grid.spacing");
        need(is_uniform(s.material), key.c_str(), *depth,
             "none where the material differs from cell to cell: the half-space is even");
        need(*s.edges != Edges::periodic, key.c_str(), *depth,
             "none with curvature.edges = \"periodic\": beyond the grid the half-space is unloaded");
        if (*depth == 0) depth.reset(); // there the stress is the pressure
    }
}

} // namespace

void refuse_spring(const Material& m, const char* allowed) {
    if (m.spring) refuse("material.spring", shortest(*m.spring), allowed);
    refuse("material.elements", "(one of viscosity 0)", allowed);
}

std::string where_in(const SkinDescription& s, size_t cell) {
    return is_uniform(s.material) ? "" : " in cell " + cell_text(cell, s.grid.width);
}

MaterialSurvey survey_material(const SkinDescription& s) {
    const Material& m = s.material;
    check_given(s);
    if (is_chain(m)) check_chain(m, s.grid);
    else
        check_element({m.modulus.value_or(study_element.modulus), m.viscosity.value_or(study_element.viscosity),
                       m.modulus_map, m.viscosity_map},
                      "material", "material.modulus", s.grid);
    MaterialSurvey survey;
    double greatest = -1;
    for (size_t i = 0; i < (is_uniform(m) ? 1 : cells_of(s.grid)); ++i) {
        const Series series = series_at(m, i);
        for (size_t e = 0; e < series.length; ++e) {
            const double rate = z_of(series.elements[e], 1);
            const bool spring = series.ends_in_spring && e + 1 == series.length;
            if (is_elastic(series.elements[e]) && !spring) survey.elastic = i;
            survey.spring |= spring;
            if (!spring && rate > greatest) greatest = rate, survey.stiffest = i;
        }
    }
    return survey;
}

void check_fa2_density(const SkinDescription& s, const MaterialSurvey& material) {
    if (!(material.elastic || material.spring) || *s.receptors.fa2 == Fa2::step_mean) return;
    if (material.spring)
        refuse_spring(s.material,
                      "no spring for FA2 as a density, because a jump makes it infinite twice; with a spring "
                      "set receptors.fa2 = \"step-mean\" or leave fa2 out of [output]");
    refuse("material.viscosity", "0" + where_in(s, *material.elastic),
           "> 0 for FA2 as a density; with viscosity 0 set receptors.fa2 = \"step-mean\" or leave fa2 out of [output]");
}

void check_curvature_and_receptors(SkinDescription& s) {
    if (!s.stencil) s.stencil = Stencil::five_point;
    if (!s.edges) s.edges = Edges::mirror;
    check_edges(s);
    if (!s.surface.curvature.empty() && (*s.stencil == study_stencil || *s.edges == study_edges))
        refuse("surface.curvature", "(given)", "none with the published stencil or edges");
    check_depths(s);
}

} // namespace dermis::scene
