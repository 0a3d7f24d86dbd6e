// SPDX-License-Identifier: MIT
// One step of a cell, from its state and the load over the step to its state and its motion at the step's end. A cell
// has elements in series, each with eta*eps' + E*eps = sigma. Their strains add up; the state also holds the integral
// of the cell's strain.

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

// Pressure over a step: s0 after a jump of sj at its start, s0 + ds at its end. past: what the pressure changed by over
// the step before, which bends it between the two under parabolic hold.
struct Load {
    real s0, ds, sj, past;
};

inline Load load(real s0, real ds, real sj) {
    Load s;
    s.s0 = s0;
    s.ds = ds;
    s.sj = sj;
    s.past = real(0.0);
    return s;
}

// What the pressure changed by over the step before, from `earlier` on.
inline real change_before(real earlier, Load s) {
    precise real change = s.s0 - earlier;
    return change;
}

// The load of a pressure p of the map under an envelope.
inline Load load_of(real p, Constants c) {
    precise real s0 = real(c.start) * p;
    precise real ds = real(c.rise) * p;
    precise real sj = real(c.jump) * p;
    return load(s0, ds, sj);
}

// The load of a pressure that runs linearly from frame p to frame q.
inline Load load_between(real p, real q, Constants c) {
    precise real change = q - p;
    precise real s0 = p + real(c.start) * change;
    precise real ds = real(c.rise) * change;
    precise real sj = real(c.jump) * p;
    return load(s0, ds, sj);
}

// The pressure less the spring's stress: it drives the dashpot.
inline real excess_stress(real eps, Load s, LaneCoefficients k) {
    precise real r = s.s0 - k.E * eps;
    return r;
}

// A load's contribution x with what the step before adds to it. factor: a member of the second Coefficients of an
// element.
inline real with_past(real x, real factor, Load s) {
    precise real sum = x + factor * s.past;
    return sum;
}

// The increment of an element's strain over a step.
inline real strain_step(real eps, Load s, LaneCoefficients k) {
    precise real r = excess_stress(eps, s, k);
    precise real step = k.b * r + k.f * s.ds;
    return step;
}

// What the integral of the strain gains over a step, leak apart: from the strain at the step's start, and from the
// load.
inline real integral_gained(real eps, Load s, LaneCoefficients k) {
    precise real gained = k.i0 * eps + k.i1 * s.s0 + k.i2 * s.ds;
    return gained;
}

inline real integral_step(real gained, real I, LaneCoefficients k) {
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

// The strain of an element at the step's end; the same with what the step before adds; and the integral of the cell's
// strain. gained: see integral_gained().
inline Sum advanced_strain(Sum strain, Load s, LaneCoefficients k, int compensated) {
    return advanced_sum(strain, strain_step(strain.value, s, k), compensated);
}

inline Sum advanced_strain_with_past(Sum strain, Load s, LaneCoefficients k, LaneCoefficients past, int compensated) {
    return advanced_sum(strain, with_past(strain_step(strain.value, s, k), past.f, s), compensated);
}

inline Sum advanced_integral(Sum integral, real gained, LaneCoefficients k, int compensated) {
    return advanced_sum(integral, integral_step(gained, integral.value, k), compensated);
}

// The strain of a cell, its rate and its acceleration at the step's end, and what its integral gains over the step.
struct Motion {
    real strain, gained, rate, acceleration;
};

inline real rate_after(real eps, Load s, LaneCoefficients k) {
    precise real r = excess_stress(eps, s, k);
    precise real rate = k.v0 * r + k.v1 * s.ds;
    return rate;
}

inline real acceleration_after(real eps, Load s, LaneCoefficients k) {
    precise real r = excess_stress(eps, s, k);
    precise real acceleration = k.a0 * r + k.a1 * s.ds + k.a2 * s.sj;
    return acceleration;
}

// The motion of a cell's first element. Its coefficients contain what the load adds to the integral, rate and
// acceleration of all elements. before, after: the element's strain at the step's start and end.
inline Motion motion_of(real before, real after, Load s, LaneCoefficients k) {
    Motion m;
    m.strain = after;
    m.gained = integral_gained(before, s, k);
    m.rate = rate_after(before, s, k);
    m.acceleration = acceleration_after(before, s, k);
    return m;
}

// The motion m of a cell's first element with what the step before adds. past: the element's second Coefficients.
inline Motion motion_with_past(Motion m, Load s, LaneCoefficients past) {
    m.gained = with_past(m.gained, past.i2, s);
    m.rate = with_past(m.rate, past.v1, s);
    m.acceleration = with_past(m.acceleration, past.a1, s);
    return m;
}

// The strain of elements in series is a sum.
inline real in_series(real strain, real of_next) {
    precise real sum = strain + of_next;
    return flush(sum);
}

// The motion m with one more element. before, after: the element's strain at the step's start and end.
inline Motion with_element(Motion m, real before, real after, Load s, LaneCoefficients k) {
    precise real r = excess_stress(before, s, k);
    precise real gained = m.gained + k.i0 * before;
    precise real rate = m.rate + k.v0 * r;
    precise real acceleration = m.acceleration + k.a0 * r;
    m.strain = in_series(m.strain, after);
    m.gained = gained;
    m.rate = rate;
    m.acceleration = acceleration;
    return m;
}

// The strain of a spring, which follows the pressure at once: no state holds it.
inline real spring_strain(Load s, LaneCoefficients k) {
    precise real strain = k.b * s.s0 + k.f * s.ds;
    return flush(strain);
}

// The rate of a spring's strain at the step's end. before: the rate at the step's start. With frames the state holds
// this rate, if FA2 is asked for. A step of length 0 leaves it as it was.
inline real spring_rate(real before, Load s, LaneCoefficients k) {
    precise real rate = k.v0 * before + k.v1 * s.ds;
    return flush(rate);
}

// The same with what the step before adds.
inline real spring_rate_with_past(real before, Load s, LaneCoefficients k, LaneCoefficients past) {
    precise real rate = k.v0 * before + k.v1 * s.ds;
    return flush(with_past(rate, past.v1, s));
}

// The motion m with the mean acceleration of a spring. before, after: the spring's rate at the step's start and end.
inline Motion with_spring_rates(Motion m, real before, real after, LaneCoefficients k) {
    precise real acceleration = m.acceleration + k.a1 * (after - before);
    m.acceleration = acceleration;
    return m;
}
