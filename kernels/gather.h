// SPDX-License-Identifier: MIT
// The Laplacian of `real strain_at(int x, int y)`, which the includer declares.
inline real laplacian_along_x(int x, int y, real centre, int n, int stencil, int edges) {
    Axis a = axis(x, n, stencil, edges);
    return difference(strain_at(a.far_low, y), strain_at(a.low, y), centre, strain_at(a.high, y),
                      strain_at(a.far_high, y), a, stencil);
}

inline real laplacian_along_y(int x, int y, real centre, int n, int stencil, int edges) {
    Axis a = axis(y, n, stencil, edges);
    return difference(strain_at(x, a.far_low), strain_at(x, a.low), centre, strain_at(x, a.high),
                      strain_at(x, a.far_high), a, stencil);
}
