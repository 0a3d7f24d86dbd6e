// SPDX-License-Identifier: MIT
// The text of kernels/*.h as C++: f32 is the arithmetic that a device must reproduce bit for bit, f64 the arithmetic of
// the host and of references. A class template over K = f32 or f64 works in either.
#pragma once

#include <cmath>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <glm/vector_relational.hpp>
#include <type_traits>

#ifdef __FAST_MATH__
#error "-ffast-math changes results; build dermis without it"
#endif

namespace dermis {
namespace kernels {

// The GLSL functions that the kernels use.
using glm::abs;
using glm::lessThan;
using glm::max;
using glm::min;
using glm::mix;
using std::abs; // this one of scalars has no branch, so that loops vectorise
template <class T, class = std::enable_if_t<std::is_floating_point_v<T>>> inline bool lessThan(T a, T b) {
    return a < b;
}

struct f32 {
    using real = float;
    using scalar = float;
#include "kernels/model.h"
};

struct f64 {
    using real = double;
    using scalar = double;
#include "kernels/model.h"
};

} // namespace kernels

using kernels::f32;
using kernels::f64;

} // namespace dermis
