// SPDX-License-Identifier: MIT
// Loops of kernels/*.h over the cells of a row, in the `real` of the namespace that includes this. The functions are
// compiled again, with the flags of the including file; `Kernels`, f32 or f64, gives their structs.

using scalar = real;
using Constants = Kernels::Constants;
using Coefficients = Kernels::Coefficients;
inline real min(real a, real b) { return b < a ? b : a; }
inline real max(real a, real b) { return a < b ? b : a; }
using simd::max;
using simd::min;
inline bool lessThan(real a, real b) { return a < b; }
inline real mix(real a, real b, bool second) { return second ? b : a; }
// clang-format off
#include "kernels/prelude.h"
#include "kernels/step.h"
#include "kernels/cell.h"
#include "kernels/responses.h"
#include "kernels/curvature.h"
#include "kernels/reduce.h"
#include "kernels/spread.h"
// clang-format on
#undef precise
#undef OF_ANY_CELL

inline real loaded(const real* from) { return *from; }
inline void store(real* to, real x) { *to = x; }
#include "host/core/simd/cell.inl"

// The Laplacian of columns begin .. end - 1, where every cell reads at the same distances.
template <int stencil> void laplacian_between(const RowNeighbours<real> l, int begin, int end, real* L) {
#pragma GCC ivdep
    for (int x = begin; x < end; ++x)
        L[x - begin] = add(difference_along<stencil>(l, x), difference_across<stencil>(l, x));
}

// The second difference along a row at any of its columns.
real difference_at(const RowNeighbours<real>& l, int x) {
    const real* row = l.here;
    const Axis a = axis(x, l.width, l.stencil, l.edges);
    return difference(row[a.far_low], row[a.low], row[x], row[a.high], row[a.far_high], a, l.stencil);
}

// The second difference along a row at column x. a: the axis of that column.
template <int stencil> inline real difference_by(const real* row, int x, const Axis& a) {
    return difference(row[a.far_low], row[a.low], row[x], row[a.high], row[a.far_high], a, stencil);
}

// The cells that the second differences near the ends of a row read: the same in every row.
template <int stencil> struct EndCells {
    static constexpr int far = stencil == STENCIL_FIVE_POINT ? 1 : 2; // reach(stencil), which is not constexpr
    int width, edges;
    Axis low[far], high[far]; // of the first columns, and of the last ones

    explicit EndCells(const RowNeighbours<real>& l) : width(l.width), edges(l.edges) {
        for (int i = 0; i < far; ++i) {
            low[i] = axis(i, width, stencil, edges);
            high[i] = axis(width - far + i, width, stencil, edges);
        }
    }
};

real laplacian_at(const RowNeighbours<real>& l, int x) {
    return add(difference_at(l, x),
               difference(l.far_low[x], l.low[x], l.here[x], l.high[x], l.far_high[x], across(l), l.stencil));
}

template <auto value> struct Constant { static constexpr auto number = value; };

// Calls f with the number of a stencil as a Constant.
template <class F> void with_stencil(int stencil, F f) {
    if (stencil == STENCIL_FIVE_POINT) f(Constant<STENCIL_FIVE_POINT>{});
    else if (stencil == STENCIL_FOURTH_ORDER) f(Constant<STENCIL_FOURTH_ORDER>{});
    else f(Constant<STENCIL_PUBLISHED>{});
}

// Calls f with a bool as a Constant.
template <class F> auto with_bool(bool value, F f) { return value ? f(Constant<true>{}) : f(Constant<false>{}); }

// Whether FA2 passes on the acceleration as it is.
bool passes(const Constants& c) { return c.gain_plus == real(1) && c.gain_minus == real(-1); }

void laplacian_over(const RowNeighbours<real>& l, int first, int last, real* L) {
    const int far = reach(l.stencil);
    const int begin = min(max(first, far), last), end = max(min(last, l.width - far), begin);
    for (int x = first; x < begin; ++x) L[x - first] = laplacian_at(l, x);
    with_stencil(l.stencil,
                 [&](auto stencil) { laplacian_between<stencil.number>(l, begin, end, L + (begin - first)); });
    for (int x = end; x < last; ++x) L[x - first] = laplacian_at(l, x);
}

void laplacian(const RowNeighbours<real>& l, int first, int last, real* L) {
    laplacian_over(l, first, last, L);
    end_vector_code();
}

// The tree of kernels/reduce.h. Sums, minima and maxima are separate arrays of constant length, so that the loop
// vectorises.
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

