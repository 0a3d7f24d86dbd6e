// SPDX-License-Identifier: MIT
#include "host/lab/planner/materials.hpp"

#include <algorithm>
#include <utility>

namespace dermis::planner {
namespace {

using model::Element;
using model::PreparedSkin;
using model::Schedule;

// The least |v| that is not 0.
double least_of(const std::vector<double>& map) {
    double least = INFINITY;
    for (double v : map)
        if (v != 0) least = std::min(least, std::abs(v));
    return std::isfinite(least) ? least : 0;
}

// The roundings of spread values by kernels/spread.h, in units of the greatest value that is spread. Down a level there
// are four in each direction. In a stencil's sum there are four of a weight, its nodes' sums and their product, and one
// for each sum of products on the way. Up a level there are three in each direction, and one where both sums meet.
double roundings_of(const model::Spread& levels) {
    double units = 0;
    for (size_t l = 0; l < levels.size(); ++l) {
        const int side = levels[l].radius + 1;
        double magnitudes = 0; // of all weights of the stencil
        for (int i = 0; i < side * side; ++i)
            magnitudes += (i % side ? 2 : 1) * (i / side ? 2 : 1) * std::abs(levels[l].weights[size_t(i)]);
        units += magnitudes * ((8 + 7) * double(l) + 4 + 2 * levels[l].radius);
    }
    return units;
}

// Reduces the materials to a number that the analysis has time and memory for. At a given retardation time errors scale
// with peak/modulus and peak/viscosity, so the materials with the greatest of either represent all materials in a
// range of retardation times, under their pressure times the range's longest time over its shortest.
constexpr size_t ranges = 32;

bool too_many(size_t materials, double steps) {
    constexpr double most_cell_steps = 1e5;
    return materials > 2 * ranges && double(materials) * steps > most_cell_steps;
}

std::vector<PressedMaterial> representatives(std::vector<PressedMaterial> all) {
    const auto rate = [](const PressedMaterial& m) { return std::log(z_of(m.element, 1)); };
    double low = INFINITY, high = -INFINITY; // of rates that are finite
    for (const PressedMaterial& m : all)
        if (std::isfinite(rate(m))) low = std::min(low, rate(m)), high = std::max(high, rate(m));
    const auto by_modulus = [](const PressedMaterial& m) { return final_strain(m.element, m.around); };
    const auto by_viscosity = [](const PressedMaterial& m) { return strain_rate(m.element, m.around); };
    std::vector<const PressedMaterial*> soft(ranges + 2, nullptr), fluid(ranges + 2, nullptr);
    for (const PressedMaterial& m : all) {
        const double r = rate(m); // elastic materials come last, viscous ones first
        const size_t range = !std::isfinite(r) ? (r > 0 ? ranges + 1 : 0)
                             : high > low      ? 1 + std::min(size_t((r - low) / (high - low) * ranges), ranges - 1)
                                               : 1;
        if (!soft[range] || by_modulus(m) > by_modulus(*soft[range])) soft[range] = &m;
        if (!fluid[range] || by_viscosity(m) > by_viscosity(*fluid[range])) fluid[range] = &m;
    }
    const double wide = high > low ? std::exp((high - low) / double(ranges)) : 1;
    std::vector<PressedMaterial> few;
    for (const auto& chosen : {soft, fluid})
        for (const PressedMaterial* m : chosen)
            if (m)
                few.push_back({m->element, wide * m->around, wide * m->around}); // others may be read where it is not
    return few;
}

// Where elements in series are too many, some elements of each place in the series represent all elements of that
// place, as if they were cells of their own.
void represent(AnalysedMaterials& m) {
    const std::vector<PressedMaterial> all = std::exchange(m.pressed, {});
    for (size_t e = 0; e < m.chain.length; ++e) {
        std::vector<PressedMaterial> of_place;
        for (size_t i = e; i < all.size(); i += m.chain.length) of_place.push_back(all[i]);
        const std::vector<PressedMaterial> few = representatives(of_place);
        m.pressed.insert(m.pressed.end(), few.begin(), few.end());
        m.ends.push_back(m.pressed.size());
    }
    m.chain = {};
}

} // namespace

AnalysedMaterials analysed(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind,
                           const Read& read) {
    AnalysedMaterials m{.pressed = pressed_materials(skin, schedule, read),
                        .deep = deep_materials(skin, schedule, kind, read),
                        .chain = skin.chain};
    take_gains(skin, schedule, read, kind, m.pressed);
    if (too_many(m.pressed.size(), double(schedule.outputs))) represent(m);
    if (m.ends.empty()) m.ends = {m.pressed.size()};
    double least = schedule.framed ? 0 : least_of(schedule.pressure), below = 0, least_below = INFINITY;
    for (const auto& deep : m.deep) // under a cell without pressure there may be stress
        if (deep && deep->pressed.peak > 0) {
            least = std::min(least, deep->least);
            raise(below, deep->pressed.peak);
            least_below = std::min(least_below, deep->pressed.peak);
        }
    const double u = counted_unit(kind);
    for (const PressedMaterial& material : m.pressed) {
        const double peak = material.around > 0 ? material.around : below,
                     read = std::min(material.peak > 0 ? material.peak : peak, least_below);
        m.counted.push_back({.element = material.element,
                             .rounding = {.u = u,
                                          .peak = kind.separable ? 1 : peak,
                                          .single = kind.single,
                                          .bound = schedule.framed,
                                          .compensated = kind.compensated,
                                          .flush = peak > 0 && !kind.separable ? 2 * kind.stored / read : 0,
                                          .denormal = kind.single && peak > 0 ? 0x1p-150 * peak / read : 0,
                                          .least = peak > 0 ? least / read : 0},
                             .peak = read});
    }
    for (size_t i = 0; kind.separable && i < skin.parts.size(); ++i)
        for (const Element& element : {skin.parts[i].low, skin.parts[i].high})
            m.extremes.push_back({.element = element, .rounding = m.counted[i].rounding, .peak = m.counted[i].peak});
    return m;
}

DeepMaterials deep_materials(const PreparedSkin& skin, const Schedule& schedule, const Arithmetic& kind,
                             const Read& read) {
    DeepMaterials deep;
    for (size_t q = 0; q < deep.size(); ++q) {
        if (!schedule.half_space[q] || !(read.everything || read.quantity == int(q))) continue;
        const model::HalfSpace& space = *schedule.half_space[q];
        Schedule as = schedule;
        as.pressure = schedule.map_of(q);
        if (schedule.framed) as.pressure = std::vector<double>(skin.cells(), space.norm() * largest_of(as.pressure));
        std::vector<PressedMaterial> materials = pressed_materials(skin, as, read);
        take_gains(skin, as, read, kind, materials);
        DeepMaterial m{.pressed = materials.front()};
        if (const double peak = m.pressed.peak; kind.spread) {
            m.pressed.peak = m.least = largest_of(schedule.pressure);
            m.norm = space.norm();
            m.share = peak > 0 ? peak / m.pressed.peak : 0;
            m.rounded = kind.unit() * roundings_of(*space.spread());
        } else {
            m.least = schedule.framed ? 0 : least_of(as.pressure);
            m.off = unit_of_double;
            const double norm = std::max(space.norm(), 1e-300),
                         excess = space.excess(norm, double(skin.cells())) / norm;
            if (schedule.framed) m.off += space.roundings<double>() + excess;
            else if (peak > 0) m.off += error_of_stresses(schedule.pressure, skin.description.grid, space) / peak;
        }
        m.pressed.around = 2 * m.pressed.peak; // its roundings are not those of the cell that is counted
        deep[q] = m;
    }
    return deep;
}

PreparedSkin stress_in_series(const PreparedSkin& skin, const Schedule& schedule) {
    std::vector<KelvinVoigt> elements;
    for (size_t i = 0; i < schedule.modes.size(); ++i) {
        const double share = std::abs(schedule.shares[i]);
        elements.push_back({schedule.modes[i].modulus / share, schedule.modes[i].viscosity / share});
    }
    Material material = skin.description.material;
    scene::take_chain(material, elements);
    return with_material(skin, material);
}

} // namespace dermis::planner
