// SPDX-License-Identifier: MIT
// The envelope g(t) of the load: piecewise linear between knots, at which it may jump, or a sine from t = 0 on, which a
// window may multiply.
#pragma once

#include "dermis/scene.hpp"
#include "host/lab/scenes/instant.hpp"

#include <complex>

namespace dermis::scene {

struct Knot {
    Instant time;
    double left, right; // left and right limits of g at time
};

// Values are computed in T, double or long double.
class Waveform {
  public:
    // The envelope has been validated. A knot that differs from an output time only by rounding is moved onto it.
    Waveform(const Envelope&, const Time&);

    template <class T = double> T before(Instant) const;       // left limit
    template <class T = double> T after(Instant) const;        // right limit
    template <class T = double> T slope_before(Instant) const; // 1/s, left limit
    // before(to) - after(from), with no knot strictly between.
    template <class T = double> T rise(Instant from, Instant to) const;
    const std::vector<Knot>& knots() const { return knots_; }            // times ascend strictly
    bool breaks(Instant from, Instant to) const;                         // whether a knot lies strictly between
    bool sine() const { return wave() && weights_.empty(); }             // without a window
    bool wave() const { return envelope_.kind == Envelope::Kind::sine; } // a sine, with a window or without
    double mean() const { return envelope_.mean; }                       // of a wave
    // The window of a wave at an instant, right limit, and its rise from there, as rise().
    template <class T = double> T weight(Instant) const;
    template <class T = double> T weight_rise(Instant from, Instant to) const;
    template <class T = double> T angular_frequency() const; // 1/s
    // e^(i w t). Whole turns are dropped before the phase is multiplied by 2 pi. t may be a difference of instants.
    template <class T = double> std::complex<T> turn(Instant) const;
    // The sine is the imaginary part of this plus the mean: amplitude*e^(i (w t + phase)).
    template <class T = double> std::complex<T> phasor(Instant) const;

  private:
    template <class T> T carrier(Instant) const; // a wave without its window
    Envelope envelope_;
    std::vector<Knot> knots_;
    std::vector<Knot> weights_; // of the window of a sine; empty without
};

// Checks every parameter that the kind of envelope uses. Throws Error::bad_input.
void check_envelope(const Envelope&, const Time&);

} // namespace dermis::scene
