// SPDX-License-Identifier: MIT
// The receptor responses of a cell at a step's end.

// The signal that a receptor transduces: SA1 strain, SA2 its integral, FA1 its rate, FA2 its acceleration.
inline real signal(int quantity, Motion m, real integral) {
    if (quantity == QUANTITY_SA2) return integral;
    if (quantity == QUANTITY_FA1) return m.rate;
    if (quantity == QUANTITY_FA2) return m.acceleration;
    return m.strain;
}

// The gain of every receptor where the skin has the curvature C: 1 + l*C.
inline real gain_at(real C, Constants c) {
    precise real gain = real(1.0) + real(c.curvature_length) * C;
    return gain;
}

inline real response(real x, real gain) {
    precise real scaled = x * gain;
    return flush(scaled);
}

// Pacinian transduction has a gain for each sign; (1, -1) passes the signal unchanged.
inline real rectified(real a, scalar gain_plus, scalar gain_minus) {
    precise real other = -a; // no max(): it may turn a NaN into 0
    precise real plus = real(gain_plus) * mix(a, real(0.0), lessThan(a, real(0.0)));
    precise real minus = real(gain_minus) * mix(other, real(0.0), lessThan(other, real(0.0)));
    precise real passed = plus + minus;
    return flush(passed);
}

// The response of a receptor to its signal x. gain: gain_at() of its place.
inline real answer(int quantity, real x, real gain, Constants c) {
    real scaled = response(x, gain);
    if (quantity == QUANTITY_FA2) return rectified(scaled, c.gain_plus, c.gain_minus);
    return scaled;
}
