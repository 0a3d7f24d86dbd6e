// SPDX-License-Identifier: MIT
// The models `moments` and `maps`. Uniform material under map p times envelope: with g, G, g', g'' of one cell under
// unit pressure, a = p*(1 + l*L(S)) and b = p*l*h*L(p),
//     SA1 = g*(a - g*b)   SA2 = G*(a - g*b)   FA1 = g'*(a - g*b)   FA2 = g''*(a - g*b)
// so means take <p>, <a>, <b>, extremes the convex hull of the points (b, a), and a field one pass. In double.
#pragma once

#include "host/plan/stepper.hpp"
#include "host/reduced/hull.hpp"

namespace dermis::reduced {

// What no change of modulus, viscosity or envelope changes.
struct Moments {
    double p = 0, a = 0, b = 0;     // means over all cells
    double least = 0, greatest = 0; // p
    Hull upper, lower;
    struct Point {
        double p, a, b;
    };
    std::vector<Point> points; // Schedule::points
};
// threads: 0 = one per core. points_only: nothing is asked of the other cells.
std::shared_ptr<const Moments> moments_of(const plan::PreparedSkin&, const plan::Schedule&, bool points_only,
                                          int threads);

// points_only: as for the moments; each site then asks for its own class alone.
std::unique_ptr<plan::Stepper> separable(const plan::PreparedSkin&, const plan::Schedule&,
                                         std::shared_ptr<const Moments>, bool points_only, plan::Stepper::Sink);

} // namespace dermis::reduced
