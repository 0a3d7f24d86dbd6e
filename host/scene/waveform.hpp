// SPDX-License-Identifier: MIT
// The envelope g(t) of the load: piecewise linear between knots, at which it may jump, or a sine from t = 0 on.
#pragma once

#include "dermis/dermis.hpp"

namespace dermis::scene {

struct Knot {
    double time, left, right; // left and right limits of g at time
};

class Waveform {
  public:
    // The envelope has been validated. A knot that lies within 1e-6 of a step from an output time is moved onto it.
    Waveform(const Envelope&, const Time&);

    double before(double t) const;                            // left limit
    double after(double t) const;                             // right limit
    double slope_before(double t) const;                      // 1/s, left limit
    const std::vector<Knot>& knots() const { return knots_; } // times ascend strictly
    bool breaks(double from, double to) const;                // whether a knot lies strictly between
    bool sine() const { return envelope_.kind == Envelope::Kind::sine; }
    double angular_frequency() const;

    // Returns the multiple of `step` that lies within 1e-6 of a step from t, or else t.
    static double snapped(double t, double step);

  private:
    Envelope envelope_;
    std::vector<Knot> knots_;
};

// Checks every parameter that the kind of envelope uses. Throws Error::bad_input.
void check_envelope(const Envelope&, const Time&);

} // namespace dermis::scene
