// SPDX-License-Identifier: MIT
// kernels/*.h over cells of a row, in the `real` of the namespace that includes this.

using scalar = real;
using Constants = Of<real>::Constants;
using Coefficients = Of<real>::Coefficients;
inline real min(real a, real b) { return b < a ? b : a; }
inline real max(real a, real b) { return a < b ? b : a; }
using simd::max;
using simd::min;
inline bool lessThan(real a, real b) { return a < b; }
inline real mix(real a, real b, bool second) { return second ? b : a; }
// clang-format off
#include "kernels/prelude.h"
#include "kernels/press.h"
#include "kernels/curvature.h"
#include "kernels/reduce.h"
// clang-format on
#undef precise

struct InRow {
    const real* row;
    real strain_at(int x, int) { return row[x]; }
#include "kernels/gather.h"
};

Axis across(const Lines<real>& l) {
    Axis a{};
    a.w_low = l.w_low;
    a.w_high = l.w_high;
    a.w = l.w;
    return a;
}

// Columns away from the ends of a row: every cell looks at the same distances.
template <int kind> void inner(const Lines<real>& l, int begin, int end, real* L) {
    const Axis y = across(l);
    Axis x = y; // the weights of an inner cell
    x.w_low = x.w_high = x.w = real(0.5);
    const real *here = l.here + begin, *far_low = l.far_low + begin, *low = l.low + begin, *high = l.high + begin,
               *far_high = l.far_high + begin;
#pragma GCC ivdep
    for (int i = 0; i < end - begin; ++i) {
        if constexpr (kind == STENCIL_FIVE_POINT)
            L[i] =
                add(second_difference(here[i - 1], here[i], here[i + 1]), second_difference(low[i], here[i], high[i]));
        else if constexpr (kind == STENCIL_FOURTH_ORDER)
            L[i] = add(fourth_order(here[i - 2], here[i - 1], here[i], here[i + 1], here[i + 2]),
                       fourth_order(far_low[i], low[i], here[i], high[i], far_high[i]));
        else
            L[i] = add(published_difference(here[i - 2], here[i], here[i], here[i + 2], x),
                       published_difference(far_low[i], low[i], high[i], far_high[i], y));
    }
}

real at_end(const Lines<real>& l, int x) {
    InRow row{l.here};
    const real centre = l.here[x];
    const real along_x = row.laplacian_along_x(x, 0, centre, l.width, l.stencil, l.edges);
    if (l.stencil == STENCIL_FIVE_POINT) return add(along_x, second_difference(l.low[x], centre, l.high[x]));
    if (l.stencil == STENCIL_FOURTH_ORDER)
        return add(along_x, fourth_order(l.far_low[x], l.low[x], centre, l.high[x], l.far_high[x]));
    return add(along_x, published_difference(l.far_low[x], l.low[x], l.high[x], l.far_high[x], across(l)));
}

void laplacian_inside(const Lines<real>& l, int first, int last, real* L) {
    const int reach = l.stencil == STENCIL_FIVE_POINT ? 1 : 2;
    const int begin = min(max(first, reach), last), end = max(min(last, l.width - reach), begin);
    for (int x = first; x < begin; ++x) L[x - first] = at_end(l, x);
    if (l.stencil == STENCIL_FIVE_POINT) inner<STENCIL_FIVE_POINT>(l, begin, end, L + (begin - first));
    else if (l.stencil == STENCIL_FOURTH_ORDER) inner<STENCIL_FOURTH_ORDER>(l, begin, end, L + (begin - first));
    else inner<STENCIL_PUBLISHED>(l, begin, end, L + (begin - first));
    for (int x = end; x < last; ++x) L[x - first] = at_end(l, x);
}

void laplacian(const Lines<real>& l, int first, int last, real* L) {
    laplacian_inside(l, first, last, L);
    end_vector_code();
}

template <bool framed, bool materials, bool compensated> int advance_in(const Advance<real> a, const Constants c) {
    const LaneCoefficients uniform = lanes_of(c.row);
    int moved = 0, grown = 0;
#pragma GCC ivdep
    for (int i = 0; i < a.count; ++i) {
        const Load load = framed ? load_between(a.p[i], a.q[i], c) : load_of(a.p[i], c);
        const LaneCoefficients k = materials ? lanes_of(a.table[a.material[i]]) : uniform;
        const real eps = a.eps[i], sum = a.sum[i];
        const real step = strain_step(eps, load, k), gained = sum_step(eps, sum, load, k);
        a.rate[i] = rate_after(eps, load, k);
        a.acceleration[i] = acceleration_after(eps, load, k);
        if constexpr (compensated) {
            const Compensated strain = added_compensated(eps, a.eps_lost[i], step);
            const Compensated integral = added_compensated(sum, a.sum_lost[i], gained);
            moved |= (strain.value != eps) | (strain.lost != a.eps_lost[i]);
            grown |= (integral.value != sum) | (integral.lost != a.sum_lost[i]);
            a.eps_to[i] = strain.value;
            a.eps_lost_to[i] = strain.lost;
            a.sum_to[i] = integral.value;
            a.sum_lost_to[i] = integral.lost;
        } else {
            const real after = added(eps, step), total = added(sum, gained);
            moved |= after != eps;
            grown |= total != sum;
            a.eps_to[i] = after;
            a.sum_to[i] = total;
        }
    }
    return moved | grown << 1;
}

