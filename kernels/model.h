// SPDX-License-Identifier: MIT
// The whole model, for C++. The includer opens a struct that defines the types `real` and `scalar`; the functions become
// its static functions (see prelude.h and host/core/simd/model.hpp). There is no include guard, on purpose.
#define inline static inline
#include "prelude.h"
#include "layout.h"
#include "step.h"
#include "cell.h"
#include "responses.h"
#include "curvature.h"
#include "reduce.h"
#include "spread.h"
#undef inline
#undef precise
#undef OF_ANY_CELL
