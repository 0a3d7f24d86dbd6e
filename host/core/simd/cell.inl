// SPDX-License-Identifier: MIT
// Steps, Laplacians and responses in the memory of rows. The namespace that includes this has the kernels' functions, a
// `real` that is one cell or several neighbouring cells, and loaded() and store(), which read and write such a real.

// A sum of a cell, `at` cells from where its row in a state begins, and the store of one.
template <bool compensated>
__attribute__((always_inline)) inline Sum sum_at(const simd::StateRow<scalar>& row, int sum, size_t at) {
    return sum_of(loaded(row.value[sum] + at), compensated ? loaded(row.lost[sum] + at) : real(scalar(0)));
}
template <bool compensated>
__attribute__((always_inline)) inline void store_sum(const simd::StateRow<scalar>& row, int sum, size_t at, Sum s) {
    store(row.value[sum] + at, s.value);
    if constexpr (compensated) store(row.lost[sum] + at, s.lost);
}

// The strain of an element before and after a step.
struct Strained {
    Sum before, after;
};

template <bool compensated>
__attribute__((always_inline)) inline Strained strain_at(const AdvanceArguments<Kernels>& a, int e, int i, Load load,
                                                         const LaneCoefficients& k) {
    Strained s;
    s.before = sum_at<compensated>(a.from, sum_strain, size_t(e) * a.from.element + size_t(i));
    s.after = advanced_strain(s.before, load, k, compensated);
    store_sum<compensated>(a.to, sum_strain, size_t(e) * a.to.element + size_t(i), s.after);
    return s;
}

// Steps cell i and stores its new state and signals. coefficients(e): the coefficients of its element e. changed(sum,
// before, after) is called for every sum. chain: the cell has several elements. It is always inlined: a call would load
// all coefficients for each block.
template <bool framed, bool compensated, bool chain, class CoefficientsOf, class Changed>
__attribute__((always_inline)) inline void step_at(const AdvanceArguments<Kernels>& a, int i, const Constants& c,
                                                   CoefficientsOf coefficients, Changed changed) {
    const Load load = framed ? load_between(loaded(a.pressure + i), loaded(a.pressure_to + i), c)
                             : load_of(loaded(a.pressure + i), c);
    const Sum integral = sum_at<compensated>(a.from, sum_integral, size_t(i));
    const LaneCoefficients& first = coefficients(0);
    const Strained strain = strain_at<compensated>(a, 0, i, load, first);
    changed(sum_strain, strain.before, strain.after);
    Motion m = motion_of(strain.before.value, strain.after.value, load, first);
    if constexpr (chain) {
        for (int e = 1; e < a.elements; ++e) {
            const LaneCoefficients k = coefficients(e);
            const Strained next = strain_at<compensated>(a, e, i, load, k);
            changed(sum_strain, next.before, next.after);
            m = with_element(m, next.before.value, next.after.value, load, k);
        }
        if (a.spring) m.strain = in_series(m.strain, spring_strain(load, coefficients(a.elements)));
        if (framed && a.to.rate) {
            const LaneCoefficients k = coefficients(a.elements);
            const real before = loaded(a.from.rate + i), rate = spring_rate(before, load, k);
            store(a.to.rate + i, rate);
            m = with_spring_rates(m, before, rate, k);
        }
        store(a.to.strain + i, m.strain);
    }
    const Sum after = advanced_integral(integral, m.gained, first, compensated);
    changed(sum_integral, integral, after);
#pragma GCC unroll 8
    for (int s = 0; s < STEP_SIGNALS; ++s) store(a.signal[s] + i, signal(QUANTITY_FA1 + s, m, after.value));
    store_sum<compensated>(a.to, sum_integral, size_t(i), after);
}

// The published stencil's weights across rows; the rows themselves are in `l`.
inline Axis across(const RowNeighbours<scalar>& l) {
    Axis a{};
    a.w_low = l.w_low;
    a.w_high = l.w_high;
    a.w = l.w;
    return a;
}

// The second differences at column x: across the rows, and along the row where its stencil reads no cell across an end.
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
