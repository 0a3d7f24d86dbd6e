// SPDX-License-Identifier: MIT
// Nerve fibres of one kind: the constants of their steps.
#pragma once

#include "dermis/afferents.hpp"
#include "host/core/simd/model.hpp"

namespace dermis::plan {

// How closely a step of fibres follows the continuous model.
struct FibreAccuracy {
    double tolerance;  // s: of the time of a spike
    double resolution; // most that a substep may be of the shortest time constant
};
template <class K> constexpr FibreAccuracy fibre_accuracy = {.tolerance = 1e-6, .resolution = 1};
template <> inline constexpr FibreAccuracy fibre_accuracy<f64> = {.tolerance = 1e-12, .resolution = 0.25};

// Substeps of a step of dt seconds: a power of two, so that a refractory time lasts for a substep at least; 0: more
// than a step may have.
int fibre_substeps(const AfferentModel&, double dt, const FibreAccuracy&);
// Fills in the constants of a step of dt seconds. Returns false where a substep is one too many, or where a constant
// does not fit a number of K.
template <class K> bool fill_fibre_constants(const AfferentModel&, double dt, typename K::FibreConstants&);

} // namespace dermis::plan
