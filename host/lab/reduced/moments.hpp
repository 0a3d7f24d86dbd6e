// SPDX-License-Identifier: MIT
// The models `moments` and `maps`, for a map p times an envelope. Materials come here in parts, p being the pressure
// over each cell's resistance (plan::in_parts). With strain g, its integral G and its derivatives g', g'' of one cell
// of each part under unit pressure, a = p*(1 + l*L(S)) and b_m = p*l*h*L(p_m), where p_m is p in part m and 0
// elsewhere, in a cell of part k
//     SA1 = g_k*(a - sum of g_m*b_m)    SA2 with G_k, FA1 with g_k', FA2 with g_k'' in the place of the first g_k
// so that means need only the sums of p, a and b_m over each part, a field one pass, and under one part extremes the
// convex hull of the points (b, a). All is in double.
#pragma once

#include "host/lab/march/stepper.hpp"
#include "host/lab/reduced/hull.hpp"

namespace dermis::reduced {

// The quantities that do not depend on modulus, viscosity or envelope.
struct Moments {
    // Sums over the cells of a part, by the number of all cells.
    struct Means {
        double p = 0, a = 0;
        std::vector<double> b; // of each part m
    };
    struct Point {
        size_t part;
        double p, a;
        std::vector<double> b;
    };
    std::vector<Map> pressures;     // of each part, 0 in the cells of others
    std::vector<Means> means;       // of each part
    std::vector<Point> points;      // Schedule::points
    double least = 0, greatest = 0; // range of p; this and the hull under one part alone
    Hull upper, lower;
};
// threads: 0 = one per core. points_only: only Moments::points is computed.
std::shared_ptr<const Moments> moments_of(const plan::PreparedSkin&, const plan::Schedule&, bool points_only,
                                          int threads);

// points_only: the moments are so, and each site has only the response of its own class.
std::unique_ptr<plan::Stepper> separable(const plan::PreparedSkin&, const plan::Schedule&,
                                         std::shared_ptr<const Moments>, bool points_only, plan::Stepper::Sink);

} // namespace dermis::reduced
