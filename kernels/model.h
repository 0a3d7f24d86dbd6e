// SPDX-License-Identifier: MIT
// The whole model, for C++: included inside a namespace that has `real` (see prelude.h); no include guard on purpose.
using glm::abs;
using std::abs; // for scalars: no branch, so loops vectorize
using glm::lessThan;
using glm::max;
using glm::min;
using glm::mix;
template <class T, class = std::enable_if_t<std::is_floating_point_v<T>>>
inline bool lessThan(T a, T b) {
    return a < b;
}
#include "prelude.h"
namespace layout { // apart, so that other instances of the functions below can take its structs
#include "layout.h"
}
using namespace layout;
#include "press.h"
#include "curvature.h"
#include "reduce.h"
#undef precise
