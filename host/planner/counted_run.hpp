// SPDX-License-Identifier: MIT
// The steps of a run in counted arithmetic: one cell of each material, under the schedule's load per unit of the map.
#pragma once

#include "host/plan/references.hpp"
#include "host/planner/arithmetic.hpp"
#include "host/planner/measured_cell.hpp"

namespace dermis::planner {

// A material of a run, how its cell is computed, and the greatest |pressure| on it.
struct CountedMaterial {
    plan::Element element;
    CountedArithmetic arithmetic;
    double peak;
};

// The schedule and the materials outlive the run.
class CountedRun {
  public:
    // chain: how many of the materials, one after another, are elements in series of one cell. product: cells are
    // stepped for all others, and measured; the arithmetic is that of references.
    CountedRun(const plan::Schedule&, const std::vector<CountedMaterial>&, const plan::ResponseRule&, Method,
               const plan::Chain& chain = {}, bool product = false);

    // Takes the steps up to the next one whose end is read, an output or a field; false where there is none left.
    // impulses: up to those of the load's jumps too, at which rates and accelerations are the impulses.
    bool next(bool impulses = false);
    const plan::Step& step() const { return step_; }
    bool at_impulse() const { return step_.impulse >= 0; }
    // The cell of each material at the end of that step.
    const std::vector<CountedCell>& cells() const { return now_; }
    // The error of a signal of the run of a product at the end of that step, beside its reference's error.
    double measured(size_t cell, int q) const { return products_.empty() ? 0 : products_[cell].off(q); }

  private:
    CountedLoad load_over(const plan::Step&, const CountedMaterial&) const;
    void press(size_t first, const plan::Step&);
    void measure(size_t first, const plan::Step&, const f64::Coefficients* k, extended::Coefficients* references);
    void add_bend(CountedCell&, const plan::Element&, const plan::Step&) const;

    const plan::Schedule& schedule_;
    const std::vector<CountedMaterial>& materials_;
    const plan::ResponseRule rule_;
    const plan::Chain chain_;
    const std::vector<plan::Element> elements_;
    plan::Timeline timeline_;
    plan::Step step_; // the last one
    plan::References references_;
    const double envelope_peak_;
    bool measured_ = false;                   // the step's coefficients and load are compared with references
    std::optional<double> angular_frequency_; // of a sine that is not held over the steps
    std::vector<CountedCell> kept_, now_;
    std::vector<MeasuredCell> products_; // one for each cell
};

} // namespace dermis::planner
