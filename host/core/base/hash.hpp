// SPDX-License-Identifier: MIT
// The hash FNV-1a of Fowler, Noll and Vo.
#pragma once

#include <cstdint>

namespace dermis {

inline constexpr uint32_t fnv1a_32 = 2166136261u; // the hash of no bytes
inline constexpr uint64_t fnv1a_64 = 14695981039346656037u;

// Returns the hash of one more byte after the bytes of `hash`.
inline uint32_t fnv1a(uint32_t hash, unsigned char byte) { return (hash ^ byte) * 16777619u; }
inline uint64_t fnv1a(uint64_t hash, unsigned char byte) { return (hash ^ byte) * 1099511628211u; }

} // namespace dermis
