// SPDX-License-Identifier: MIT
// Steps, Laplacians and responses in the memory of rows. The namespace that includes this has the kernels' functions, a
// `real` that is one cell or several neighbouring cells, and loaded() and store(), which read and write such a real.

// A cell, or neighbouring ones, for kernels/cell.h: those at `i` of a row. coefficients(n): Coefficients n of the
// cell's elements, entries_of(hold) of each. changed(sum, before, after) is called for every sum. series: how many
// elements the cell has, without a spring behind them; 0: as the arguments say, with or without a spring.
template <Hold hold, bool compensated, int series, class CoefficientsOf, class Changed> struct RowCell {
    const AdvanceArguments<Kernels>& a;
    int i;
    const CoefficientsOf& coefficients;
    const Changed& changed;

    // Which sum of a row's state sum s of the cell is, and where it stands there.
    int sum(int s) const { return s < elements_of(*this) ? sum_strain : sum_integral; }
    size_t at(int s) const { return (sum(s) == sum_strain ? size_t(s) * a.from.element : 0) + size_t(i); }

    friend int elements_of(const RowCell& cell) { return series ? series : cell.a.elements; }
    friend bool has_spring(const RowCell& cell) { return series == 0 && cell.a.spring; }
    friend bool has_rate(const RowCell& cell) { return hold != Hold::held && series == 0 && cell.a.to.rate; }
    friend bool has_integral(const RowCell& cell) { return cell.a.to.value[sum_integral]; }
    friend int is_compensated(const RowCell&) { return compensated; }
    friend bool has_past(const RowCell&) { return hold == Hold::parabolic; }
    friend decltype(auto) element_of(const RowCell& cell, int e) { return cell.coefficients(entries_of(hold) * e); }
    friend decltype(auto) past_of(const RowCell& cell, int e) { return cell.coefficients(2 * e + 1); }
    friend real previous_from(const RowCell& cell) { return loaded(cell.a.from.previous + cell.i); }
    friend void store_previous(const RowCell& cell, real p) { store(cell.a.to.previous + cell.i, p); }
    friend Sum sum_from(const RowCell& cell, int s) {
        const int sum = cell.sum(s);
        return sum_of(loaded(cell.a.from.value[sum] + cell.at(s)),
                      compensated ? loaded(cell.a.from.lost[sum] + cell.at(s)) : real(scalar(0)));
    }
    friend void store(const RowCell& cell, int s, Sum before, Sum after) {
        const int sum = cell.sum(s);
        cell.changed(sum, before, after);
        store(cell.a.to.value[sum] + cell.at(s), after.value);
        if constexpr (compensated) store(cell.a.to.lost[sum] + cell.at(s), after.lost);
    }
    friend real rate_from(const RowCell& cell) { return loaded(cell.a.from.rate + cell.i); }
    friend void store_rate(const RowCell& cell, real rate) { store(cell.a.to.rate + cell.i, rate); }
};

// Steps cell i, stores its new state and signals, and returns its strain. It is always inlined: a call would load all
// coefficients for each block.
template <Hold hold, bool compensated, int series, class CoefficientsOf, class Changed>
__attribute__((always_inline)) inline real step_at(const AdvanceArguments<Kernels>& a, int i, const Constants& c,
                                                   const CoefficientsOf& coefficients, const Changed& changed) {
    const Load load = hold == Hold::held ? load_of(loaded(a.pressure + i), c)
                                         : load_between(loaded(a.pressure + i), loaded(a.pressure_to + i), c);
    const CellStep step =
        step_of(RowCell<hold, compensated, series, CoefficientsOf, Changed>{a, i, coefficients, changed}, load);
#pragma GCC unroll 8
    for (int s = 0; s < STEP_SIGNALS; ++s)
        if (a.signal[s]) store(a.signal[s] + i, signal(QUANTITY_FA1 + s, step.motion, step.integral));
    return step.motion.strain;
}

// The published stencil's weights across rows; the rows themselves are in `l`.
inline Axis across(const RowNeighbours<scalar>& l) {
    Axis a{};
    a.w_low = real(l.w_low);
    a.w_high = real(l.w_high);
    a.w = real(l.w);
    return a;
}

// The second differences at column x: across the rows, and along the row where its stencil reads no cell across an end.
template <int stencil> inline real difference_across(const RowNeighbours<scalar>& l, int x) {
    return difference(loaded(l.far_low + x), loaded(l.low + x), loaded(l.here + x), loaded(l.high + x),
                      loaded(l.far_high + x), across(l), stencil);
}
template <int stencil> inline real difference_along(const RowNeighbours<scalar>& l, int x) {
    Axis inner{};
    inner.w_low = inner.w_high = inner.w = real(0.5);
    const int far = reach(stencil), near = stencil == STENCIL_PUBLISHED ? 0 : 1;
    const scalar* row = l.here + x;
    return difference(loaded(row - far), loaded(row - near), loaded(row), loaded(row + near), loaded(row + far), inner,
                      stencil);
}

// answer() of kernels/responses.h. passed: the gains of FA2 are 1 and -1, which leave it unchanged to the bit.
template <bool passed> inline real answer_of(int quantity, real x, real gain, const Constants& c) {
    return passed ? response(x, gain) : answer(quantity, x, gain, c);
}
