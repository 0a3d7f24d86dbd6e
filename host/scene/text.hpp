// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <string>

namespace dermis {

// Appends the shortest decimal that reads back as the same double.
inline void append_shortest(std::string& out, double x) {
    char text[32];
    out.append(text, std::to_chars(text, text + sizeof text, x).ptr);
}

// Returns that decimal.
inline std::string shortest(double x) {
    std::string text;
    append_shortest(text, x);
    return text;
}

} // namespace dermis
