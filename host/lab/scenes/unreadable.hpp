// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace dermis::scene {

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
