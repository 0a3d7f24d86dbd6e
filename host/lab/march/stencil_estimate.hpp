// SPDX-License-Identifier: MIT
// The estimated error of the five-point stencil.
#pragma once

#include "host/core/model/skin.hpp"

namespace dermis::plan {

// The error |C5 - C4| of a five-point curvature, for the skin under the strain shape*scale.
struct StencilEstimate {
    double greatest = 0;  // greatest |C5 - C4|, 1/m
    double curvature = 0; // greatest |C| by the skin's own stencil, at rest or under the strain, 1/m
    long long kinks = 0;  // cells where |C5 - C4| exceeds |C|/2, which no refinement mends
};
StencilEstimate stencil_estimate(const PreparedSkin&, const std::vector<double>& shape, double scale);

} // namespace dermis::plan
