// SPDX-License-Identifier: MIT
// One step of eta*eps' + E*eps = sigma in one cell, and the four receptor responses at its end.

struct Load {
    real s0, ds, sj;
};

inline Load load_of(real p, Constants c) {
    precise real s0 = c.start * p;
    precise real ds = c.rise * p;
    precise real sj = c.jump * p;
    Load s;
    s.s0 = s0;
    s.ds = ds;
    s.sj = sj;
    return s;
}

inline real dashpot(real eps, Load s, Row k) {
    precise real r = s.s0 - k.E * eps;
    return r;
}

inline real strain_after(real eps, Load s, Row k) {
    precise real r = dashpot(eps, s, k);
    precise real step = k.b * r + k.f * s.ds;
    precise real after = eps + step;
    return flush(after);
}

inline real sum_after(real eps, real I, Load s, Row k) {
    precise real gained = k.i0 * eps + k.i1 * s.s0 + k.i2 * s.ds;
    precise real after = I + (gained - k.leak * I);
    return flush(after);
}

inline real rate_after(real eps, Load s, Row k) {
    precise real r = dashpot(eps, s, k);
    precise real rate = k.v0 * r + k.v1 * s.ds;
    return rate;
}

inline real acceleration_after(real eps, Load s, Row k) {
    precise real r = dashpot(eps, s, k);
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
    precise real plus = gain_plus * max(a, real(0.0));
    precise real minus = gain_minus * max(-a, real(0.0));
    precise real passed = plus + minus;
    return flush(passed);
}
