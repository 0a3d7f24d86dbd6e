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

// Finds the first line with something that a scene never has and the parser is not safe from. Where brackets, or the
// parts of a dotted key, are too deep it exhausts the stack, because it recurses, and so do its tables. What it does is
// undefined where a table has no name, where a bracket is closed by one of another kind, and with some values that are
// no number, and characters that are not ASCII, outside of quotes and comments. A quote where no text begins would hide
// these.
Unreadable unreadable(const std::string& text);

} // namespace dermis::scene
