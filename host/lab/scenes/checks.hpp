// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/description/checks.hpp"
#include "host/lab/scenes/scene.hpp"

namespace dermis::scene {

// Checks the method together with the material, stencil, edges, receptors and time step that it is used with, and fills
// in the defaults of stencil, edges and receptors.fa2. Grid, time and load have been checked before.
void check_method(Scene&);

} // namespace dermis::scene
