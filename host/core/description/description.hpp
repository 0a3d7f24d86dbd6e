// SPDX-License-Identifier: MIT
// The description of a skin: checked, with its defaults, and the maps made from it.
#pragma once

#include "dermis/afferents.hpp"
#include "host/core/description/element.hpp"

namespace dermis::scene {

// Checks the parameters of a skin that is pressed frame by frame and asked for these responses. Fills in every default,
// except the material's (element_at()); FA2 is by default the mean over a step. Throws Error::bad_input.
SkinDescription validate_skin(const SkinDescription&, const std::vector<Quantity>& asked);

// Checks the elements of another material for a skin that is validated. Throws Error::bad_input.
void check_material(const SkinDescription& validated, const Material&, const std::vector<Quantity>& asked);

// The functions below expect a validated skin.

// Returns width*height heights in units of the relief. threads: as for Device::cpu.
Map surface_heights(const SkinDescription&, int threads);

// Returns the wavelength of the ridges in cells; infinite for a surface without ridges of its own.
double cells_per_ridge(const SkinDescription&);

// The classes of receptors, which are the responses, each with its member of Density, Depths and DepthKernels.
struct ReceptorClass {
    Quantity type;
    double Density::*density;
    std::optional<double> Depths::*depth;
    DepthKernel DepthKernels::*kernel;
};
inline constexpr ReceptorClass receptor_classes[] = {
    {Quantity::sa1, &Density::sa1, &Depths::sa1, &DepthKernels::sa1},
    {Quantity::sa2, &Density::sa2, &Depths::sa2, &DepthKernels::sa2},
    {Quantity::fa1, &Density::fa1, &Depths::fa1, &DepthKernels::fa1},
    {Quantity::fa2, &Density::fa2, &Depths::fa2, &DepthKernels::fa2},
};
// Returns their names, separated by commas.
std::string receptor_class_names();
inline bool is_receptor_class(Quantity q) {
    for (const ReceptorClass& c : receptor_classes)
        if (c.type == q) return true;
    return false;
}

// Whether some class of receptors follows the stress.
inline bool follows_stress(const Receptors& r) {
    return r.follow.sa1 == Signal::stress || r.follow.sa2 == Signal::stress;
}
// Whether nerve fibres follow the stress, by themselves or by their class.
inline bool follows_stress(const Receptors& r, const Afferents& a) {
    return a.follow == Signal::stress || (a.type == Quantity::sa1 && r.follow.sa1 == Signal::stress) ||
           (a.type == Quantity::sa2 && r.follow.sa2 == Signal::stress);
}
// Whether what acts at a depth depends on Poisson's ratio, for some class.
inline bool reads_poisson(const Receptors& receptors) {
    for (const ReceptorClass& c : receptor_classes)
        if (receptors.kernel.*c.kernel != DepthKernel::stress) return true;
    return false;
}
// Whether some class of receptors lies at a depth.
inline bool has_depth(const Receptors& receptors) {
    for (const ReceptorClass& c : receptor_classes)
        if (receptors.depth.*c.depth) return true;
    return false;
}

// Parts of the checks of skins and scenes that more than one file needs. All throw Error::bad_input.

std::string text_of(Cell);
// Refuses a cell outside the grid.
void need_inside(const std::string& parameter, Cell, const Grid&);

// Check parts of a skin, and fill their defaults in.
void check_grid(const Grid&);
void check_surface(SkinDescription&);
void check_lengths(SkinDescription&);
void check_sites(const SkinDescription&);
// Returns the cells of the sites of a class.
std::vector<Cell> cells_of(Quantity type, const std::vector<Site>&);

// Returns afferents with their models, and the cells of their endings in place of a radius.
std::vector<Afferents> validated_afferents(const SkinDescription&, std::vector<Afferents>);
// Draws the endings of afferents that have a radius around the middles, one afferent after the other.
std::vector<Cell> endings_around(const std::vector<Cell>& middles, const Afferents&, const Grid&);
// The factors s of validated afferents, which are drawn.
std::vector<double> drawn_factors(const Afferents&);
// The sensitivity of afferents of a class whose thresholds were measured; 1: the class has no parameters.
double threshold_sensitivity(Quantity);

// Refuses a map that has another size than the grid or holds a number that is not finite.
void need_map(const char* parameter, const Map&, const Grid&);

// The result of survey_material(), which checks the modulus and viscosity of every cell.
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
