// SPDX-License-Identifier: MIT
// The text of kernels/*.h in long double, by which the planner measures what coefficients in double are off by. Where
// long double is double, what remains is the bound of its own roundings.
#pragma once

#include "host/core/simd/model.hpp"

#include <limits>

namespace dermis {
namespace kernels {

struct extended {
    using real = long double;
    using scalar = long double;
#include "kernels/model.h"
};

} // namespace kernels

using kernels::extended;

// The unit roundoff of double, and what counts as that of references: with more digits, some times more than is true.
inline constexpr double unit_of_double = 0x1p-53;
inline constexpr double unit_of_reference = std::numeric_limits<long double>::digits > 53 ? 0x1p-60 : unit_of_double;

} // namespace dermis
