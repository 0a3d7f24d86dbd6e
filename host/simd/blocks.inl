// SPDX-License-Identifier: MIT
// A step of one row and the responses of another in one loop, a block of one register of cells at a time: nothing
// between state and responses is stored, and responses go from registers past the caches. rows.inl precedes this in its
// namespace. Blocks begin at multiples of their length, so that the last one of a row ends within the row's pitch.

// One register of cells as the `real` of kernels/*.h: the operators and functions that they use, lane by lane.
struct Wide {
    typedef scalar Lanes __attribute__((vector_size(sizeof(Register))));
    typedef Lanes Anywhere __attribute__((aligned(alignof(scalar)), may_alias)); // the same in memory
    using Mask = decltype(Lanes{} < Lanes{}); // each lane all ones or 0
    static constexpr int lanes = int(sizeof(Register) / sizeof(scalar));

    Lanes v;

    Wide() = default;
    explicit Wide(Lanes x) : v(x) {}
    explicit Wide(scalar x) : v(x - Lanes{}) {} // x in every lane: -0 - 0 is -0

    static Wide load(const scalar* from) { return Wide(*reinterpret_cast<const Anywhere*>(from)); }
    void store(scalar* to) const { *reinterpret_cast<Anywhere*>(to) = v; }
    void stream(scalar* to) const { stream_register(to, (Register)v); }

    friend Wide operator+(Wide a, Wide b) { return Wide(a.v + b.v); }
    friend Wide operator-(Wide a, Wide b) { return Wide(a.v - b.v); }
    friend Wide operator*(Wide a, Wide b) { return Wide(a.v * b.v); }
    friend Wide operator*(scalar a, Wide b) { return Wide(a) * b; }
    friend Wide operator-(Wide a) { return Wide(-a.v); }
    friend Wide abs(Wide a) { return Wide((Lanes)((Mask)a.v & ~(Mask)Wide(scalar(-0.0)).v)); }
    friend Mask lessThan(Wide a, Wide b) { return a.v < b.v; }
    friend Wide mix(Wide a, Wide b, Mask second) { return Wide(second ? b.v : a.v); }
};

