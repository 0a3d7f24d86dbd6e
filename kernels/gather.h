// SPDX-License-Identifier: MIT
// The Laplacian over whatever `real strain_at(int x, int y)` returns; the includer declares it.
inline real laplacian_along_x(int x, int y, real centre, int n, int stencil, int edges) {
    Axis a = axis(x, n, stencil, edges);
    if (stencil == STENCIL_FIVE_POINT) return second_difference(strain_at(a.low, y), centre, strain_at(a.high, y));
    if (stencil == STENCIL_FOURTH_ORDER)
        return fourth_order(strain_at(a.far_low, y), strain_at(a.low, y), centre, strain_at(a.high, y),
                            strain_at(a.far_high, y));
    return published_difference(strain_at(a.far_low, y), strain_at(a.low, y), strain_at(a.high, y),
                                strain_at(a.far_high, y), a);
}

inline real laplacian_along_y(int x, int y, real centre, int n, int stencil, int edges) {
    Axis a = axis(y, n, stencil, edges);
    if (stencil == STENCIL_FIVE_POINT) return second_difference(strain_at(x, a.low), centre, strain_at(x, a.high));
    if (stencil == STENCIL_FOURTH_ORDER)
        return fourth_order(strain_at(x, a.far_low), strain_at(x, a.low), centre, strain_at(x, a.high),
                            strain_at(x, a.far_high));
    return published_difference(strain_at(x, a.far_low), strain_at(x, a.low), strain_at(x, a.high),
                                strain_at(x, a.far_high), a);
}
