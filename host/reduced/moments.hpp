// SPDX-License-Identifier: MIT
// The models `moments` and `maps`, for a uniform material under a map p times an envelope. A material of one
// retardation time comes here as a uniform one, p being the pressure over each cell's stiffness (plan::as_uniform).
// With strain g, its integral G and its derivatives g', g'' of one cell under unit pressure, a = p*(1 + l*L(S)) and b =
// p*l*h*L(p),
//     SA1 = g*(a - g*b)   SA2 = G*(a - g*b)   FA1 = g'*(a - g*b)   FA2 = g''*(a - g*b)
// so that means need only <p>, <a>, <b>, extremes the convex hull of the points (b, a), and a field one pass. All is in
// double.
#pragma once

#include "host/plan/stepper.hpp"
#include "host/reduced/hull.hpp"

namespace dermis::reduced {

// The quantities that do not depend on modulus, viscosity or envelope.
struct Moments {
    double p = 0, a = 0, b = 0;     // means over all cells
    double least = 0, greatest = 0; // range of p
    Hull upper, lower;
    struct Point {
        double p, a, b;
    };
    std::vector<Point> points; // Schedule::points
};
// threads: 0 = one per core. points_only: only Moments::points is computed.
std::shared_ptr<const Moments> moments_of(const plan::PreparedSkin&, const plan::Schedule&, bool points_only,
                                          int threads);

// points_only: the moments are so, and each site has only the response of its own class.
std::unique_ptr<plan::Stepper> separable(const plan::PreparedSkin&, const plan::Schedule&,
                                         std::shared_ptr<const Moments>, bool points_only, plan::Stepper::Sink);

} // namespace dermis::reduced
