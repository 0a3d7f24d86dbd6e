// SPDX-License-Identifier: MIT
// Puts the samples of a run where they belong in its Result, and compares the bits of two runs.
#pragma once

#include "host/plan/stepper.hpp"

namespace dermis {

// The quantities of which anything is asked.
std::vector<Quantity> asked_of(const plan::Schedule&);

class Collector {
  public:
    // everything_known: otherwise the run knows no cells but the schedule's points.
    Collector(Result&, const plan::PreparedSkin&, const plan::Schedule&, bool everything_known);

    void operator()(const plan::Step&, const plan::Sample&);

    // Throws Error::bad_input where a step has left the numbers. With allow_unstable growth without end is what was
    // asked for.
    void check_finite(double value, Quantity, double time) const;

  private:
    void take_traces(const plan::Step&, const plan::Sample&);
    void take_sites(const plan::Step&, const plan::Sample&);
    void take_impulses(const plan::Step&, const plan::Sample&);

    Result& result_;
    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    const bool everything_known_;
    const std::vector<Quantity> asked_;
};

// A second stepper that takes the same steps; every cell of every output is compared, and every sample.
class CrossCheck {
  public:
    using MakeStepper = std::function<std::unique_ptr<plan::Stepper>(plan::Stepper::Sink)>;
    // Counts into `result`.
    CrossCheck(const MakeStepper&, Result& result, const plan::PreparedSkin&, const plan::Schedule&);

    void frame(const std::vector<double>& pressure) { stepper_->frame(pressure); }
    void press(const plan::Step&, plan::Stepper& first);
    void finish();

  private:
    Result& result_;
    const std::vector<Quantity> asked_;
    Result other_result_;
    std::vector<std::vector<double>> ours_, theirs_;
    Collector collect_;
    std::unique_ptr<plan::Stepper> stepper_;
};

} // namespace dermis
