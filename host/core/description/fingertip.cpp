// SPDX-License-Identifier: MIT
// The fingertip of a preset: the numbers of fingertip.md, and its relaxation as a chain. A test compares both.
#include "host/core/base/memory.hpp"

namespace dermis {

SkinDescription fingertip() {
    return scene::guarded("a fingertip's description", [] {
        SkinDescription s;
        s.grid = {.width = 200, .height = 200, .spacing = 5e-5};
        s.surface = {.kind = Surface::Kind::spiral, .noise = 0, .relief = 5e-5, .ridge_period = 5e-4};
        s.material.thickness = 1e-3;
        s.material.curvature_length = 1e-5;
        s.material.elements = {{.modulus = 200000, .viscosity = 0},
                               {.modulus = 634963.54906512087, .viscosity = 3362.9715758383363},
                               {.modulus = 316660.15053150256, .viscosity = 33028.694845613973},
                               {.modulus = 97398.043149064135, .viscosity = 276454.64364500507}};
        return s;
    });
}

Depths fingertip_depths() { return {.sa1 = 3e-4, .sa2 = 1.1e-3, .fa1 = 5e-4, .fa2 = 2e-3}; }

} // namespace dermis