template <bool framed, bool materials> int advance_for(const Advance<real>& a, const Constants& c) {
    return a.eps_lost ? advance_in<framed, materials, true>(a, c) : advance_in<framed, materials, false>(a, c);
}

int advance(const Advance<real>& a, const Constants& c) {
    const int changed = a.q ? (a.material ? advance_for<true, true>(a, c) : advance_for<true, false>(a, c))
                            : (a.material ? advance_for<false, true>(a, c) : advance_for<false, false>(a, c));
    end_vector_code();
    return changed;
}

// See kernels/reduce.h. Sum, least and greatest apart and lengths known, for the compiler's vectors.
template <int reach> void fold(real* sum, real* low, real* high) {
#pragma GCC ivdep
    for (int i = 0; i < reach; ++i) {
        Summary a{}, b{};
        a.sum = sum[i], a.low = low[i], a.high = high[i];
        b.sum = sum[i + reach], b.low = low[i + reach], b.high = high[i + reach];
        const Summary joined = join(a, b);
        sum[i] = joined.sum;
        low[i] = joined.low;
        high[i] = joined.high;
    }
    if constexpr (reach > 1) fold<reach / 2>(sum, low, high);
}

// Tiles of `count` values.
void summarize(const real* values, int count, Of<real>::Summary* tiles) {
    for (; count > 0; count -= TILE_CELLS, values += TILE_CELLS, ++tiles) {
        alignas(64) real sum[TILE_CELLS], low[TILE_CELLS], high[TILE_CELLS];
        const int n = min(count, TILE_CELLS);
        __builtin_memcpy(sum, values, size_t(n) * sizeof(real));
        __builtin_memcpy(low, values, size_t(n) * sizeof(real));
        for (int i = n; i < TILE_CELLS; ++i) { // beyond the row's end
            sum[i] = real(0);
            low[i] = values[0];
        }
        __builtin_memcpy(high, low, sizeof high);
        fold<TILE_CELLS / 2>(sum, low, high);
        tiles->sum = sum[0];
        tiles->low = low[0];
        tiles->high = high[0];
    }
}

// FA2 of kernels/press.h. Gains of 1 and -1 pass it unchanged to the bit.
template <bool passed> real fa2_of(real acceleration, real C, const Constants& c) {
    const real a = response(acceleration, C, c.curvature_length);
    return passed ? a : rectified(a, c.gain_plus, c.gain_minus);
}

// All four responses of n cells in one loop.
template <bool passed>
void respond_four(int n, const Constants c, const real* rest, const real* L, const real* eps, const real* sum,
                  const real* rate, const real* acceleration, real (*made)[chunk]) {
    const real l = c.curvature_length;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
        const real C = curvature_of(rest[i], L[i], c.bend);
        made[0][i] = response(eps[i], C, l);
        made[1][i] = response(sum[i], C, l);
        made[2][i] = response(rate[i], C, l);
        made[3][i] = fa2_of<passed>(acceleration[i], C, c);
    }
}

// The one that is asked for.
template <bool passed>
void respond_one(int q, int n, const Constants c, const real* rest, const real* L, const real* X, real* made) {
    const real l = c.curvature_length;
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
        const real C = curvature_of(rest[i], L[i], c.bend);
        made[i] = q == 3 ? fa2_of<passed>(X[i], C, c) : response(X[i], C, l);
    }
}

template <bool passed> void respond_in(const Respond<real>& r, const Constants& c) {
    const auto wanted = [&](int q) { return r.response[q] || r.tiles[q + 1]; };
    const bool all = wanted(0) && wanted(1) && wanted(2) && wanted(3),
               any = wanted(0) || wanted(1) || wanted(2) || wanted(3);
    for (int x = r.first; x < r.last; x += chunk) {
        const int n = min(chunk, r.last - x), tile = x / TILE_CELLS;
        alignas(64) real L[chunk], made[4][chunk];
        if (r.tiles[0]) summarize(r.after.here + x, n, r.tiles[0] + tile);
        const real* from[] = {r.after.here + x, r.sum + x, r.rate + x, r.acceleration + x};
        if (any) laplacian_inside(r.after, x, x + n, L);
        if (all) respond_four<passed>(n, c, r.rest + x, L, from[0], from[1], from[2], from[3], made);
        for (int q = 0; q < 4; ++q) {
            if (!wanted(q)) continue;
            if (!all) respond_one<passed>(q, n, c, r.rest + x, L, from[q], made[q]);
            if (r.tiles[q + 1]) summarize(made[q], n, r.tiles[q + 1] + tile);
            if (r.response[q]) stream(r.response[q] + x, made[q], size_t(n) * sizeof(real));
        }
    }
}

void respond(const Respond<real>& r, const Constants& c) {
    c.gain_plus == real(1) && c.gain_minus == real(-1) ? respond_in<true>(r, c) : respond_in<false>(r, c);
    end_vector_code();
}
