// SPDX-License-Identifier: MIT
// A map spread to a depth below it, by a pyramid: level l has nodes 2^l cells apart, and the weights of its nodes' stencil
// are fitted to what a pressed cell causes at that depth (host/core/model/spread.cpp). A map goes down the levels, each node
// a B-spline of order 6, a sum of 7 x 7 finer ones by the binomials over 64; and comes up again:
//   down   node = halved() of 7 columns, then halved() of the 7 results along the row
//   up     node = own stencil + at_node() or between_nodes() of the coarser level, along its rows, then across them
//   stencil(x, y) = sum over b = 0 .. r of (w(0, b)*v(0) + w(1, b)*(v(-1) + v(1)) + .. + w(r, b)*(v(-r) + v(r))),
//                   v(a) = node(x + a, y - b) + node(x + a, y + b); for b = 0 the node itself
// Nodes beyond those that cells of the grid reach are 0.

inline real halved(real a, real b, real c, real d, real e, real f, real g) {
    precise real outer = real(0.015625) * (a + g) + real(0.09375) * (b + f);
    precise real inner = real(0.234375) * (c + e) + real(0.3125) * d;
    precise real sum = outer + inner;
    return sum;
}

// The coarser level at a finer node that is its node c, or between its nodes c and d.
inline real at_node(real b, real c, real d) {
    precise real sum = real(0.1875) * (b + d) + real(0.625) * c;
    return sum;
}
inline real between_nodes(real b, real c, real d, real e) {
    precise real sum = real(0.03125) * (b + e) + real(0.46875) * (c + d);
    return sum;
}

inline real together(real a, real b) {
    precise real sum = a + b;
    return sum;
}
inline real weighted(real weight, real x) {
    precise real product = weight * x;
    return product;
}
