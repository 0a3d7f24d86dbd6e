// SPDX-License-Identifier: MIT
// Reads files, but only regular ones: a device, a pipe or a socket may never end; and finds what no scene has in a
// text.
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

inline constexpr size_t most_levels = 32; // of tables and lists; a scene has four
inline const std::string too_deep =
    "tables and lists are too deep; allowed: " + std::to_string(most_levels) + " levels";

// A line of a TOML text that the parser must not see, and what is wrong with it; line 0 if there is none.
struct Unreadable {
    int line = 0;
    std::string why;
    bool deep = false;
};

// Finds the first line with something that a scene never has and that the parser does not survive. The parser recurses,
// and exhausts the stack if brackets, or the parts of a dotted key, are too deep. Its behaviour is undefined for a
// table without a name and for a bracket that another kind of bracket closes; and, outside of quotes and comments, for
// some values that are no number and for characters that are not ASCII, which a backslash at a line's end brings into a
// text too. A quote where no text begins would hide all this.
Unreadable unreadable(const std::string& text);

} // namespace dermis::scene
