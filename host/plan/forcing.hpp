// SPDX-License-Identifier: MIT
// The effect of an envelope's change within a step, in closed form for unit pressure.
#pragma once

#include "host/plan/coefficients.hpp"
#include "host/scene/waveform.hpp"

#include <complex>
#include <optional>

namespace dermis::plan {

// T is double, or for references long double.

// A linear segment of a load within a step: pressure u0 to u0 + du, relative to the pressure at the step's start.
// length: s.
template <class T> struct Segment { T length, u0, du; };

// The imaginary part of start*e^(i w t) from the step's start on; turn is e^(i w dt).
template <class T> struct Sine {
    T w; // 1/s
    std::complex<T> start, turn;
};

// How a step differs from one under a load that is held, or whose change is the pressure's between frames.
template <class T> struct Forcing {
    T dt = 0;                         // length of the step, s
    std::vector<Segment<T>> segments; // the load's change, where it is straight in parts
    std::optional<Sine<T>> sine;      // the load, where it is a sine
    // The load's slope before the step, from which the rate of an elastic element follows: FA2 is a mean over the step.
    std::optional<T> slope;
    T slope_length = 0;            // s, of that mean
    std::optional<double> impulse; // the responses become the impulses of this jump at the step's end
    double before = 0;             // the load just before that jump
    bool framed = false;           // the pressure of an impulse is the jump itself, as where a sequence begins
    bool held = false;             // the load does not change before an impulse

    // Whether all that it does is to multiply the factors of ds by one number.
    bool scales() const { return !sine && !slope && !impulse && segments.size() == 1; }
    bool is_sine_alone() const { return sine && !slope && !impulse; }
};

// The product of complex numbers. That of std::complex looks for NaN, and calls a function.
template <class T> std::complex<T> product(std::complex<T> a, std::complex<T> b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}
template <class T> T real_product(std::complex<T> a, std::complex<T> b) {
    return a.real() * b.real() - a.imag() * b.imag();
}

// Returns 1/(real + i*imaginary) of numbers >= 0 of which one is not 0. None is squared, and so nothing overflows.
template <class T> std::complex<T> reciprocal(T real, T imaginary) {
    const bool wide = real >= imaginary;
    const T greater = wide ? real : imaginary, less = wide ? imaginary : real;
    const T ratio = less / greater, share = 1 / (greater + less * ratio), other = ratio * share;
    return {wide ? share : other, wide ? -other : -share};
}

// Makes of the coefficients of a load that is held those under a sine: its steady-state response, less the decayed rest
// of its value at the step's start.
template <class K> class SineForce {
  public:
    using T = typename K::real;
    SineForce(const Sine<T>& s, const ResponseRule& rule, T dt)
        : w_(s.w), dt_(dt), start_(s.start.imag(), -s.start.real()), turn_(s.turn),
          rate_of_turn_(-s.w * s.turn.imag(), s.w * s.turn.real()),
          sum_(reciprocal<T>(1 / T(rule.sa2_adaptation), s.w)), step_mean_(rule.step_mean) {}

    [[gnu::always_inline]] void force(typename K::Coefficients& k, const Element& m) const {
        const T modulus = m.modulus, viscosity = m.viscosity;
        const std::complex<T> compliance = reciprocal<T>(modulus, w_ * viscosity), eps0 = product(start_, compliance),
                              sum0 = product(eps0, sum_);
        const T left = k.v0 * viscosity; // e^-z, the factor by which a strain decays over the step
        const T wave = start_.real();    // the held pressure, whose effect the coefficients contain: subtracted
        k.f = real_product<T>(eps0, {turn_.real() - left, turn_.imag()}) - k.b * wave;
        k.i2 = (real_product<T>(sum0, {turn_.real() - (1 - k.leak), turn_.imag()}) - eps0.real() * k.i0) - k.i1 * wave;
        k.v1 = real_product<T>(eps0, {rate_of_turn_.real() + modulus * k.v0, rate_of_turn_.imag()}) - k.v0 * wave;
        const T acceleration =
            real_product<T>(eps0, {-w_ * w_ * turn_.real() + k.E * k.a0, -w_ * w_ * turn_.imag()}) - k.a0 * wave;
        k.a1 = step_mean_ ? k.v1 / dt_ : acceleration;
    }

  private:
    T w_, dt_;
    std::complex<T> start_, turn_, rate_of_turn_; // start_: over i; rate_of_turn_: i w turn
    std::complex<T> sum_;                         // by which the integral follows from a strain
    bool step_mean_;
};

// Returns what an envelope's change makes of a step of dt seconds between two instants. with_slope: the rate of an
// elastic element is asked for.
template <class T>
Forcing<T> forcing_over(const scene::Waveform&, scene::Instant from, scene::Instant to, T dt, bool with_slope);

// Multiplies the factors of ds, those of a linear rise by 1.
template <class K> void scale_change(typename K::Coefficients&, typename K::real du);

// Writes what the forcing makes of the coefficients of a load that is held; K is f64 or extended.
template <class K>
void force(typename K::Coefficients&, const Element&, const ResponseRule&, const Forcing<typename K::real>&);

} // namespace dermis::plan
