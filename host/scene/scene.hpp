// SPDX-License-Identifier: MIT
// From a description to checked numbers and maps.
#pragma once

#include "dermis/dermis.hpp"

namespace dermis::scene {

// Checks every parameter and fills every default in; throws Error::bad_input.
Scene validated(const Scene&);

long long outputs(const Time&); // rows of the traces

// width*height, from a validated scene
std::vector<double> surface_map(const Scene&);
std::vector<double> pressure_map(const Scene&);

// A .npy file of float32 or float64, row-major, of exactly this shape. Throws Error::bad_input naming `parameter`.
std::vector<double> read_npy(const std::string& path, int width, int height, const std::string& parameter);

} // namespace dermis::scene
