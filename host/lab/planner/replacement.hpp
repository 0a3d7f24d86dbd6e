// SPDX-License-Identifier: MIT
// A bound of the errors of outputs if another chain of elements in series replaces a skin's own. The strains,
// integrals, rates and accelerations of both chains, or of steps and ramps between frames, are computed from output to
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

// The greatest magnitudes in cells that are read: of the pressure, of the curvature at rest, and of the curvature that
// the strain adds, per unit of the strain's signal.
struct Magnitudes {
    double peak, rest, curved;
};

// A chain in place of a skin's own.
struct Replacement {
    Elements chain;
    Errors cells{}, sites{}; // bounds of |X - X_exact| by it alone, over all cells and over the sites of each class
    double error = 0;        // the worst of what is asked for, by worst_asked(); infinite: not known
};

// The greatest |signals| of a chain, or of the difference of two, over all outputs and over the impulses of jumps.
struct Greatest {
    Errors outputs{}, impulses{};
};

// Bounds the errors of chains that replace a uniform skin's own, under the exact method. Frames, and fields between
// them, must be at outputs. Skin, schedule and peaks must outlive it.
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
