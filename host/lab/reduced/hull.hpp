// SPDX-License-Identifier: MIT
// Convex hulls of points (b, a), for the extremes of a - g*b.
#pragma once

#include "host/core/simd/isa.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace dermis::reduced {

struct Vertex {
    double b, a;
};

// The height of p above the line from one vertex to another, times the line's length.
inline double above(const Vertex& from, const Vertex& to, const Vertex& p) {
    return (p.a - from.a) * (to.b - from.b) - (p.b - from.b) * (to.a - from.a);
}

// Quickhull with branch-free partitioning. Of the points above a line between two vertices the highest is a vertex, and
// the points not above the two lines to it are inside. `scratch` has room for n points.
inline void add_between(std::vector<Vertex>& vertices, Vertex from, Vertex to, Vertex* points, size_t n,
                        Vertex* scratch) {
    if (n == 0) return;
    Vertex top = points[0];
    double highest = above(from, to, top);
    for (size_t i = 1; i < n; ++i)
        if (const double height = above(from, to, points[i]); height > highest) highest = height, top = points[i];
    size_t left = 0, right = 0;
    for (size_t i = 0; i < n; ++i) {
        const Vertex p = points[i];
        scratch[right] = p;
        points[left] = p;
        left += (above(from, top, p) > 0) & (p.b < top.b); // rounding may take another than the highest for the top
        right += (above(top, to, p) > 0) & (p.b > top.b);
    }
    add_between(vertices, from, top, points, left, scratch + right);
    vertices.push_back(top);
    add_between(vertices, top, to, scratch, right, points);
}

inline std::vector<Vertex> side(Vertex from, Vertex to, Vertex* points, size_t n, Vertex* scratch) {
    std::vector<Vertex> vertices = {from};
    add_between(vertices, from, to, points, n, scratch);
    if (to.b > from.b) vertices.push_back(to);
    return vertices;
}

// The binary exponent of a greatest magnitude: over its power of two, products of differences stay in range.
inline int exponent_of(double greatest) {
    int exponent = 0;
    std::frexp(greatest, &exponent);
    return std::clamp(exponent, -1000, 1000);
}

// Upper and lower convex hull of the points (b[i], a[i]), which lie between `least` and `greatest` in b. (0, 0), the
// point of every cell that is not pressed, is entered once. The lower hull comes with the sign of a reversed.
struct HullSides {
    std::vector<Vertex> upper, lower;
    HullSides(const double* b, const double* a, size_t n, double least, double greatest) {
        const std::unique_ptr<Vertex[]> over(new Vertex[n + 2]), under(new Vertex[n + 2]), scratch(new Vertex[n + 2]);
        double most = 0;
        for (size_t i = 0; i < n; ++i) most = std::max(most, std::abs(a[i]));
        const double of_a = std::ldexp(1, -exponent_of(most)),
                     of_b = std::ldexp(1, -exponent_of(std::max(std::abs(least), std::abs(greatest))));
        Vertex from{least * of_b, -INFINITY}, to{greatest * of_b, -INFINITY}, from_low = from, to_low = to;
        from_low.a = to_low.a = INFINITY;
        for (size_t i = 0; i < n; ++i) {
            const double height = a[i] * of_a;
            if (b[i] == least) from.a = std::max(from.a, height), from_low.a = std::min(from_low.a, height);
            if (b[i] == greatest) to.a = std::max(to.a, height), to_low.a = std::min(to_low.a, height);
        }
        size_t high = 0, low = 0;
        bool unpressed = false;
        for (size_t i = 0; i < n; ++i) {
            const Vertex p{b[i] * of_b, a[i] * of_a};
            const bool zero = (p.a == 0) & (p.b == 0);
            over[high] = p;
            high += (above(from, to, p) > 0) & !zero;
            under[low] = {p.b, -p.a};
            low += (above(from_low, to_low, p) < 0) & !zero;
            unpressed |= zero;
        }
        if (unpressed && above(from, to, {0, 0}) > 0) over[high++] = {0, 0};
        if (unpressed && above(from_low, to_low, {0, 0}) < 0) under[low++] = {0, 0};
        upper = side(from, to, over.get(), high, scratch.get());
        lower = side({from_low.b, -from_low.a}, {to_low.b, -to_low.a}, under.get(), low, scratch.get());
        for (std::vector<Vertex>* vertices : {&upper, &lower})
            for (Vertex& v : *vertices) v = {v.b / of_b, v.a / of_a};
    }
};

// One side of a hull, ascending in b, with the slopes from each vertex to the next, which descend (upper) or ascend.
struct Hull {
    std::vector<Vertex> vertices;
    std::vector<double> slopes;
};
// The hull of one side of HullSides. sign: 1 upper, -1 lower.
// A vertex is left out if the slope from it to the next one turns the wrong way, as between vertices that are one point
// up to rounding.
inline Hull with_slopes(const std::vector<Vertex>& vertices, double sign) {
    const auto slope = [](const Vertex& p, const Vertex& q) { return (q.a - p.a) / (q.b - p.b); };
    Hull hull;
    for (Vertex p : vertices) {
        p.a *= sign;
        while (!hull.slopes.empty() && sign * slope(hull.vertices.back(), p) > sign * hull.slopes.back()) {
            hull.vertices.pop_back();
            hull.slopes.pop_back();
        }
        if (!hull.vertices.empty()) hull.slopes.push_back(slope(hull.vertices.back(), p));
        hull.vertices.push_back(p);
    }
    return hull;
}

// The greatest (sign 1) or least (-1) a - g*b over the hull.
inline double extreme(const Hull& hull, double g, double sign) {
    const auto edge = std::partition_point(hull.slopes.begin(), hull.slopes.end(),
                                           [=](double slope) { return sign * slope > sign * g; });
    const Vertex& p = hull.vertices[size_t(edge - hull.slopes.begin())];
    return p.a - g * p.b;
}

// A polygon inscribed in the hull: a point inside it cannot be a vertex. Empty if the hull is degenerate.
inline std::vector<simd::HalfPlane> inscribed_polygon(const HullSides& sides) {
    std::vector<Vertex> all = sides.upper, polygon; // clockwise
    for (size_t i = sides.lower.size(); i-- > 0;) {
        const Vertex p{sides.lower[i].b, -sides.lower[i].a};
        if (p.b != all.back().b || p.a != all.back().a) all.push_back(p);
    }
    const size_t n = std::min(size_t(simd::polygon_edges), all.size());
    for (size_t i = 0; i < n; ++i) polygon.push_back(all[i * all.size() / n]);
    double across = 0, up = 0;
    for (const Vertex& p : polygon) across = std::max(across, std::abs(p.b)), up = std::max(up, std::abs(p.a));
    const int scale = -exponent_of(across) - exponent_of(up);
    std::vector<simd::HalfPlane> edges;
    for (size_t i = 0; n > 2 && i < simd::polygon_edges; ++i) { // the last edge repeats up to polygon_edges
        const Vertex &p = polygon[std::min(i, n - 1)], &next = polygon[(std::min(i, n - 1) + 1) % n];
        edges.push_back({p.b, p.a, std::ldexp(next.b - p.b, scale), std::ldexp(next.a - p.a, scale)});
    }
    return edges;
}

} // namespace dermis::reduced
