// SPDX-License-Identifier: MIT
// Scenes of the oracle as files that `dermis run` reads.
#pragma once

#include "tests/oracle/exact.hpp"

#include <filesystem>

namespace oracle {

// Writes scene.toml, its maps and its frames into a folder, which is made where it is missing.
void write_case(const Case&, const std::filesystem::path& folder);
// Reads a scene of any kind of surface and load, with its maps.
Case read_case(const std::filesystem::path& scene);
// A scene with the maps that its kinds of surface and load stand for.
Case with_maps(dermis::Scene);

// Writes frames of width*height as one .npy file of double.
void write_frames(const std::filesystem::path&, const dermis::Grid&, const std::vector<std::vector<double>>& frames);

} // namespace oracle
