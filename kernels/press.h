// SPDX-License-Identifier: MIT
// One step of eta*eps' + E*eps = sigma in one cell, and the four receptor responses at its end.

// Coefficients of the cells at hand.
struct LaneCoefficients {
    real E, b, f, i0, i1, i2, leak, v0, v1, a0, a1, a2;
};

inline LaneCoefficients lanes_of(Coefficients k) {
    LaneCoefficients r;
    r.E = real(k.E);
    r.b = real(k.b);
    r.f = real(k.f);
    r.i0 = real(k.i0);
    r.i1 = real(k.i1);
    r.i2 = real(k.i2);
    r.leak = real(k.leak);
    r.v0 = real(k.v0);
    r.v1 = real(k.v1);
    r.a0 = real(k.a0);
    r.a1 = real(k.a1);
    r.a2 = real(k.a2);
    return r;
}

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

inline Load load_of(real p, Constants c) {
    precise real s0 = c.start * p;
    precise real ds = c.rise * p;
    precise real sj = c.jump * p;
    return load(s0, ds, sj);
}

// Straight from frame p to frame q.
inline Load load_between(real p, real q, Constants c) {
    precise real way = q - p;
    precise real s0 = p + c.start * way;
    precise real ds = c.rise * way;
    precise real sj = c.jump * p;
    return load(s0, ds, sj);
}

inline real excess_stress(real eps, Load s, LaneCoefficients k) {
    precise real r = s.s0 - k.E * eps;
    return r;
}

// What a step adds to the strain, and to its integral.
inline real strain_step(real eps, Load s, LaneCoefficients k) {
    precise real r = excess_stress(eps, s, k);
    precise real step = k.b * r + k.f * s.ds;
    return step;
}

inline real sum_step(real eps, real I, Load s, LaneCoefficients k) {
    precise real gained = k.i0 * eps + k.i1 * s.s0 + k.i2 * s.ds;
    precise real step = gained - k.leak * I;
    return step;
}

inline real added(real value, real step) {
    precise real after = value + step;
    return flush(after);
}

// Kahan's sum: `lost` is what earlier additions have rounded away; it is taken off the next step. Exact to a few units
// over any number of steps.
struct Compensated {
    real value, lost;
};

inline Compensated added_compensated(real value, real lost, real step) {
    precise real corrected = step - lost;
    precise real after = value + corrected;
    precise real gone = (after - value) - corrected;
    Compensated c;
    c.value = flush(after);
    c.lost = flush(gone);
    return c;
}

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

// x*(1 + l*C)
inline real response(real x, real C, scalar l) {
    precise real gain = real(1.0) + l * C;
    precise real scaled = x * gain;
    return flush(scaled);
}

// Pacinian transduction has a gain for each sign; (1, -1) passes the signal unchanged.
inline real rectified(real a, scalar gain_plus, scalar gain_minus) {
    precise real other = -a; // max() of a NaN may be 0
    precise real plus = gain_plus * mix(a, real(0.0), lessThan(a, real(0.0)));
    precise real minus = gain_minus * mix(other, real(0.0), lessThan(other, real(0.0)));
    precise real passed = plus + minus;
    return flush(passed);
}
