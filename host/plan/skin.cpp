// SPDX-License-Identifier: MIT
#include "host/plan/skin.hpp"

#include <cmath>
#include <map>

namespace dermis::plan {
namespace {

void find_materials(PreparedSkin& skin) {
    const Material& m = skin.description.material;
    skin.materials.clear();
    skin.material_of.clear();
    if (scene::is_uniform(m)) {
        skin.materials = {scene::element_at(m, 0)};
        return;
    }
    std::map<Element, int> known;
    skin.material_of.assign(skin.padded_cells(), 0);
    for (size_t i = 0, y = 0; y < size_t(skin.height()); ++y)
        for (int x = 0; x < skin.width(); ++x, ++i) {
            const Element element = scene::element_at(m, i);
            const auto [material, fresh] = known.try_emplace(element, int(skin.materials.size()));
            if (fresh) skin.materials.push_back(element);
            skin.material_of[y * size_t(skin.pitch) + size_t(x)] = material->second;
        }
    if (skin.materials.size() == 1) skin.material_of.clear();
}

} // namespace

PreparedSkin prepare_skin(const SkinDescription& d) {
    PreparedSkin skin;
    skin.description = d;
    skin.heights = scene::surface_heights(d);
    skin.relief = *d.surface.relief;
    skin.pitch = (d.grid.width + PITCH_CELLS - 1) / PITCH_CELLS * PITCH_CELLS;
    skin.tiles = (d.grid.width + TILE_CELLS - 1) / TILE_CELLS;
    skin.stencil = int(*d.stencil);
    skin.edges = int(*d.edges);
    f64::Constants& c = skin.constants;
    c.bend = *d.material.thickness / (skin.spacing() * skin.spacing());
    c.curvature_length = *d.material.curvature_length;
    c.gain_plus = d.receptors.fa2_gains[0];
    c.gain_minus = d.receptors.fa2_gains[1];
    c.thickness = *d.material.thickness;
    c.width = d.grid.width;
    c.height = d.grid.height;
    c.pitch = skin.pitch;
    skin.rule = {.sa2_adaptation = d.receptors.sa2_adaptation.value_or(INFINITY),
                 .step_mean = *d.receptors.fa2 == Fa2::step_mean};
    find_materials(skin);
    return skin;
}

PreparedSkin with_material(PreparedSkin skin, const Material& material) {
    scene::take_elements(skin.description.material, material);
    find_materials(skin);
    return skin;
}

void drop_maps(PreparedSkin& skin) {
    skin.heights = skin.description.surface.map = {};
    scene::drop_maps(skin.description.material);
}

} // namespace dermis::plan
