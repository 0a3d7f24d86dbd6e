// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/base/text.hpp"

#include <cmath>
#include <string>

#include <fmt/format.h>

namespace dermis::output {

// Returns a text in quotes.
inline std::string json_text(const std::string& text) {
    std::string out = "\"";
    for (char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (static_cast<unsigned char>(c) < 32) out += fmt::format("\\u{:04x}", c);
        else out += c;
    }
    return out + '"';
}

// Returns "null" for a number that JSON does not have.
inline std::string json_number(double x) { return std::isfinite(x) ? shortest(x) : "null"; }

} // namespace dermis::output
