// SPDX-License-Identifier: MIT
// What an envelope does within a step beyond staying at its start, worked out in closed form for unit pressure.
#pragma once

#include "host/plan/coefficients.hpp"
#include "host/scene/waveform.hpp"

namespace dermis::plan {

// A straight segment of a load within a step: pressure u0 to u0 + du over and above that at the step's start.
struct Segment {
    double length, u0, du;
};

// The segments from breakpoint to breakpoint.
std::vector<Segment> segments_of(const scene::Waveform&, scene::Instant from, scene::Instant to);

// Each writes the load into the factors of ds, whose Constants::rise is then 1.
void force_straight(f64::Coefficients&, const Element&, const ResponseRule&, const std::vector<Segment>&, double dt);
// The imaginary part of start*e^(i w t) from the step's start on; turn is e^(i w dt).
struct Sine {
    double w; // 1/s
    std::complex<double> start, turn;
};
void force_sine(f64::Coefficients&, const Element&, const ResponseRule&, const Sine&, double dt);

} // namespace dermis::plan
