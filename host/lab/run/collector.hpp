// SPDX-License-Identifier: MIT
// What fills a Result: collects the samples of a run, compares the bits of two runs, and fires nerve fibres.
#pragma once

#include "dermis/run.hpp"
#include "host/lab/march/stepper.hpp"

namespace dermis {

class Collector {
  public:
    // every_cell: the run computes every cell, otherwise only the schedule's points.
    Collector(Result&, const model::PreparedSkin&, const model::Schedule&, bool every_cell);

    void operator()(const model::Step&, const model::Sample&);

    // Throws Error::bad_input where a value is not finite, unless the schedule allows unstable steps.
    void check_finite(double value, Quantity, double time) const;

  private:
    void check_sample(const model::Sample&, Quantity, double time) const;
    void take_traces(const model::Sample&);
    void take_sites(const model::Step&, const model::Sample&);
    void take_impulses(const model::Step&, const model::Sample&);

    Result& result_;
    const model::PreparedSkin& skin_;
    const model::Schedule& schedule_;
    const bool every_cell_;
    const std::vector<Quantity> wanted_;
};

// Takes the steps of a march in float with a second one, and compares every cell of every output and every sample.
class CrossCheck {
  public:
    using MakeStepper = std::function<std::unique_ptr<model::Stepper>(model::Stepper::Sink)>;
    // Counts in `result` the cells that are compared and the cells that differ.
    CrossCheck(const MakeStepper&, Result& result, const model::PreparedSkin&, const model::Schedule&);

    void frame(const std::vector<double>& pressure) { stepper_->frame(pressure); }
    void press(const model::Step&, model::Stepper& first);
    void finish();

  private:
    Result& result_;
    const model::PreparedSkin& skin_;
    const std::vector<Quantity> wanted_;
    Result other_result_;
    Collector collect_;
    std::unique_ptr<model::Stepper> stepper_;
    std::vector<std::vector<double>> ours_, theirs_; // maps at an output
};

constexpr double share_of_fibres = 0.5; // of the progress of a run that has fibres

// Returns the spikes of a scene by time, then by fibre. afferents: the scene's, validated. threads: as for Device::cpu.
std::vector<FiredSpike> spikes_of(const Scene&, const std::vector<Afferents>& afferents, int threads);

} // namespace dermis
