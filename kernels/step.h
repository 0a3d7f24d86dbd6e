// SPDX-License-Identifier: MIT
// One step of eta*eps' + E*eps = sigma, from a cell's state and the load over the step to the state at the step's end.

// Coefficients of one cell or of four, one per lane of `real`.
#define REAL_MEMBER(name) real name;
struct LaneCoefficients {
    COEFFICIENTS(REAL_MEMBER)
};

inline LaneCoefficients lanes_of(Coefficients k) {
    LaneCoefficients lanes;
#define SPREAD(name) lanes.name = real(k.name);
    COEFFICIENTS(SPREAD)
#undef SPREAD
    return lanes;
}

// Pressure over a step: s0 after a jump of sj at its start, s0 + ds at its end.
struct Load {
    real s0, ds, sj;
};

inline Load load(real s0, real ds, real sj) {
    Load s;
    s.s0 = s0;
    s.ds = ds;
    s.sj = sj;
    return s;
}

// The load of a pressure p of the map under an envelope.
inline Load load_of(real p, Constants c) {
    precise real s0 = c.start * p;
    precise real ds = c.rise * p;
    precise real sj = c.jump * p;
    return load(s0, ds, sj);
}

// The load of a pressure that runs linearly from frame p to frame q.
inline Load load_between(real p, real q, Constants c) {
    precise real change = q - p;
    precise real s0 = p + c.start * change;
    precise real ds = c.rise * change;
    precise real sj = c.jump * p;
    return load(s0, ds, sj);
}

// The pressure less the spring's stress: it drives the dashpot.
inline real excess_stress(real eps, Load s, LaneCoefficients k) {
    precise real r = s.s0 - k.E * eps;
    return r;
}

// The increments of the strain and of its integral over a step.
inline real strain_step(real eps, Load s, LaneCoefficients k) {
    precise real r = excess_stress(eps, s, k);
    precise real step = k.b * r + k.f * s.ds;
    return step;
}

inline real integral_step(real eps, real I, Load s, LaneCoefficients k) {
    precise real gained = k.i0 * eps + k.i1 * s.s0 + k.i2 * s.ds;
    precise real step = gained - k.leak * I;
    return step;
}

// A sum that grows step by step, and its accumulated rounding error (Kahan). If compensated, the next step subtracts that
// error: the sum is exact to a few units over any number of steps. Otherwise no error is carried.
struct Sum {
    real value, lost;
};

inline Sum sum_of(real value, real lost) {
    Sum s;
    s.value = value;
    s.lost = lost;
    return s;
}

inline Sum added(Sum sum, real step) {
    precise real after = sum.value + step;
    return sum_of(flush(after), sum.lost);
}

inline Sum added_compensated(Sum sum, real step) {
    precise real corrected = step - sum.lost;
    precise real after = sum.value + corrected;
    precise real lost = (after - sum.value) - corrected;
    return sum_of(flush(after), flush(lost));
}

inline Sum advanced_sum(Sum sum, real step, int compensated) {
    if (compensated != 0) return added_compensated(sum, step);
    return added(sum, step);
}

// The state of a cell, which it carries from step to step.
#define SUM_MEMBER(name) Sum name;
struct CellState {
    STATE_SUMS(SUM_MEMBER)
};

// The state at the step's end. The integral grows by the strain at the step's start.
inline Sum advanced_strain(Sum strain, Load s, LaneCoefficients k, int compensated) {
    return advanced_sum(strain, strain_step(strain.value, s, k), compensated);
}

inline Sum advanced_integral(CellState cell, Load s, LaneCoefficients k, int compensated) {
    return advanced_sum(cell.integral, integral_step(cell.strain.value, cell.integral.value, s, k), compensated);
}

inline CellState advanced(CellState cell, Load s, LaneCoefficients k, int compensated) {
    CellState after;
    after.strain = advanced_strain(cell.strain, s, k, compensated);
    after.integral = advanced_integral(cell, s, k, compensated);
    return after;
}
