// SPDX-License-Identifier: MIT
// The checks of grid, surface and sites, and the order of all checks of a skin.
#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"
#include "host/core/description/skin_keys.hpp"

#include <algorithm>
#include <numbers>

namespace dermis::scene {
namespace {

bool is_inside(Cell c, const Grid& g) { return c.x >= 0 && c.y >= 0 && c.x < g.width && c.y < g.height; }

// Replaces a ridge_period by the number of ridges with this period.
void take_ridge_period(SkinDescription& s) {
    Surface& f = s.surface;
    if (!f.ridge_period) return;
    const double period = *f.ridge_period;
    need(s.grid.spacing.has_value(), "surface.ridge_period", period, "only with grid.spacing");
    need(!f.ridges, "surface.ridges", f.ridges.value_or(0), "not beside surface.ridge_period");
    if (f.kind == Surface::Kind::map) return; // its ridges are in its heights
    const double periods = s.grid.width * *s.grid.spacing / period;
    f.ridges = f.kind == Surface::Kind::wave ? periods : 2 * std::numbers::pi * periods; // see cells_per_ridge()
    need(finite(*f.ridges), "surface.ridge_period", period, "a period whose ridges can be counted");
    f.ridge_period.reset();
}

} // namespace

std::string text_of(Cell c) { return "[" + std::to_string(c.x) + ", " + std::to_string(c.y) + "]"; }

void need_inside(const std::string& parameter, Cell c, const Grid& g) {
    if (!is_inside(c, g))
        refuse(parameter, text_of(c),
               "[x, y] with x in 0.." + std::to_string(g.width - 1) + ", y in 0.." + std::to_string(g.height - 1));
}

void check_grid(const Grid& grid) { check_rows("grid.", grid); }

void check_surface(SkinDescription& s) {
    Surface& f = s.surface;
    check_rows("surface.", f);
    const bool map = f.kind == Surface::Kind::map;
    need(of_ridges.holds(f) || map || !f.ridge_period, "surface.ridge_period", f.ridge_period.value_or(0),
         "only with surface.kind \"wave\", \"spiral\" or \"file\"");
    take_ridge_period(s);
    const bool wave = f.kind == Surface::Kind::wave;
    if (!f.ridges) f.ridges = wave ? 15 : 25;
    if (!f.noise) f.noise = wave ? 2 : 0.5;
    if (!f.noise_length) f.noise_length = wave ? 50 : 40;
    if (map) need_map("surface.path", f.map, s.grid);
    if (f.curvature.empty()) return;
    need(map, "surface.curvature", double(f.curvature.size()), "only with surface.kind \"file\"");
    need_map("surface.curvature", f.curvature, s.grid);
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
    check_rows("material.", s.material);
}

void check_sites(const SkinDescription& s) {
    for (size_t i = 0; i < s.sites.size(); ++i) {
        const Site& site = s.sites[i];
        if (is_inside(site.cell, s.grid) && is_receptor_class(site.type)) continue;
        const std::string parameter = "sites[" + std::to_string(i) + "]"; // not before: there may be millions of sites
        need_inside(parameter, site.cell, s.grid);
        refuse(parameter, std::string("\"") + name(site.type) + "\"", receptor_class_names());
    }
}

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

const char* dermis::name(Quantity q) noexcept { return scene::text_of(q); }
const char* dermis::name(Precision p) noexcept { return scene::text_of(p); }
