// SPDX-License-Identifier: MIT
// The exact solution of eta*eps' + E*eps = sigma on skin at rest, by superposition of closed forms in many bits.
//
// A pressure of straight pieces is a sum of jumps J and changes of slope K, each at its time t_k. A jump of 1 gives a
// strain of (1 - e^(-d/tau))/E at d after it, a slope of 1 the integral of that, a change L of its second derivative
// once more the integral; the responses below are their sums, with the parts that do not decay summed by hand: they are
// the pressure itself, its slope and its integrals.
#pragma once

#include "tests/oracle/real.hpp"

#include <optional>
#include <vector>

namespace oracle {

// The pressure reaches `left` at `time` and leaves it from `right`; between knots it has the second derivative `bow` of
// the earlier one; it is 0 before the first one, `right` of the last one for ever.
struct Knot {
    Real time, left, right, bow = 0;
};

// (amplitude + growth*d)*sin(angular*d + phase) from `start` on, d after it.
struct Wave {
    Real amplitude, angular, phase, start = 0, growth = 0;
};

struct Pressure {
    std::vector<Knot> knots; // ascending
    std::vector<Wave> waves;
};

struct Element {
    double modulus, viscosity;
};

struct Responses {
    Real strain, integral, rate, acceleration; // integral: with an adaptation time y of tau_a*y' = -y + tau_a*strain
};

// The time of an output, or of a field, in ascending order.
struct Instant {
    Real time;
    long long row = -1; // of the traces; -1 for the time of a field alone
    long since = -1;    // the instant of the row before, where acceleration is the mean since then; -1: the density
};

// A pressure made ready for many materials: what it is, its slope and its integrals at each instant, as left limits.
class PreparedPressure {
  public:
    PreparedPressure(Pressure, const std::vector<Instant>&);

    // The left limits at each instant, 0 at t = 0.
    std::vector<Responses> responses(const Element&, const std::optional<double>& adaptation) const;

  private:
    struct Jump {
        Real time, jump, bend, bow; // of the pressure, of its slope, and of its second derivative
    };
    struct State {
        Real value, slope, bow, integral, second_integral;
        size_t jumps = 0; // the jumps before this instant
    };
    std::vector<Real> sums(const Real& time_constant) const;
    std::vector<Real> decays(const Real& time_constant) const;
    struct PreparedWave {
        Wave wave;
        std::vector<std::pair<Real, Real>> at; // sine and cosine at each instant from its start on
    };
    void add_wave(std::vector<Responses>&, const PreparedWave&, const Element&,
                  const std::optional<Real>& adaptation) const;
    std::vector<Real> decays_from(const Real& start, const Real& time_constant) const;

    const std::vector<Instant>& instants_;
    std::vector<PreparedWave> waves_;
    std::vector<Jump> jumps_;
    std::vector<State> states_;
};

} // namespace oracle
