// SPDX-License-Identifier: MIT
// Steps, Laplacians and responses in the memory of rows. The namespace that includes this has the kernels' functions, a
// `real` of one cell or of neighbouring ones, and load() and store() of such a real.

// States of cells at a step's start and end.
struct Stepped {
    CellState before, after;
};

// Steps cell i and stores what the step makes. Called, it would load all coefficients for each block.
template <bool framed, bool compensated>
__attribute__((always_inline)) inline Stepped step_at(const AdvanceArguments<Kernels>& a, int i, const Constants& c,
                                                      const LaneCoefficients& k) {
    const Load load = framed ? load_between(loaded(a.pressure + i), loaded(a.pressure_to + i), c)
                             : load_of(loaded(a.pressure + i), c);
    CellState before{};
#define LOAD_SUM(name)                                                                                                 \
    before.name = sum_of(loaded(a.from.value[sum_##name] + i),                                                         \
                         compensated ? loaded(a.from.lost[sum_##name] + i) : real(scalar(0)));
    STATE_SUMS(LOAD_SUM)
#undef LOAD_SUM
    const CellState after = advanced(before, load, k, compensated);
#pragma GCC unroll 8
    for (int s = 0; s < STEP_SIGNALS; ++s) store(a.signal[s] + i, signal(QUANTITY_FA1 + s, before, after, load, k));
#define STORE_SUM(name)                                                                                                \
    store(a.to.value[sum_##name] + i, after.name.value);                                                               \
    if constexpr (compensated) store(a.to.lost[sum_##name] + i, after.name.lost);
    STATE_SUMS(STORE_SUM)
#undef STORE_SUM
    return {before, after};
}

// The published stencil's weights across rows; the rows themselves are in `l`.
inline Axis across(const RowNeighbours<scalar>& l) {
    Axis a{};
    a.w_low = l.w_low;
    a.w_high = l.w_high;
    a.w = l.w;
    return a;
}

// The second differences at column x: across the rows, and along the row where no cell is read across an end of it.
template <int stencil> inline real difference_across(const RowNeighbours<scalar>& l, int x) {
    return difference(loaded(l.far_low + x), loaded(l.low + x), loaded(l.here + x), loaded(l.high + x),
                      loaded(l.far_high + x), across(l), stencil);
}
template <int stencil> inline real difference_along(const RowNeighbours<scalar>& l, int x) {
    Axis inner{};
    inner.w_low = inner.w_high = inner.w = scalar(0.5);
    const int far = reach(stencil), near = stencil == STENCIL_PUBLISHED ? 0 : 1;
    const scalar* row = l.here + x;
    return difference(loaded(row - far), loaded(row - near), loaded(row), loaded(row + near), loaded(row + far), inner,
                      stencil);
}

// answer() of kernels/responses.h. passed: the gains of FA2 are 1 and -1, which leave it unchanged to the bit.
template <bool passed> inline real answer_of(int quantity, real x, real C, const Constants& c) {
    return passed ? response(x, C, c.curvature_length) : answer(quantity, x, C, c);
}
