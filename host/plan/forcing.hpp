// SPDX-License-Identifier: MIT
// The effect of an envelope's change within a step, in closed form for unit pressure.
#pragma once

#include "host/plan/coefficients.hpp"
#include "host/scene/waveform.hpp"

namespace dermis::plan {

// A linear segment of a load within a step: pressure u0 to u0 + du, relative to the pressure at the step's start.
// length: s.
struct Segment {
    double length, u0, du;
};

// Splits a step at the envelope's breakpoints.
std::vector<Segment> segments_of(const scene::Waveform&, scene::Instant from, scene::Instant to);

// Both force_ functions write the load's change into the factors of ds; Constants::rise is then 1.
void force_straight(f64::Coefficients&, const Element&, const ResponseRule&, const std::vector<Segment>&, double dt);
// The imaginary part of start*e^(i w t) from the step's start on; turn is e^(i w dt).
struct Sine {
    double w; // 1/s
    std::complex<double> start, turn;
};
void force_sine(f64::Coefficients&, const Element&, const ResponseRule&, const Sine&, double dt);

// FA2 of an elastic element as the mean over a step of dt: its rate goes to v1 from that of the load's slope before it.
void force_change(f64::Coefficients&, const Element&, double slope, double dt);

// The responses become the impulses of a jump at the step's end. whole: the pressure of the step is the jump, as where
// a sequence begins; held: the load does not change within the step.
void force_impulse(f64::Coefficients&, const Element&, double jump, bool whole, bool held);

} // namespace dermis::plan
