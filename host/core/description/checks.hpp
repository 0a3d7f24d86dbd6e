// SPDX-License-Identifier: MIT
// Parts of the checks of skins and scenes that more than one file needs. All throw Error::bad_input.
#pragma once

#include "dermis/afferents.hpp"
#include "host/core/description/description.hpp"

namespace dermis::scene {

std::string text_of(Cell);
// Refuses a cell outside the grid.
void need_inside(const std::string& parameter, Cell, const Grid&);

// Check parts of a skin, and fill their defaults in.
void check_grid(const Grid&);
void check_surface(SkinDescription&);
void check_lengths(SkinDescription&);
void check_sites(const SkinDescription&);
// Returns nerve fibres with their models and cells.
std::vector<Afferents> validated_afferents(const SkinDescription&, std::vector<Afferents>);

// Refuses a map that has another size than the grid or holds a number that is not finite.
void need_map(const char* parameter, const Map&, const Grid&);

// What survey_material() finds out while it checks the modulus and viscosity of every cell.
struct MaterialSurvey {
    std::optional<size_t> elastic; // the last cell with an element without viscosity, other than `spring`
    bool spring = false;           // all cells have a spring in series with other elements
    size_t stiffest = 0;           // the cell of the greatest modulus/viscosity
};
MaterialSurvey survey_material(const SkinDescription&);
// Returns " in cell [x, y]", or nothing where all cells have the same material.
std::string where_in(const SkinDescription&, size_t cell);

// Refuses FA2 as a density where some cell has no viscosity.
void check_fa2_density(const SkinDescription&, const MaterialSurvey&);

// Fills in the defaults of stencil and edges, and checks them and the receptors.
void check_curvature_and_receptors(SkinDescription&);

// Refuses the spring of elements in series.
[[noreturn]] void refuse_spring(const Material&, const char* allowed);

} // namespace dermis::scene
