// SPDX-License-Identifier: MIT
// Tells files that can be read to their end from what only has a file's name.
#pragma once

#include <cstdint>
#include <string>

namespace dermis::scene {

// Returns the reason why a path is no regular file of at most so many bytes: missing, a directory, or a device, pipe or
// socket, which may never end. Empty if it is one. Nothing is opened.
std::string why_no_file(const std::string& path, uintmax_t most_bytes = UINTMAX_MAX);

} // namespace dermis::scene
