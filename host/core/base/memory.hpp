// SPDX-License-Identifier: MIT
// The error of an allocation that fails.
#pragma once

#include "dermis/skin.hpp"

#include <new>
#include <type_traits>

namespace dermis::scene {

// Throws Error::no_memory with the message "out of memory" alone, and allocates nothing.
[[noreturn]] void out_of_memory();

// Throws Error::no_memory in place of the std::bad_alloc that is being handled. what: returns the words that say what
// needed how much. If there is no memory for these words, the message goes without them.
template <class What> [[noreturn]] void out_of_memory(What&& what) {
    try {
        throw Error(Error::Code::no_memory, "", std::string("out of memory: ") + what());
    } catch (const std::bad_alloc&) {
        out_of_memory();
    }
}

// Returns call(), and tells in words what needed how much if there is too little memory. words: text, or what returns
// it.
template <class Words, class Call> decltype(auto) guarded(const Words& words, Call&& call) {
    try {
        return call();
    } catch (const std::bad_alloc&) {
        if constexpr (std::is_invocable_v<const Words&>) out_of_memory(words);
        else out_of_memory([&] { return words; });
    }
}

// "1.34 GB"
std::string bytes_text(double bytes);

std::string grid_text(const Grid&); // "64 x 32 cells"

// What a skin pressed frame by frame needs at least, in bytes and in words.
double bytes_of(const SkinDescription&, const SkinOptions&);
std::string needs_of(const SkinDescription&, const SkinOptions&);

} // namespace dermis::scene
