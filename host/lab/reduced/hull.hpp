// SPDX-License-Identifier: MIT
// Convex hulls of points (b, a), for the extremes of a - g*b.
#pragma once

#include "host/core/simd/isa.hpp"

namespace dermis::reduced {

struct Vertex {
    double b, a;
};

// Upper and lower convex hull of the points (b[i], a[i]), which lie between `least` and `greatest` in b. (0, 0), the
// point of every cell that is not pressed, is entered once. The lower hull comes with the sign of a reversed.
struct HullSides {
    std::vector<Vertex> upper, lower;
    HullSides(const double* b, const double* a, size_t n, double least, double greatest);
};

// One side of a hull, ascending in b, with the slopes from each vertex to the next, which descend (upper) or ascend.
struct Hull {
    std::vector<Vertex> vertices;
    std::vector<double> slopes;
};
// The hull of one side of HullSides. sign: 1 upper, -1 lower.
Hull with_slopes(const std::vector<Vertex>&, double sign);
// The greatest (sign 1) or least (-1) a - g*b over the hull.
double extreme(const Hull&, double g, double sign);

// A polygon inscribed in the hull: a point inside it cannot be a vertex. Empty if the hull is degenerate.
std::vector<simd::HalfPlane> inscribed_polygon(const HullSides&);

} // namespace dermis::reduced
