// SPDX-License-Identifier: MIT
// Tells files that can be read to their end from what only has a file's name, and reads them.
#pragma once

#include <cstdint>
#include <istream>
#include <string>

namespace dermis::scene {

// Returns the reason why a path is no regular file of at most so many bytes: missing, a directory, or a device, pipe or
// socket, which may never end. Empty if it is one. Nothing is opened.
std::string why_no_file(const std::string& path, uintmax_t most_bytes = UINTMAX_MAX);

// Reads a whole file. Returns false, with errno, where that fails.
bool read_file(const std::string& path, std::string& content);

// A stream swallows a std::bad_alloc, and what it read or wrote then seems to end there. This one throws it on.
template <class Stream> Stream throwing(Stream stream) {
    stream.exceptions(std::ios::badbit);
    return stream;
}
// Reads bytes from a stream that throws. Returns false where the file ends before or fails.
bool read_bytes(std::istream&, char* to, std::streamsize bytes);

} // namespace dermis::scene
