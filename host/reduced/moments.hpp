// SPDX-License-Identifier: MIT
// The models `moments` and `maps`. Uniform material under map p times envelope: with g, G, g', g'' of one cell under
// unit pressure, a = p*(1 + l*L(S)) and b = p*l*h*L(p),
//     SA1 = g*(a - g*b)   SA2 = G*(a - g*b)   FA1 = g'*(a - g*b)   FA2 = g''*(a - g*b)
// so means take <p>, <a>, <b>, extremes the convex hull of the points (b, a), and a field one pass. In double.
#pragma once

#include "host/plan/stepper.hpp"

#include <memory>

namespace dermis::reduced {

// What no change of modulus, viscosity or envelope changes.
struct Moments {
    double p = 0, a = 0, b = 0;     // means over all cells
    double least = 0, greatest = 0; // p
    struct Point {
        double b, a;
    };
    struct Hull {                   // one side of it
        std::vector<Point> points;  // ascending in b
        std::vector<double> slopes; // from each to the next
    };
    Hull upper, lower;
    struct Place {
        double p, a, b;
    };
    std::vector<Place> places; // of Plan::points
};
// threads: 0 = one per core.
std::shared_ptr<const Moments> moments_of(const plan::Plan&, int threads);

std::unique_ptr<plan::Stepper> separable(const plan::Plan&, std::shared_ptr<const Moments>, plan::Stepper::Sink);

} // namespace dermis::reduced
