// SPDX-License-Identifier: MIT
// The whole model, for C++: included inside a namespace that has `real` (see prelude.h); no include guard on purpose.
#include "prelude.h"
#include "layout.h"
#include "press.h"
#include "curvature.h"
#include "reduce.h"
#undef precise
