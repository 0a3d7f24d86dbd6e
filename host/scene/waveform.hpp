// SPDX-License-Identifier: MIT
// The load over time, g(t): straight between knots, where it may jump, or a sine from t = 0 on.
#pragma once

#include "dermis/dermis.hpp"

namespace dermis::scene {

struct Knot {
    double time, left, right; // g just before and just after
};

class Waveform {
  public:
    // From a validated envelope; knots within 1e-6 of a step from an output time are moved onto it.
    Waveform(const Envelope&, const Time&);

    double before(double t) const;                            // left limit
    double after(double t) const;                             // right limit
    double slope_before(double t) const;                      // 1/s, left limit
    const std::vector<Knot>& knots() const { return knots_; } // ascending, each time once
    bool breaks(double from, double to) const;                // a knot between
    bool sine() const { return envelope_.kind == Envelope::Kind::sine; }
    double angular_frequency() const;

    static double snapped(double t, double step);

  private:
    Envelope envelope_;
    std::vector<Knot> knots_;
};

// Throws Error::bad_input.
void check_envelope(const Envelope&, const Time&);

} // namespace dermis::scene
