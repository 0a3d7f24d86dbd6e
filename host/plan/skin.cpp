// SPDX-License-Identifier: MIT
#include "host/plan/skin.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace dermis::plan {
namespace {

// Gives each element that differs from all before a number, in order. It is a hash table: there may be as many elements
// as cells.
class ElementNumbers {
  public:
    explicit ElementNumbers(std::vector<Element>& elements) : elements_(elements) {}

    int number_of(const Element& m) {
        if (2 * elements_.size() >= slots_.size()) grow();
        int& slot = slots_[slot_of(m)];
        if (slot < 0) {
            slot = int(elements_.size());
            elements_.push_back(m);
        }
        return slot;
    }

  private:
    // The slot of an element, or the free one where it belongs. The highest bits of the product depend on all others.
    size_t slot_of(const Element& m) const {
        const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x + 0.0); }; // -0 is 0
        const std::uint64_t mixed = bits(m.modulus) * 0x9e3779b97f4a7c15 ^ std::rotl(bits(m.viscosity), 32);
        size_t at = size_t(mixed * 0xff51afd7ed558ccd >> (64 - size_bits_));
        for (;; at = (at + 1) & (slots_.size() - 1)) {
            if (slots_[at] < 0) return at;
            const Element& other = elements_[size_t(slots_[at])];
            if (other.modulus == m.modulus && other.viscosity == m.viscosity) return at;
        }
    }
    void grow() {
        slots_.assign(size_t(1) << ++size_bits_, -1);
        for (size_t i = 0; i < elements_.size(); ++i) slots_[slot_of(elements_[i])] = int(i);
    }

    std::vector<Element>& elements_;
    int size_bits_ = 9;
    std::vector<int> slots_; // 2^size_bits_ of them after the first element; -1: free
};

// Retardation times count as one within the rounding of maps in float, where one map is a multiple of the other.
constexpr double same_time = 0x1p-21;

std::optional<CommonElement> common_element(const std::vector<Element>& materials) {
    const auto all = [&](auto holds) { return std::all_of(materials.begin(), materials.end(), holds); };
    const Element spring{1, 0}, dashpot{0, 1};
    if (materials.size() < 2) return {};
    if (all([](const Element& m) { return m.viscosity == 0; })) return CommonElement{spring, spring, spring};
    if (all([](const Element& m) { return m.modulus == 0; })) return CommonElement{dashpot, dashpot, dashpot};
    double low = INFINITY, high = 0;
    for (const Element& m : materials) {
        const double time = m.viscosity / m.modulus;
        if (!std::isnormal(time)) return {}; // a spring or a dashpot among others, or out of range
        low = std::min(low, time);
        high = std::max(high, time);
    }
    if (high - low > same_time * high) return {};
    // The quotients themselves are rounded.
    return CommonElement{{1, low + (high - low) / 2}, {1, std::nextafter(low, 0)}, {1, std::nextafter(high, INFINITY)}};
}

void find_materials(PreparedSkin& skin) {
    const Material& m = skin.description.material;
    skin.materials.clear();
    skin.material_of.clear();
    skin.common.reset();
    if (m.modulus_map.empty() && m.viscosity_map.empty()) {
        skin.materials = {{m.modulus, m.viscosity}};
        return;
    }
    ElementNumbers numbers(skin.materials);
    skin.material_of.assign(skin.padded_cells(), 0);
    for (size_t i = 0, y = 0; y < size_t(skin.height()); ++y)
        for (int x = 0; x < skin.width(); ++x, ++i)
            skin.material_of[y * size_t(skin.pitch) + size_t(x)] =
                numbers.number_of({scene::modulus_at(m, i), scene::viscosity_at(m, i)});
    if (skin.materials.size() == 1) skin.material_of.clear();
    skin.common = common_element(skin.materials);
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

PreparedSkin with_material(PreparedSkin skin, double modulus, double viscosity) {
    skin.description.material.modulus = modulus;
    skin.description.material.viscosity = viscosity;
    find_materials(skin);
    return skin;
}

void drop_maps(PreparedSkin& skin) {
    skin.heights = skin.description.surface.map = {};
    skin.description.material.modulus_map = skin.description.material.viscosity_map = {};
}

} // namespace dermis::plan
