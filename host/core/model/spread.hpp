// SPDX-License-Identifier: MIT
// What evenly pressed cells cause at a depth of an even elastic half-space, whose vertical stress under a given
// pressure does not depend on the modulus, nor on time where the modulus relaxes evenly; and the pyramid of nodes that
// spreads maps to that depth (kernels/spread.h).
#pragma once

#include "dermis/description.hpp"
#include "host/core/base/quadrature.hpp"

#include <cmath>
#include <numbers>
#include <vector>

namespace dermis::model {

// A depth, and what acts there.
struct Depth {
    double depth; // m, > 0
    DepthKernel kernel;
    double poisson; // Poisson's ratio; ignored for the stress
    bool operator==(const Depth&) const = default;
};

// What acts at a point, a and b meters beside a point force, per unit of the force, 1/m^2: of the distance rho,
// far/rho^5 - near/rho^3 + wide/rho.
template <class T> struct PointForce {
    T square, near = 0, far = 0, wide = 0;
    explicit PointForce(const Depth& d) {
        using enum DepthKernel;
        const T z = d.depth, nu = d.poisson, pi = std::numbers::pi_v<T>, of = d.kernel == stress ? 1 : 1 + nu;
        square = z * z;
        if (d.kernel == displacement) { // times the modulus, over the length that makes it the stress on the axis
            wide = 3 * (1 - nu) / ((3 - 2 * nu) * pi * z);
            near = -3 * z / ((3 - 2 * nu) * 2 * pi);
            return;
        }
        far = of * 3 * z * z * z / (2 * pi);
        if (d.kernel == strain) near = of * nu * z / pi;
    }
    T operator()(T a, T b) const {
        const T rho = a * a + b * b + square, inverse = 1 / rho;
        return inverse * std::sqrt(inverse) * (far * inverse - near + wide * rho);
    }
};

// What a square of side h, whose middle is x and y meters away, adds per unit of its pressure (Love 1929). What acts
// varies over lengths of the distance, so that a rule is exact for a square that is not near; one that is near is four.
template <class T> T of_square(T x, T y, T h, const PointForce<T>& below) {
    const T away = std::sqrt(x * x + y * y + below.square) / h, q = h / 4;
    if (away < 2)
        return of_square(x - q, y - q, h / 2, below) + of_square(x + q, y - q, h / 2, below) +
               of_square(x - q, y + q, h / 2, below) + of_square(x + q, y + q, h / 2, below);
    const Rule<T> rule = away < 4    ? Rule<T>(sixteen_points<T>)
                         : away < 80 ? Rule<T>(eight_points<T>)
                                     : Rule<T>(four_points<T>);
    return integral(rule, y - h / 2, h,
                    [&](T b) { return integral(rule, x - h / 2, h, [&](T a) { return below(a, b); }); });
}

// The nodes of a level along an axis: node i of level l is at cell i*2^l. A coarser level has every node that the finer
// nodes, and so the cells of the grid, reach.
struct Nodes {
    int low, high;
    int count() const { return high - low + 1; }
    Nodes coarser() const { return {-((3 - low) >> 1), (high + 3) >> 1}; }
};

// A level of the pyramid. weights: of the stencil, (radius + 1)^2, [b*(radius + 1) + a] for nodes a along a row and b
// across rows away; none where radius is -1.
struct SpreadLevel {
    Nodes x, y;
    int radius = -1;
    std::vector<double> weights;
};

// The levels on a grid, level 0 first. Spread values differ from the sums over all cells by at most `spread_error` of
// the greatest |value| spread, times the sum of all |weights| if that is above 1, as a displacement's is, at every
// depth (tests/core/spread_test.cpp).
using Spread = std::vector<SpreadLevel>;
constexpr double spread_error = 1e-3;
constexpr double least_depth = 1e-6, most_depth = 1e6; // cells

// Fits the weights, which have the same bits on every machine. On grids of up to 8 x 8 cells they are the sums' own.
// depth: in cells, for squares of side 1; least_depth .. most_depth.
Spread spread_of(const Depth& depth, int width, int height);

} // namespace dermis::model
