// SPDX-License-Identifier: MIT
// One step of a cell: of its elements in series, of a spring behind them, and of the integral of the cell's strain. The
// includer declares what a Cell is, and of it:
//   int elements_of(Cell)                            the number of elements, whose strains the state holds
//   bool has_spring(Cell), has_rate(Cell)            a spring in series with them; the state holds the spring's rate
//   bool has_integral(Cell)                          the state holds the integral
//   int is_compensated(Cell)                         each sum of the state has its rounding error
//   LaneCoefficients element_of(Cell, int e)         coefficients of element e; of the spring at e = elements_of
//   Sum sum_from(Cell, int s)                        sum s at the step's start: strains of elements, then the integral
//   real rate_from(Cell)                             the spring's rate at the step's start
//   void store(Cell, int s, Sum before, Sum after)   sum s at the step's end; before: at its start
//   void store_rate(Cell, real)
//   bool has_past(Cell)                              hold is parabolic: the state holds the pressure before the step's start
//   LaneCoefficients past_of(Cell, int e)            the second coefficients of element e, then
//   real previous_from(Cell)                         the pressure one step before the step's start
//   void store_previous(Cell, real)                  the pressure at the step's start

// The cell's motion, and the integral of its strain at the step's end: 0 where the state does not hold the integral.
struct CellStep {
    Motion motion;
    real integral;
};

// The strain of element e at the step's end. k: the element's coefficients.
OF_ANY_CELL Sum strained_of(Cell cell, int e, Sum strain, Load s, LaneCoefficients k) {
    if (has_past(cell)) return advanced_strain_with_past(strain, s, k, past_of(cell, e), is_compensated(cell));
    return advanced_strain(strain, s, k, is_compensated(cell));
}

OF_ANY_CELL CellStep step_of(Cell cell, Load s) {
    int elements = elements_of(cell);
    int compensated = is_compensated(cell);
    bool past = has_past(cell);
    if (past) {
        s.past = change_before(previous_from(cell), s);
        store_previous(cell, flush(s.s0));
    }
    LaneCoefficients first = element_of(cell, 0);
    Sum strain = sum_from(cell, 0);
    Sum strained = strained_of(cell, 0, strain, s, first);
    store(cell, 0, strain, strained);
    Motion m = motion_of(strain.value, strained.value, s, first);
    if (past) m = motion_with_past(m, s, past_of(cell, 0));
    for (int e = 1; e < elements; ++e) {
        LaneCoefficients k = element_of(cell, e);
        strain = sum_from(cell, e);
        strained = strained_of(cell, e, strain, s, k);
        store(cell, e, strain, strained);
        m = with_element(m, strain.value, strained.value, s, k);
    }
    if (has_spring(cell)) m.strain = in_series(m.strain, spring_strain(s, element_of(cell, elements)));
    if (has_rate(cell)) {
        LaneCoefficients k = element_of(cell, elements);
        real before = rate_from(cell);
        real after = past ? spring_rate_with_past(before, s, k, past_of(cell, elements)) : spring_rate(before, s, k);
        store_rate(cell, after);
        m = with_spring_rates(m, before, after, k);
    }
    CellStep step;
    step.motion = m;
    step.integral = real(0.0);
    if (has_integral(cell)) {
        Sum integral = sum_from(cell, elements);
        Sum grown = advanced_integral(integral, m.gained, first, compensated);
        store(cell, elements, integral, grown);
        step.integral = grown.value;
    }
    return step;
}
