// SPDX-License-Identifier: MIT
// Parts of validate() that more than one file needs. All throw Error::bad_input.
#pragma once

#include "host/lab/scenes/scene.hpp"

namespace dermis::scene {

// Refuses a map that has another size than the grid or holds a number that is not finite.
void need_map(const char* parameter, const Map&, const Grid&);

// Checks modulus and viscosity of every cell. asked_fa2: whether FA2 has to be defined, with receptors.fa2 as it
// stands.
struct MaterialSurvey {
    std::optional<size_t> elastic; // the last cell without viscosity, or in series with an element without it
    bool spring = false;           // all cells have a spring in series with other elements
    size_t stiffest = 0;           // the cell of the greatest modulus/viscosity
    bool maps = false;             // cells differ
    bool chain = false;            // elements in series

    std::string where(size_t cell, int width) const; // " in cell [x, y]", or nothing
};
MaterialSurvey survey_material(const SkinDescription&);

// Refuses FA2 as a density where some cell has no viscosity.
void check_fa2_density(const SkinDescription&, const MaterialSurvey&);

// Fills the defaults of stencil and edges in, and checks them and the receptors.
void check_curvature_and_receptors(SkinDescription&);

// Checks the method together with the material, stencil, edges, receptors and time step that it is used with, and fills
// the defaults of stencil, edges and receptors.fa2 in. Grid, time and load have been checked before.
void check_method(Scene&);

} // namespace dermis::scene