// Summarizes `count` values, tile by tile.
void summarize(const real* values, int count, Kernels::Summary* tiles) {
    for (; count > 0; count -= TILE_CELLS, values += TILE_CELLS, ++tiles) {
        alignas(64) real sum[TILE_CELLS], low[TILE_CELLS], high[TILE_CELLS];
        const int n = min(count, TILE_CELLS);
        __builtin_memcpy(sum, values, size_t(n) * sizeof(real));
        __builtin_memcpy(low, values, size_t(n) * sizeof(real));
        for (int i = n; i < TILE_CELLS; ++i) { // cells beyond the row's end
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

template <int reach> inline void fold_sums(real* sum, real* rest) {
#pragma GCC ivdep
    for (int i = 0; i < reach; ++i) {
        const Kernels::LongSum s = Kernels::joined({sum[i], rest[i]}, {sum[i + reach], rest[i + reach]});
        sum[i] = s.sum;
        rest[i] = s.rest;
    }
    if constexpr (reach > 1) fold_sums<reach / 2>(sum, rest);
}

void join_tiles(const Kernels::Summary* tiles, int count, JoinedTiles<Kernels>& joined) {
    constexpr int lanes = 16;
    alignas(64) real sum[tiles_joined], rest[tiles_joined] = {}, low[lanes], high[lanes];
    for (int i = 0; i < lanes; ++i) low[i] = tiles[0].low, high[i] = tiles[0].high;
    for (int i = 0; i < count; ++i) sum[i] = Kernels::long_sum(tiles[i].sum).sum;
    for (int i = count; i < tiles_joined; ++i) sum[i] = real(0);
    for (int first = 0; first < count; first += lanes)
        for (int i = 0; i < lanes && first + i < count; ++i) {
            low[i] = tiles[first + i].low < low[i] ? tiles[first + i].low : low[i];
            high[i] = high[i] < tiles[first + i].high ? tiles[first + i].high : high[i];
        }
    fold_sums<tiles_joined / 2>(sum, rest);
    for (int i = 1; i < lanes; ++i) {
        low[0] = low[i] < low[0] ? low[i] : low[0];
        high[0] = high[0] < high[i] ? high[i] : high[0];
    }
    joined = {{sum[0], rest[0]}, low[0], high[0]};
    end_vector_code();
}

// All responses of n cells in one loop.
template <bool passed>
void respond_all(int n, const Constants c, const real* rest, const real* L, const real* const (&signals)[RESPONSE_MAPS],
                 real (*responses)[chunk]) {
#pragma GCC ivdep
    for (int i = 0; i < n; ++i) {
        const real gain = gain_at(curvature_of(rest[i], L[i], c.bend), c);
#pragma GCC unroll 8
        for (int r = 0; r < RESPONSE_MAPS; ++r)
            responses[r][i] = answer_of<passed>(QUANTITY_SA1 + r, signals[r][i], gain, c);
    }
}

// One response of n cells.
template <bool passed>
void respond_one(int quantity, int n, const Constants c, const real* rest, const real* L, const real* x,
                 real* responses) {
#pragma GCC ivdep
    for (int i = 0; i < n; ++i)
        responses[i] = answer_of<passed>(quantity, x[i], gain_at(curvature_of(rest[i], L[i], c.bend), c), c);
}

template <bool passed> void respond_in(const RespondArguments<Kernels>& r, const Constants& c) {
    const auto wanted = [&](int i) { return r.response[i] || r.tiles[QUANTITY_SA1 + i]; };
    bool all = true, any = false;
    for (int i = 0; i < RESPONSE_MAPS; ++i) {
        all = all && wanted(i);
        any = any || wanted(i);
    }
    for (int x = r.first; x < r.last; x += chunk) {
        const int n = min(chunk, r.last - x), tile = x / TILE_CELLS;
        alignas(64) real L[chunk], responses[RESPONSE_MAPS][chunk];
        if (r.tiles[QUANTITY_STRAIN]) summarize(r.strain.here + x, n, r.tiles[QUANTITY_STRAIN] + tile);
        const real* signals[RESPONSE_MAPS];
        for (int i = 0; i < RESPONSE_MAPS; ++i) signals[i] = wanted(i) ? r.signal[i] + x : nullptr;
        if (any) laplacian_over(r.strain, x, x + n, L);
        if (all) respond_all<passed>(n, c, r.rest_curvature + x, L, signals, responses);
        for (int i = 0; i < RESPONSE_MAPS; ++i) {
            if (!wanted(i)) continue;
            if (!all) respond_one<passed>(QUANTITY_SA1 + i, n, c, r.rest_curvature + x, L, signals[i], responses[i]);
            if (r.tiles[QUANTITY_SA1 + i]) summarize(responses[i], n, r.tiles[QUANTITY_SA1 + i] + tile);
            if (!r.response[i]) continue;
            if (r.streams) stream(r.response[i] + x, responses[i], size_t(n) * sizeof(real));
            else __builtin_memcpy(r.response[i] + x, responses[i], size_t(n) * sizeof(real));
        }
    }
}
