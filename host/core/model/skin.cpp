// SPDX-License-Identifier: MIT
#include "host/core/model/skin.hpp"

#include "host/core/base/pool.hpp"
#include "host/core/description/names.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace dermis::model {
namespace {

// The different chains of `length` elements among all that were asked for, one after another in `elements`. A chain's
// number is the index of its first element. places_ is a hash table of the numbers with linear probing, at most half
// full.
class Numbered {
  public:
    Numbered(std::vector<Element>& elements, size_t length) : elements_(elements), length_(length) {}

    int number_of(const Element* chain) {
        if (2 * (elements_.size() / length_ + 1) > places_.size()) grow();
        int& place = place_of(chain);
        if (place < 0) {
            place = int(elements_.size());
            elements_.insert(elements_.end(), chain, chain + length_);
        }
        return place;
    }
    bool is(int number, const Element* chain) const {
        return std::equal(chain, chain + length_, elements_.begin() + number);
    }

  private:
    int& place_of(const Element* chain) {
        uint64_t bits = 0;
        for (size_t e = 0; e < length_; ++e)
            bits = std::rotl(bits, 7) ^ std::bit_cast<uint64_t>(chain[e].modulus + 0.0) ^ // -0 is 0
                   std::rotl(std::bit_cast<uint64_t>(chain[e].viscosity + 0.0), 32);
        size_t at = size_t(bits * 0x9e3779b97f4a7c15 >> 32) & (places_.size() - 1);
        while (places_[at] >= 0 && !is(places_[at], chain)) at = (at + 1) & (places_.size() - 1);
        return places_[at];
    }

    void grow() {
        places_.assign(std::max<size_t>(4 * places_.size(), 64), -1);
        for (size_t i = 0; i < elements_.size(); i += length_) place_of(elements_.data() + i) = int(i);
    }

    std::vector<Element>& elements_;
    const size_t length_;
    std::vector<int> places_; // -1: free
};

// Retardation times count as one within the rounding of maps in float, where one map is a multiple of the other.
constexpr double same_time = 0x1p-21;

constexpr size_t most_parts = 8;

// Returns whether an element has a part's retardation time; the part's range of times then includes the element's.
bool joins(TimeGroup& part, const Element& m) {
    const double time = m.viscosity / m.modulus, low = part.low.viscosity, high = part.high.viscosity;
    if (is_elastic(part.element) || is_elastic(m)) return is_elastic(part.element) && is_elastic(m);
    if (part.element.modulus == 0 || m.modulus == 0) return part.element.modulus == m.modulus;
    if (std::max(high, time) - std::min(low, time) > same_time * std::max(high, time)) return false;
    part.low.viscosity = std::min(low, time);
    part.high.viscosity = std::max(high, time);
    return true;
}

// The part of one element alone.
TimeGroup part_of(const Element& m) {
    const Element one = m.modulus == 0 ? Element{0, 1} : Element{1, m.viscosity / m.modulus};
    return {one, one, one};
}

void find_parts(PreparedSkin& skin) {
    skin.parts.clear();
    skin.part_of.clear();
    if (skin.materials.size() < 2 || skin.chain.length > 1) return;
    for (const Element& m : skin.materials) {
        const auto part = std::find_if(skin.parts.begin(), skin.parts.end(), [&](TimeGroup& p) { return joins(p, m); });
        skin.part_of.push_back(int(part - skin.parts.begin()));
        if (part != skin.parts.end()) continue;
        skin.parts.push_back(part_of(m));
        const double time = skin.parts.back().element.viscosity;
        if (skin.parts.size() <= most_parts && (time == 0 || std::isnormal(time))) continue;
        skin.parts.clear();
        skin.part_of.clear();
        return;
    }
    for (TimeGroup& p : skin.parts) {
        if (p.element.modulus == 0 || is_elastic(p.element)) continue;
        double &low = p.low.viscosity, &high = p.high.viscosity;
        p.element.viscosity = low + (high - low) / 2;
        low = std::nextafter(low, 0); // the quotients themselves are rounded
        high = std::nextafter(high, INFINITY);
    }
}

void number_cells(PreparedSkin& skin) {
    const Material& m = skin.description.material;
    Numbered known(skin.materials, skin.chain.length);
    skin.material_of = simd::map_of(skin.padded_cells(), 0);
    int last = -1; // the number of the cell before
    const auto number = [&](const Element* chain) {
        if (last < 0 || !known.is(last, chain)) last = known.number_of(chain); // neighbours are often alike
        return last;
    };
    for (size_t i = 0, y = 0; y < size_t(skin.height()); ++y)
        for (int x = 0; x < skin.width(); ++x, ++i)
            skin.material_of[y * size_t(skin.pitch) + size_t(x)] = number(scene::series_at(m, i).elements.data());
}

void find_materials(PreparedSkin& skin) {
    const Material& m = skin.description.material;
    skin.materials.clear();
    skin.material_of.clear();
    const scene::Series first = scene::series_at(m, 0);
    skin.chain = {.length = first.length, .spring = first.ends_in_spring};
    if (scene::is_uniform(m)) {
        skin.materials.assign(first.elements.begin(), first.elements.begin() + long(first.length));
    } else {
        number_cells(skin);
        if (skin.materials.size() == skin.chain.length) skin.material_of.clear();
    }
    find_parts(skin);
}

static_assert(int(Stencil::five_point) == STENCIL_FIVE_POINT && int(Stencil::fourth_order) == STENCIL_FOURTH_ORDER &&
              int(scene::study_stencil) == STENCIL_PUBLISHED);
static_assert(int(Edges::mirror) == EDGES_MIRROR && int(Edges::periodic) == EDGES_PERIODIC &&
              int(scene::study_edges) == EDGES_PUBLISHED);
static_assert(int(Quantity::strain) == QUANTITY_STRAIN && int(Quantity::sa1) == QUANTITY_SA1 &&
              int(Quantity::sa2) == QUANTITY_SA2 && int(Quantity::fa1) == QUANTITY_FA1 &&
              int(Quantity::fa2) == QUANTITY_FA2);

} // namespace

PreparedSkin prepare_skin(const SkinDescription& d, int threads, int pitch_cells) {
    PreparedSkin skin;
    skin.description = d;
    skin.heights = scene::surface_heights(d, threads);
    skin.relief = *d.surface.relief;
    skin.pitch = (d.grid.width + pitch_cells - 1) / pitch_cells * pitch_cells;
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
    skin.heights = skin.description.surface.map = skin.description.surface.curvature = {};
    scene::drop_maps(skin.description.material);
}

} // namespace dermis::model