namespace blocks {

using real = Wide;
constexpr int lanes = real::lanes;
// clang-format off
#include "kernels/prelude.h"
#include "kernels/step.h"
#include "kernels/responses.h"
#include "kernels/curvature.h"
// clang-format on
#undef precise

// The step of cells i .. i + lanes - 1 of the arguments.
template <bool compensated>
inline void advance(const AdvanceArguments<Kernels>& a, int i, const Constants& c, const LaneCoefficients& k) {
    const Load load = load_between(real::load(a.pressure + i), real::load(a.pressure_to + i), c);
    CellState before;
#define LOAD_SUM(name)                                                                                                 \
    before.name = sum_of(real::load(a.from.value[sum_##name] + i),                                                     \
                         compensated ? real::load(a.from.lost[sum_##name] + i) : real(scalar(0)));
    STATE_SUMS(LOAD_SUM)
#undef LOAD_SUM
    const CellState after = advanced(before, load, k, compensated);
#pragma GCC unroll 8
    for (int s = 0; s < STEP_SIGNALS; ++s) signal(QUANTITY_FA1 + s, before, after, load, k).store(a.signal[s] + i);
#define STORE_SUM(name)                                                                                                \
    after.name.value.store(a.to.value[sum_##name] + i);                                                                \
    if constexpr (compensated) after.name.lost.store(a.to.lost[sum_##name] + i);
    STATE_SUMS(STORE_SUM)
#undef STORE_SUM
}

// The Laplacian of columns x .. x + lanes - 1, none of which reads across an end of the row.
template <int stencil> inline real laplacian_inside(const RowNeighbours<scalar>& l, int x) {
    Axis across{}, along{};
    across.w_low = l.w_low;
    across.w_high = l.w_high;
    across.w = l.w;
    along.w_low = along.w_high = along.w = scalar(0.5);
    const int far = reach(stencil), near = stencil == STENCIL_PUBLISHED ? 0 : 1;
    const auto row = [here = l.here + x](int i) { return real::load(here + i); };
    const real here = row(0);
    return add(difference(row(-far), row(-near), here, row(near), row(far), along, stencil),
               difference(real::load(l.far_low + x), real::load(l.low + x), here, real::load(l.high + x),
                          real::load(l.far_high + x), across, stencil));
}

// The same for a block near an end of the row, part of which may lie behind it: the nearest block inside, and beside it
// cell by cell what reads across the end.
template <int stencil> real laplacian_at_end(const RowNeighbours<scalar>& l, int x) {
    const int far = reach(stencil), inside = min(max(x, far), l.width - far - lanes);
    alignas(real) scalar around[4 * lanes] = {};
    scalar* L = around + 2 * lanes;
    laplacian_inside<stencil>(l, inside).store(L + (inside - x));
    for (int i = x; i < far; ++i) L[i - x] = laplacian_at(l, i);
    for (int i = max(x, l.width - far); i < min(x + lanes, l.width); ++i) L[i - x] = laplacian_at(l, i);
    return real::load(L);
}

template <bool passed> inline real answer_of(int quantity, real x, real C, const Constants& c) {
    return passed ? response(x, C, c.curvature_length) : answer(quantity, x, C, c);
}

// The responses of n <= lanes columns from x on, where the strain has the Laplacian L.
template <bool passed> inline void respond(const RespondArguments<Kernels>& r, int x, int n, real L, const Constants& c) {
    const real C = curvature_of(real::load(r.rest_curvature + x), L, c.bend);
#pragma GCC unroll 8
    for (int i = 0; i < RESPONSE_MAPS; ++i) {
        const real answered = answer_of<passed>(QUANTITY_SA1 + i, real::load(r.signal[i] + x), C, c);
        if (n == lanes) answered.stream(r.response[i] + x);
        else
            for (int lane = 0; lane < n; ++lane) r.response[i][x + lane] = answered.v[lane];
    }
}

// The blocks from column x to column `last` that are not inside.
template <int stencil, bool compensated, bool passed>
__attribute__((noinline)) void step_ends(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r,
                                         const Constants& c, int x, int last) {
    for (; x < last; x += lanes) {
        advance<compensated>(a, x - r.first, c, lanes_of(c.coefficients));
        respond<passed>(r, x, min(last - x, lanes), laplacian_at_end<stencil>(r.strain, x), c);
    }
}

template <int stencil, bool compensated, bool passed>
void step_row_in(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r, const Constants& c) {
    const int far = reach(stencil), begin = r.first < far ? r.first + lanes : r.first,
              count = max(min(r.last, r.strain.width - far) - begin, 0) / lanes * lanes;
    step_ends<stencil, compensated, passed>(a, r, c, r.first, begin);
    [begin, count, a = a, r = r, c = c] { // copies: nothing that is stored may change them
        const LaneCoefficients k = lanes_of(c.coefficients);
        for (int x = begin; x < begin + count; x += lanes) {
            advance<compensated>(a, x - r.first, c, k);
            respond<passed>(r, x, lanes, laplacian_inside<stencil>(r.strain, x), c);
        }
    }();
    step_ends<stencil, compensated, passed>(a, r, c, begin + count, r.last);
}

template <bool compensated, bool passed>
void step_row_for(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r, const Constants& c) {
    if (r.strain.stencil == STENCIL_FIVE_POINT) step_row_in<STENCIL_FIVE_POINT, compensated, passed>(a, r, c);
    else if (r.strain.stencil == STENCIL_FOURTH_ORDER) step_row_in<STENCIL_FOURTH_ORDER, compensated, passed>(a, r, c);
    else step_row_in<STENCIL_PUBLISHED, compensated, passed>(a, r, c);
}

} // namespace blocks

// Whether a block's loop serves: frames, a uniform material, all responses, aligned, no sums, and a row in which some
// block reads across neither end.
bool in_blocks(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r) {
    bool all = a.pressure_to && !a.material && r.strain.width >= blocks::lanes + 2 * reach(r.strain.stencil);
    for (int i = 0; i < RESPONSE_MAPS; ++i) all = all && r.response[i] && is_aligned(r.response[i] + r.first);
    for (int i = 0; i < REDUCED_MAPS; ++i) all = all && !r.tiles[i];
    return all;
}

int step_row(const AdvanceArguments<Kernels>& a, const RespondArguments<Kernels>& r, const Constants& c) {
    if (!in_blocks(a, r)) {
        const int changed = advance(a, c);
        respond(r, c);
        return changed;
    }
    const bool compensated = a.from.lost[sum_strain], passed = c.gain_plus == real(1) && c.gain_minus == real(-1);
    if (compensated)
        passed ? blocks::step_row_for<true, true>(a, r, c) : blocks::step_row_for<true, false>(a, r, c);
    else passed ? blocks::step_row_for<false, true>(a, r, c) : blocks::step_row_for<false, false>(a, r, c);
    end_vector_code();
    return (1 << state_sums) - 1;
}
