// SPDX-License-Identifier: MIT
#include "host/plan/skin.hpp"

#include "host/simd/pool.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace dermis::plan {
namespace {

// Elements and their numbers in the order in which they came: a table of numbers that is at most half full, each at the
// first free place from its element's hash on.
class Numbered {
  public:
    explicit Numbered(std::vector<Element>& elements) : elements_(elements) {}

    int number_of(const Element& m) {
        if (2 * (elements_.size() + 1) > places_.size()) grow();
        int& place = place_of(m);
        if (place < 0) {
            place = int(elements_.size());
            elements_.push_back(m);
        }
        return place;
    }

  private:
    int& place_of(const Element& m) {
        const uint64_t bits = std::bit_cast<uint64_t>(m.modulus + 0.0) ^ // -0 is 0
                              std::rotl(std::bit_cast<uint64_t>(m.viscosity + 0.0), 32);
        size_t at = size_t(bits * 0x9e3779b97f4a7c15 >> 32) & (places_.size() - 1);
        while (places_[at] >= 0 && elements_[size_t(places_[at])] != m) at = (at + 1) & (places_.size() - 1);
        return places_[at];
    }

    void grow() {
        places_.assign(std::max<size_t>(4 * places_.size(), 64), -1);
        for (size_t i = 0; i < elements_.size(); ++i) place_of(elements_[i]) = int(i);
    }

    std::vector<Element>& elements_;
    std::vector<int> places_; // -1: free
};

// Retardation times count as one within the rounding of maps in float, where one map is a multiple of the other.
constexpr double same_time = 0x1p-21;

constexpr size_t most_parts = 8;

// Returns whether an element is of a part's retardation time. The part then spans it.
bool joins(Part& part, const Element& m) {
    const double time = m.viscosity / m.modulus, low = part.low.viscosity, high = part.high.viscosity;
    if (is_elastic(part.element) || is_elastic(m)) return is_elastic(part.element) && is_elastic(m);
    if (part.element.modulus == 0 || m.modulus == 0) return part.element.modulus == m.modulus;
    if (std::max(high, time) - std::min(low, time) > same_time * std::max(high, time)) return false;
    part.low.viscosity = std::min(low, time);
    part.high.viscosity = std::max(high, time);
    return true;
}

// The part of one element alone.
Part part_of(const Element& m) {
    const Element one = m.modulus == 0 ? Element{0, 1} : Element{1, m.viscosity / m.modulus};
    return {one, one, one};
}

void find_parts(PreparedSkin& skin) {
    skin.parts.clear();
    skin.part_of.clear();
    if (skin.materials.size() < 2) return;
    for (const Element& m : skin.materials) {
        const auto part = std::find_if(skin.parts.begin(), skin.parts.end(), [&](Part& p) { return joins(p, m); });
        skin.part_of.push_back(int(part - skin.parts.begin()));
        if (part != skin.parts.end()) continue;
        skin.parts.push_back(part_of(m));
        const double time = skin.parts.back().element.viscosity;
        if (skin.parts.size() <= most_parts && (time == 0 || std::isnormal(time))) continue;
        skin.parts.clear();
        skin.part_of.clear();
        return;
    }
    for (Part& p : skin.parts) {
        if (p.element.modulus == 0 || is_elastic(p.element)) continue;
        double &low = p.low.viscosity, &high = p.high.viscosity;
        p.element.viscosity = low + (high - low) / 2;
        low = std::nextafter(low, 0); // the quotients themselves are rounded
        high = std::nextafter(high, INFINITY);
    }
}

void find_materials(PreparedSkin& skin) {
    const Material& m = skin.description.material;
    skin.materials.clear();
    skin.material_of.clear();
    skin.chain = {};
    if (scene::is_uniform(m)) {
        skin.materials = scene::chain_of(m);
        skin.chain = {.length = skin.materials.size(), .spring = skin.materials.size() > 1 && is_elastic(skin.materials.back())};
        skin.parts.clear();
        skin.part_of.clear();
        return;
    }
    Numbered known(skin.materials);
    skin.material_of = simd::map_of(skin.padded_cells(), 0);
    int last = 0; // the material of the cell before
    for (size_t i = 0, y = 0; y < size_t(skin.height()); ++y)
        for (int x = 0; x < skin.width(); ++x, ++i) {
            const Element element = scene::element_at(m, i);
            if (i == 0 || element != skin.materials[size_t(last)]) last = known.number_of(element); // often alike
            skin.material_of[y * size_t(skin.pitch) + size_t(x)] = last;
        }
    if (skin.materials.size() == 1) skin.material_of.clear();
    find_parts(skin);
}

} // namespace

PreparedSkin prepare_skin(const SkinDescription& d, int threads) {
    PreparedSkin skin;
    skin.description = d;
    skin.heights = scene::surface_heights(d, threads);
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
