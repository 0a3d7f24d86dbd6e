// SPDX-License-Identifier: MIT
// The text of kernels/*.h in long double. The planner measures the errors of coefficients in double by it. Where long
// double has the digits of double, only the bound of its own roundings is left.
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

// The unit roundoff of double, and the one assumed of references: with more digits, some times the true one.
inline constexpr double unit_of_double = 0x1p-53;
inline constexpr double unit_of_reference = std::numeric_limits<long double>::digits > 53 ? 0x1p-60 : unit_of_double;

} // namespace dermis
