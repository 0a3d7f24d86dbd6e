// SPDX-License-Identifier: MIT
// kernels/*.h as C++: f32 is what a device must reproduce bit for bit, f64 is what the host computes and the truth.
#pragma once

#include <cmath>
#include <glm/common.hpp>
#include <glm/vec4.hpp>
#include <glm/vector_relational.hpp>
#include <type_traits>

#ifdef __FAST_MATH__
#error "-ffast-math changes results; build dermis without it"
#endif

namespace dermis::f32 {
using real = float;
using scalar = float;
#include "kernels/model.h"
} // namespace dermis::f32

namespace dermis::f64 {
using real = double;
using scalar = double;
#include "kernels/model.h"
} // namespace dermis::f64
