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

// Returns this shortest decimal.
inline std::string shortest(double x) {
    std::string text;
    append_shortest(text, x);
    return text;
}

// Returns a text in UTF-8. Of a text longer than `bytes` it returns the whole characters within them, and "..".
inline std::string beginning_of(const std::string& text, size_t bytes) {
    if (text.size() <= bytes) return text;
    while (bytes > 0 && (static_cast<unsigned char>(text[bytes]) & 0xc0) == 0x80) --bytes; // within a character
    return text.substr(0, bytes) + "..";
}

} // namespace dermis
