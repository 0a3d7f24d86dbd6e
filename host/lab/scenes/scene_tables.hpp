// SPDX-License-Identifier: MIT
#pragma once

#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/toml.hpp"

namespace dermis::scene {

// Reads a Scene from the tables of a scene file. Paths in the file are relative to `folder`, unless they are names in
// `maps`, and are appended to `files`; a map that is in `read` is not read again. Checks keys and types; validate()
// checks ranges and fills in the defaults. Throws Error::bad_input.
Scene read_tables(const toml::table& file, const std::filesystem::path& folder, const NamedMaps& maps, FileMaps& read,
                  std::vector<std::string>& files);

} // namespace dermis::scene
