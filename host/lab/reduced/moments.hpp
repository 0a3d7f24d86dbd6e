// SPDX-License-Identifier: MIT
// The models `moments` and `maps`, for a map p times an envelope. Materials come here in parts; p is the pressure over
// each cell's resistance (model::in_parts). g_k is the strain of one cell of part k under unit pressure, G_k its
// integral, g_k' and g_k'' its derivatives; p_m is p in part m and 0 elsewhere. A cell of part k has a = p*(1 +
// l*L(S)), b_m = p*l*h*L(p_m) and
//     SA1 = g_k*(a - sum of g_m*b_m)    SA2 with G_k, FA1 with g_k', FA2 with g_k'' in the place of the first g_k
// Where the receptors of a class lie at a depth, their response has the stress there in place of the p that stands for
// the cell's own pressure: in a, and as the factor p of b_m.
// Where the load is a sum of products on a uniform skin, each product takes the place of a part: k and m count
// products, and a cell has every product's a and response, whose sum is its response. Means need only the sums of p, a
// and b_m over each part, a field needs one pass, and, with one part, extremes need only the convex hull of the points
// (b, a). All is in double.
#pragma once

#include "host/lab/march/stepper.hpp"
#include "host/lab/reduced/hull.hpp"

namespace dermis::reduced {

// The quantities that do not depend on modulus, viscosity or envelope.
struct Moments {
    // Sums over the cells of a part, divided by the number of all cells.
    struct Means {
        double p = 0, a = 0;
        std::vector<double> b; // of each part m, or product
    };
    struct Point {
        size_t part; // or product
        double p, a;
        std::vector<double> b;
    };
    // Of one map to which quantities answer: the pressure, or the stress at a depth.
    struct Layer {
        Map map;
        std::vector<Means> means;       // of each part
        std::vector<Point> points;      // Schedule::points
        double least = 0, greatest = 0; // range of p; it and the hull only with one part
        Hull upper, lower;
    };
    std::vector<Map> pressures; // of each part, 0 in the cells of others; or of each product
    std::vector<Layer> layers;  // first of the pressure
    std::vector<Cell> cells;    // Schedule::points
    std::array<size_t, REDUCED_MAPS> layer_of{};
    std::vector<Moments> others; // of each of Schedule::others, without `pressures`
    const Moments& product(size_t i) const { return i == 0 ? *this : others[i - 1]; }
    const Layer& of(size_t q) const { return layers[layer_of[q]]; }
};
// threads: 0 = one per core. points_only: of the layers only the points are computed.
std::shared_ptr<const Moments> moments_of(const model::PreparedSkin&, const model::Schedule&, bool points_only,
                                          int threads);

// points_only: as for moments_of(); each site then has only the response of its own class.
std::unique_ptr<model::Stepper> separable(const model::PreparedSkin&, const model::Schedule&,
                                          std::shared_ptr<const Moments>, bool points_only, model::Stepper::Sink);

} // namespace dermis::reduced
