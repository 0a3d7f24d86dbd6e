// SPDX-License-Identifier: MIT
// The whole model, for C++: included inside a struct that says what `real` and `scalar` are, whose static functions it
// becomes (see prelude.h and host/simd/model.hpp). No include guard on purpose.
#define inline static inline
#include "prelude.h"
#include "layout.h"
#include "step.h"
#include "responses.h"
#include "curvature.h"
#include "reduce.h"
#undef inline
#undef precise
