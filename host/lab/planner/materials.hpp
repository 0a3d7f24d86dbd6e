// SPDX-License-Identifier: MIT
// The materials that an analysis of errors steps, one cell of each: those of the skin, those that receptors at a depth
// have, and those that stand for a stress which classes follow.
#pragma once

#include "host/lab/planner/bound.hpp"
#include "host/lab/planner/counted_run.hpp"
#include "host/lab/planner/magnitudes.hpp"

#include <optional>

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
DeepMaterials deep_materials(const model::PreparedSkin&, const model::Schedule&, const Arithmetic&, const Read&);

// The materials of the skin, each with the arithmetic of its cell.
struct AnalysedMaterials {
    std::vector<PressedMaterial> pressed;
    DeepMaterials deep;
    std::vector<CountedMaterial> counted; // the same, each with a peak that is not 0 where any of what is read is not
    std::vector<size_t> ends;             // the end of all of them, or of the materials at each place of a series
    model::Chain chain;
    std::vector<CountedMaterial> extremes; // of each part, its least and its greatest retardation time
};

AnalysedMaterials analysed(const model::PreparedSkin&, const model::Schedule&, const Arithmetic&, const Read&);

// The skin with the elements of Schedule::modes in series. A stress that classes follow is a sum of these elements,
// some of them times a share below 0: stepped cell by cell, the series bounds what they are off together.
model::PreparedSkin stress_in_series(const model::PreparedSkin&, const model::Schedule&);

} // namespace dermis::planner
