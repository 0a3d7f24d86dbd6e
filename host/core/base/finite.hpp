// SPDX-License-Identifier: MIT
// Tests the bits of the exponent, so that no compiler flag about NaN and infinity changes the result.
#pragma once

#include <bit>
#include <cstdint>

namespace dermis {

inline bool finite(double x) { return (std::bit_cast<uint64_t>(x) >> 52 & 0x7ff) != 0x7ff; }

// Returns a number whose sign bit is set if the float or double with these bits is an infinity or a NaN: an exponent of
// all ones carries into the sign bit, and no other exponent does. Loops that join such numbers by `or` vectorise.
inline uint32_t not_finite(uint32_t bits) { return (bits & 0x7f800000u) + 0x00800000u; }
inline uint64_t not_finite(uint64_t bits) { return (bits & 0x7ff0000000000000u) + 0x0010000000000000u; }
inline bool any_not_finite(uint32_t joined) { return joined >> 31 != 0; }
inline bool any_not_finite(uint64_t joined) { return joined >> 63 != 0; }

} // namespace dermis
