// SPDX-License-Identifier: MIT
// The description of a skin: checked, with its defaults, and the maps made from it.
#pragma once

#include "dermis/description.hpp"
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

// The classes of receptors, which are the responses, each with its member of Density and of Depths.
struct ReceptorClass {
    Quantity type;
    double Density::*density;
    std::optional<double> Depths::*depth;
};
inline constexpr ReceptorClass receptor_classes[] = {
    {Quantity::sa1, &Density::sa1, &Depths::sa1},
    {Quantity::sa2, &Density::sa2, &Depths::sa2},
    {Quantity::fa1, &Density::fa1, &Depths::fa1},
    {Quantity::fa2, &Density::fa2, &Depths::fa2},
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
// Whether some class of receptors lies at a depth.
inline bool has_depth(const Receptors& receptors) {
    for (const ReceptorClass& c : receptor_classes)
        if (receptors.depth.*c.depth) return true;
    return false;
}

} // namespace dermis::scene
