// SPDX-License-Identifier: MIT
// Coefficients and loads of a run's steps in long double, by which the errors of coefficients in double are measured.
#pragma once

#include "host/lab/schedule/extended.hpp"
#include "host/lab/schedule/timeline.hpp"

namespace dermis::model {

// Returns a - b.
f64::Coefficients difference(const f64::Coefficients& a, const extended::Coefficients& b);

// Schedule and materials outlive it.
class References {
  public:
    References(const Schedule&, const std::vector<Element>& materials, const ResponseRule&);

    // Computes the coefficients of a step. False for an impulse, and for a step by another method than the exact one.
    bool take(const Step&);
    // The coefficients of a material in the last step taken, before loads are joined (model::join_loads).
    // past: the second ones; 0 where nothing bends the pressure.
    extended::Coefficients coefficients(size_t material, extended::Coefficients& past) const;
    // The length of that step, s.
    long double length() const { return length_; }
    // The envelope after and before a jump at the step's start.
    long double start(const Step& step) const { return load_.after<long double>(step.begin); }
    long double jump(const Step& step) const { return start(step) - load_.before<long double>(step.begin); }
    const scene::Waveform& load() const { return load_; }

  private:
    const std::vector<Element>& materials_;
    const ResponseRule rule_;
    const scene::Waveform load_;
    std::vector<extended::Coefficients> held_; // of a load that is held
    Forcing<long double> forcing_;
    bool forced_ = false;
    long double length_ = -1, before_ = 0; // s: of the step, and back to the pressure that bends it
};

} // namespace dermis::model
