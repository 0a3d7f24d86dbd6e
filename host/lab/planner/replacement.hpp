// SPDX-License-Identifier: MIT
// A bound of what outputs are off by where another chain of elements in series stands for a skin's own: strains,
// integrals, rates and accelerations of both chains, or of steps and ramps between frames, are taken from output to
// output in counted arithmetic; the curvature adds its share.
#pragma once

#include "host/lab/planner/bound.hpp"
#include "host/lab/planner/magnitudes.hpp"

#include <optional>

namespace dermis::planner {

using Elements = std::vector<plan::Element>;

// Elements that one chain has and another one has not, and the other way round.
struct Difference {
    Elements added, removed;
};

// The greatest magnitudes of what is read: of the pressure and of the resting skin's curvature, and the greatest
// curvature of the strain per unit of the signal of strain.
struct Magnitudes {
    double peak, rest, curved;
};

// A chain in place of a skin's own.
struct Replacement {
    Elements chain;
    Errors cells{}, sites{}; // bounds of |X - X_exact| by it alone, over all cells and over the sites of each class
    double error = 0; // of what is asked for the worst, as worst_asked() takes it; infinite where it is not known
};

// The greatest |signals| of a chain, or of the difference of two, over all outputs and over the impulses of jumps.
struct Greatest {
    Errors outputs{}, impulses{};
};

// Bounds the errors of chains in place of a uniform skin's own, under the exact method. Frames and the fields between
// them are at outputs. Skin, schedule and peaks outlive it.
class ReplacementBound {
  public:
    // first_jump: if impulses of an envelope are read, the first jump, which meets a skin at rest.
    ReplacementBound(const plan::PreparedSkin&, const plan::Schedule&, const Peaks&, std::optional<double> first_jump);
    Replacement of(const Elements&) const;

  private:
    Greatest greatest(const Difference&) const;
    Magnitudes magnitudes_of(const Read&) const;
    double greatest_impulse(int quantity) const;
    double impulse_error(const Greatest& off) const;
    double error(double x, double off, double strain_off, const Magnitudes&) const;

    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    const Peaks& peaks_;
    const std::optional<double> first_jump_;
    const double l_;
    const Greatest exact_; // of the skin's own chain
    std::optional<Magnitudes> everywhere_;
    std::array<std::optional<Magnitudes>, REDUCED_MAPS> at_sites_;
};

} // namespace dermis::planner
