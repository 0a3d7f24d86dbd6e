// SPDX-License-Identifier: MIT
// The Laplacian in difference form (exactly 0 on constants, no loss on an offset), and the cells that it reads at edges.

// The cells that a stencil reads along one axis, and the weights of the published stencil.
struct Axis {
    int far_low, low, high, far_high;
    real w_low, w_high, w;
};

// The cell inside 0 .. n - 1 that stands for cell i. The mirror is half-sample: -1 -> 0, -2 -> 1. The one cell of an
// axis of length 1 reads itself and so contributes 0.
inline int wrapped(int i, int n, int edges) {
    if (edges == EDGES_PERIODIC) return (i + 4 * n) % n;
    int m = i < 0 ? -1 - i : (i >= n ? 2 * n - 1 - i : i);
    return min(max(m, 0), n - 1);
}

inline Axis axis(int i, int n, int stencil, int edges) {
    Axis a;
    a.w_low = real(0.5);
    a.w_high = real(0.5);
    a.w = real(0.5);
    if (stencil != STENCIL_PUBLISHED) {
        a.far_low = wrapped(i - 2, n, edges);
        a.low = wrapped(i - 1, n, edges);
        a.high = wrapped(i + 1, n, edges);
        a.far_high = wrapped(i + 2, n, edges);
    } else if (edges != EDGES_PUBLISHED) {
        a.far_low = wrapped(i - 2, n, edges);
        a.low = i;
        a.high = i;
        a.far_high = wrapped(i + 2, n, edges);
    } else {
        // A central difference of central differences; at the ends both become one-sided, over one cell.
        int g_low = max(i - 1, 0);
        int g_high = min(i + 1, n - 1);
        a.far_low = max(g_low - 1, 0);
        a.low = min(g_low + 1, n - 1);
        a.high = max(g_high - 1, 0);
        a.far_high = min(g_high + 1, n - 1);
        if (a.low - a.far_low < 2) a.w_low = real(1.0);
        if (a.far_high - a.high < 2) a.w_high = real(1.0);
        if (g_high - g_low < 2) a.w = real(1.0);
    }
    return a;
}

// The distance in cells up to which a stencil reads.
inline int reach(int stencil) { return stencil == STENCIL_FIVE_POINT ? 1 : 2; }

// high - 2*centre + low, as a sum of two differences.
inline real second_difference(real low, real centre, real high) {
    precise real sum = (high - centre) + (low - centre);
    return sum;
}

inline real fourth_order(real far_low, real low, real centre, real high, real far_high) {
    precise real near_sum = (high - centre) + (low - centre);
    precise real far_sum = (far_high - centre) + (far_low - centre);
    precise real sum = real(1.3333333333333333) * near_sum - real(0.08333333333333333) * far_sum;
    return sum;
}

inline real published_difference(real far_low, real low, real high, real far_high, Axis a) {
    precise real gradient_low = a.w_low * (low - far_low);
    precise real gradient_high = a.w_high * (far_high - high);
    precise real sum = a.w * (gradient_high - gradient_low);
    return sum;
}

// The stencil's second difference along one axis. The five-point stencil ignores the far cells, the published one the
// centre.
inline real difference(real far_low, real low, real centre, real high, real far_high, Axis a, int stencil) {
    if (stencil == STENCIL_FIVE_POINT) return second_difference(low, centre, high);
    if (stencil == STENCIL_FOURTH_ORDER) return fourth_order(far_low, low, centre, high, far_high);
    return published_difference(far_low, low, high, far_high, a);
}

inline real add(real along_x, real along_y) {
    precise real sum = along_x + along_y;
    return sum;
}

// C = L(S) - h*L(eps). L(S) is computed once, in double.
inline real curvature_of(real rest_curvature, real strain_laplacian, scalar bend) {
    precise real C = rest_curvature - real(bend) * strain_laplacian;
    return C;
}

// D = S - h*eps
inline real deformation_of(real surface, real eps, scalar thickness) {
    precise real D = surface - real(thickness) * eps;
    return D;
}
