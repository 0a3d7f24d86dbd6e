// SPDX-License-Identifier: MIT
// The effect of an envelope's change within a step, in closed form for unit pressure.
#pragma once

#include "host/core/model/coefficients.hpp"
#include "host/lab/scenes/waveform.hpp"

#include <complex>
#include <memory>
#include <optional>
#include <span>

namespace dermis::model {

// T is double, or for references long double.

// The imaginary part of start*e^(i w t) from the step's start on; turn is e^(i w dt). Under a window it is multiplied
// by weight + slope*t.
template <class T> struct Sine {
    T w; // 1/s
    std::complex<T> start, turn;
    T weight = 1, slope = 0; // slope: 1/s
};

// A segment of a load within a step: pressure u0 to u0 + du along a line, relative to the pressure at the step's start.
// length: s.
template <class T> struct Segment {
    T length, u0, du;
    std::optional<Sine<T>> wave; // under a window, beside the line
};

// The factors of ds under a sine, as gains of the phasor at the step's start. They depend on the element, the length of
// the step and the frequency.
template <class T> struct SineGains { std::complex<T> f, i2, v1, a1; };

// What the first segments of a step lead an element at rest to, under unit pressure.
struct Begun {
    double strain = 0, integral = 0;
};

// How a step differs from a step under a load that is held, or with a pressure that runs between frames.
template <class T> struct Forcing {
    T dt = 0;                                        // length of the step, s
    std::vector<Segment<T>> segments;                // the load's change, where it is straight in parts
    std::shared_ptr<const std::vector<Begun>> begun; // of each material, before these segments; null: at rest
    std::optional<Sine<T>> sine;                     // the load, where it is a sine
    // The load's slope before the step, from which the rate of an elastic element follows: FA2 is a mean over the step.
    std::optional<T> slope;
    T slope_length = 0;            // s: length of the step of this mean
    std::optional<double> impulse; // the responses become the impulses of this jump at the step's end
    double before = 0;             // the load just before that jump
    bool framed = false;           // the pressure of an impulse is the jump itself, as where a sequence begins
    bool held = false;             // the load does not change before an impulse

    // Whether the load stays as it is over the step.
    bool holds() const { return !sine && is_line() && segments.front().du == 0; }
    // Whether it only multiplies the factors of ds by one number.
    bool scales() const { return !sine && !slope && !impulse && is_line(); }
    bool is_line() const { return segments.size() == 1 && !segments.front().wave && !begun; }
    bool is_sine_alone() const { return sine && !slope && !impulse; }
};

// Returns the forcing of a step of dt seconds between two instants by an envelope, with the segments from `first` on.
// with_slope: the rate of an elastic element is asked for.
template <class T>
Forcing<T> forcing_over(const scene::Waveform&, scene::Instant from, scene::Instant to, T dt, bool with_slope,
                        scene::Instant first);

// Returns the state of an element after more segments.
Begun after_segments(const Element&, const ResponseRule&, std::span<const Segment<double>>, const Begun&);

// Multiplies the factors of ds, which are for a linear rise by 1, by du.
template <class K> void scale_change(typename K::Coefficients&, typename K::real du);

// Returns the gains of an element from its coefficients under a load that is held. w, turn: the members of Sine; dt:
// the length of the step, s.
template <class K, class T = typename K::real>
SineGains<T> sine_gains(const typename K::Coefficients& held, const Element&, const ResponseRule&, T w,
                        std::complex<T> turn, T dt);

// Turns the coefficients under a load that is held into the coefficients under a forcing; K is f64 or extended. known:
// the gains of a sine; null: they are computed. begun: the element's state before the segments.
template <class K>
void force(typename K::Coefficients&, const Element&, const ResponseRule&, const Forcing<typename K::real>&,
           const SineGains<typename K::real>* known = nullptr, const Begun& begun = {});

// Writes the coefficients of a row of cells under a sine alone, each cell's by its index into the materials. held:
// under a load that is held, one for each material or one for all; gains: one for each material.
template <class K>
void fill_row_of_sine(const std::vector<f64::Coefficients>& held, const std::vector<SineGains<double>>& gains,
                      const int* material, int cells, const Forcing<double>&, typename K::Coefficients* row);

} // namespace dermis::model
