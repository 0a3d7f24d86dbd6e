// SPDX-License-Identifier: MIT
// The materials that an analysis of errors steps, one cell of each: those of the skin, those that receptors at a depth
// have, and those that stand for a stress which classes follow.
#pragma once

#include "host/lab/planner/bound.hpp"
#include "host/lab/planner/counted_run.hpp"
#include "host/lab/planner/magnitudes.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace dermis::planner {

// The unit of the roundings that are counted: the reference's, where the run's own roundings are measured.
inline double counted_unit(const Arithmetic& kind) { return kind.separable ? unit_of_reference : kind.unit(); }

// The material of a uniform skin, pressed by what acts at the depth of a class; if signals are spread to it, by the
// greatest pressure on all cells.
struct DeepMaterial {
    PressedMaterial pressed;
    double off = 0;   // the error of the pressure there, relative to its peak
    double least = 0; // the least pressure there that is not 0, Pa; 0 between frames
    // Of spread signals: the sum of all |weights|, the greatest value over the greatest signal, and the error by
    // rounding over the greatest signal.
    double norm = 0, share = 0, rounded = 0;
};

// One material for each class of receptors that lie at a depth and are read; empty for every other class.
using DeepMaterials = std::array<std::optional<DeepMaterial>, REDUCED_MAPS>;

// The materials of the skin, each with the arithmetic of its cell.
struct AnalysedMaterials {
    std::vector<PressedMaterial> pressed;
    DeepMaterials deep;
    std::vector<CountedMaterial> counted; // the same, each with a peak that is not 0 where any of what is read is not
    std::vector<size_t> ends;             // the end of all of them, or of the materials at each place of a series
    model::Chain chain;
    std::vector<CountedMaterial> extremes; // of each part, its least and its greatest retardation time
};

// The least |v| that is not 0.
inline double least_of(const std::vector<double>& map) {
    double least = INFINITY;
    for (double v : map)
        if (v != 0) least = std::min(least, std::abs(v));
    return std::isfinite(least) ? least : 0;
}

// The roundings of spread values by kernels/spread.h, in units of the greatest value that is spread. Down a level there
// are four in each direction. In a stencil's sum there are four of a weight, its nodes' sums and their product, and one
// for each sum of products on the way. Up a level there are three in each direction, and one where both sums meet.
inline double roundings_of(const model::Spread& levels) {
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
inline constexpr size_t ranges = 32;

inline bool too_many(size_t materials, double steps) {
    constexpr double most_cell_steps = 1e5;
    return materials > 2 * ranges && double(materials) * steps > most_cell_steps;
}

inline std::vector<PressedMaterial> representatives(std::vector<PressedMaterial> all) {
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
inline void represent(AnalysedMaterials& m) {
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

inline DeepMaterials deep_materials(const model::PreparedSkin& skin, const model::Schedule& schedule,
                                    const Arithmetic& kind, const Read& read) {
    DeepMaterials deep;
    for (size_t q = 0; q < deep.size(); ++q) {
        if (!schedule.half_space[q] || !(read.everything || read.quantity == int(q))) continue;
        const model::HalfSpace& space = *schedule.half_space[q];
        model::Schedule as = schedule;
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

inline AnalysedMaterials analysed(const model::PreparedSkin& skin, const model::Schedule& schedule,
                                  const Arithmetic& kind, const Read& read) {
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
        for (const model::Element& element : {skin.parts[i].low, skin.parts[i].high})
            m.extremes.push_back({.element = element, .rounding = m.counted[i].rounding, .peak = m.counted[i].peak});
    return m;
}

// The skin with the elements of Schedule::modes in series. A stress that classes follow is a sum of these elements,
// some of them times a share below 0: stepped cell by cell, the series bounds what they are off together.
inline model::PreparedSkin stress_in_series(const model::PreparedSkin& skin, const model::Schedule& schedule) {
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
