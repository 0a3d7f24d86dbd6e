// SPDX-License-Identifier: MIT
// The fingertip of a preset. Its numbers stand with their sources in fingertip.md; a test compares both.
#include "dermis/scene.hpp"
#include "host/core/base/memory.hpp"

namespace dermis {

Scene fingertip() {
    return scene::guarded("a fingertip's scene", [&] {
        Scene s;
        s.grid = {.width = 200, .height = 200, .spacing = 5e-5};
        s.surface = {.kind = Surface::Kind::spiral, .noise = 0, .relief = 5e-5, .ridge_period = 5e-4};
        s.material.thickness = 1e-3;
        s.material.curvature_length = 1e-5;
        s.material.elements = chain_of({.moduli = {5e4, 5e4, 5e4}, .times = {0.004, 0.07, 1.4}, .equilibrium = 5e4});
        return s;
    });
}

} // namespace dermis
