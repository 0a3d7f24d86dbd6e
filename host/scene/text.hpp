// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <string>

namespace dermis {

// Returns the shortest decimal that reads back as the same double.
inline std::string shortest(double x) {
    char text[32];
    return std::string(text, std::to_chars(text, text + sizeof text, x).ptr);
}

} // namespace dermis
