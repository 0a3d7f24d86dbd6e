// SPDX-License-Identifier: MIT
// The effect of an envelope's change within a step, in closed form for unit pressure.
#pragma once

#include "host/plan/coefficients.hpp"
#include "host/scene/waveform.hpp"

#include <complex>
#include <optional>

namespace dermis::plan {

// A linear segment of a load within a step: pressure u0 to u0 + du, relative to the pressure at the step's start.
// length: s.
struct Segment {
    double length, u0, du;
};

// Splits a step at the envelope's breakpoints.
std::vector<Segment> segments_of(const scene::Waveform&, scene::Instant from, scene::Instant to);

// The imaginary part of start*e^(i w t) from the step's start on; turn is e^(i w dt).
struct Sine {
    double w; // 1/s
    std::complex<double> start, turn;
};

// How a step differs from one under a load that is held, or whose change is the pressure's between frames.
struct Forcing {
    double dt = 0;                 // length of the step, s
    std::vector<Segment> segments; // the load's change, where it is straight in parts
    std::optional<Sine> sine;      // the load, where it is a sine
    // The load's slope before the step, from which the rate of an elastic element follows: FA2 is a mean over the step.
    std::optional<double> slope;
    double slope_length = 0;       // s, of that mean
    std::optional<double> impulse; // the responses become the impulses of this jump at the step's end
    double before = 0;             // the load just before that jump
    bool framed = false;           // the pressure of an impulse is the jump itself, as where a sequence begins
    bool held = false;             // the load does not change before an impulse

    // Whether all that it does is to multiply the factors of ds by one number.
    bool scales() const { return !sine && !slope && !impulse && segments.size() == 1; }
};

// Multiplies the factors of ds, those of a linear rise by 1.
void scale_change(f64::Coefficients&, double du);

// Writes what the forcing makes of the coefficients of a load that is held.
void force(f64::Coefficients&, const Element&, const ResponseRule&, const Forcing&);

} // namespace dermis::plan
