// SPDX-License-Identifier: MIT
// Reads files, but only regular ones: a device, a pipe or a socket may never end.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

namespace dermis::scene {

// Returns the reason why a path is no regular file of at most `most_bytes`: missing, a directory, or a device, pipe or
// socket. Empty if it is one. Nothing is opened.
std::string why_no_file(const std::string& path, uintmax_t most_bytes = UINTMAX_MAX);

// Reads a whole regular file of at most `most_bytes`. Returns the reason where that fails, and nothing otherwise.
std::string read_file(const std::string& path, std::string& content, uintmax_t most_bytes = UINTMAX_MAX);

// Opens a regular file of at most `most_bytes` in a stream that throws. Returns the reason where that fails.
std::string open_file(const std::string& path, std::ifstream& in, uintmax_t most_bytes = UINTMAX_MAX);

// A stream hides a std::bad_alloc: its data then seem to end. The stream that this returns throws it on.
template <class Stream> Stream throwing(Stream stream) {
    stream.exceptions(std::ios::badbit);
    return stream;
}
// Reads bytes from a stream that throws. Returns false where the file ends before or fails.
bool read_bytes(std::istream&, char* to, std::streamsize bytes);

} // namespace dermis::scene
