// SPDX-License-Identifier: MIT
#pragma once

#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/toml.hpp"

namespace dermis::scene {

// Reads a Scene from the tables of a scene file. Paths in the file are relative to `folder`, but for the names of
// `maps`, and each that is named is appended to `files`; a map that is in `read` is not read again. Checks keys and
// types; validate() checks ranges and fills the defaults in. Throws Error::bad_input.
Scene read_tables(const toml::table& file, const std::filesystem::path& folder, const NamedMaps& maps, FileMaps& read,
                  std::vector<std::string>& files);

} // namespace dermis::scene
