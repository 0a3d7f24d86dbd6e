// SPDX-License-Identifier: MIT
// The fuzzers share this. Each target reads bytes as one reader of the project does: it may refuse them by an Error, of
// one line that says why, or take them. All else, and each finding of a sanitizer, is a failure.
#pragma once

#include "dermis/dermis.hpp"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

namespace fuzz {

inline void need(bool holds, const std::string& what) {
    if (holds) return;
    std::fprintf(stderr, "fuzz: %s\n", what.c_str());
    std::abort();
}

inline void need_one_line(const std::string& text) {
    need(!text.empty(), "an error without a message");
    for (char c : text) need(static_cast<unsigned char>(c) >= 32, "a message with a control character: " + text);
}

// Returns whether the bytes were taken.
template <class Read> bool taken(Read&& read) {
    try {
        read();
        return true;
    } catch (const dermis::Error& e) {
        need_one_line(e.what());
        return false;
    }
}

// Splits bytes at each 0, into at least one text.
inline std::vector<std::string> texts(const uint8_t* data, size_t size) {
    std::vector<std::string> all(1);
    for (size_t i = 0; i < size; ++i)
        if (data[i]) all.back() += char(data[i]);
        else all.emplace_back();
    return all;
}

// Puts bytes into a file in memory, always the same one, and returns its path.
inline const std::string& file_of(const uint8_t* data, size_t size) {
    static const int file = memfd_create("fuzz", 0);
    static const std::string path = "/proc/self/fd/" + std::to_string(file);
    need(ftruncate(file, 0) == 0 && pwrite(file, data, size, 0) == ssize_t(size), "no file in memory");
    return path;
}

// Returns whether a scene asks for receptors by density on a grid in metres, which may be 4e8 of them.
inline bool may_be_crowded(const std::string& scene) {
    const auto has = [&](const char* word) { return scene.find(word) != scene.npos; };
    return has("sites") && (has("spacing") || has("preset"));
}

} // namespace fuzz
