// SPDX-License-Identifier: MIT
// Parts of validate() that more than one file needs. All throw Error::bad_input.
#pragma once

#include "host/scene/scene.hpp"

namespace dermis::scene {

// Refuses a map that has another size than the grid or holds a number that is not finite.
void need_map(const char* parameter, const Map&, const Grid&);

// Checks the method together with the material, stencil, edges, receptors and time step that it is used with, and fills
// the defaults of stencil, edges and receptors.fa2 in. Grid, time and load have been checked before.
void check_method(Scene&);

// Opens the file of a sequence, whose parameters have been checked; null with any other load.
std::shared_ptr<NpyFile> open_frames(const Scene&);

} // namespace dermis::scene
