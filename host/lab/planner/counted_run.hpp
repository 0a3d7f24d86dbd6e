// SPDX-License-Identifier: MIT
// The steps of a run in counted arithmetic: one cell of each material, under the schedule's load per unit of the map.
#pragma once

#include "host/lab/planner/counted_cell.hpp"
#include "host/lab/schedule/references.hpp"

namespace dermis::planner {

// A material of a run, and how its cell is computed. peak: the greatest |pressure| on the cells that are read; that of
// the depth where it is least. Frames press such a cell by no more, if others by far more.
struct CountedMaterial {
    model::Element element;
    Rounding rounding;
    double peak;
};

// A cell that is stepped for all others, as in models of products: by the run's own operations in double, and once more
// in long double. Its error is then the distance of the two, and needs no count of roundings.
class MeasuredCell {
  public:
    MeasuredCell(const model::Chain& chain, const model::Element* elements, double duration)
        : run_(chain, elements, duration), reference_(chain, elements, duration) {}

    void press(const f64::Load& load, const f64::Coefficients* k, const extended::Load& exact,
               const extended::Coefficients* exact_k) {
        run_.press(load, k);
        reference_.press(exact, exact_k);
        for (int q = 0; q < REDUCED_MAPS; ++q) exact_[size_t(q)] = reference_.signal(q);
    }
    // The mean acceleration of the reference becomes the change of its rate over the step of `length` seconds, without
    // the rounding of terms that cancel.
    void take_change_of_rate(long double length) {
        exact_[QUANTITY_FA2] = (reference_.signal(QUANTITY_FA1) - reference_.kept(QUANTITY_FA1)) / length;
    }
    // The step leads to the state from which the next one starts.
    void keep() {
        run_.keep();
        reference_.keep();
    }
    // The error of a signal of the run after the step, without its reference's error.
    double off(int q) const { return double(std::abs(run_.signal(q) - exact_[size_t(q)])); }

  private:
    model::ProductCell<f64> run_;
    model::ProductCell<extended> reference_;
    std::array<long double, REDUCED_MAPS> exact_{};
};

// The schedule and the materials must outlive the run.
class CountedRun {
  public:
    // chain: how many consecutive materials are the elements in series of one cell. product: one cell is stepped for
    // all others, and measured; the arithmetic is then the references'.
    CountedRun(const model::Schedule&, const std::vector<CountedMaterial>&, const model::ResponseRule&, Method,
               const model::Chain& chain = {}, bool product = false);

    // Takes the steps up to the next one whose end is read, an output or a field; false where there is none left.
    bool next();
    const model::Step& step() const { return step_; }
    // The cells at the end of that step.
    const std::vector<CountedCell>& cells() const { return step_.keep ? kept_ : now_; }
    // The error of a signal of the run of a product at the end of that step, beside its reference's error.
    double measured(size_t cell, int q) const { return products_.empty() ? 0 : products_[cell].off(q); }

  private:
    double unit() const { return measured_ ? unit_of_reference : unit_of_double; } // of coefficients and load
    counted::Load load_over(const model::Step&, const CountedMaterial&);
    void make_step(const model::Step&, size_t first);
    void press(size_t cell, const model::Step&);
    void measure(size_t cell, const model::Step&);
    void add_bend(CountedCell&, const model::Element&, const model::Step&) const;

    const model::Schedule& schedule_;
    const std::vector<CountedMaterial>& materials_;
    const model::ResponseRule rule_;
    const model::Chain chain_;
    const std::vector<model::Element> elements_;
    model::Timeline timeline_;
    model::Step step_; // the last one
    model::References references_;
    const double envelope_peak_;
    const bool is_wave_;                  // the load is a sine that is not held over the steps
    bool measured_ = false;               // the step's coefficients and load are compared with references
    double start_off_ = 0, jump_off_ = 0; // its load less its references
    std::vector<CountedCell> kept_, now_;
    std::vector<MeasuredCell> products_; // one for each cell
    // Of the cell that is pressed:
    CountedStep pressed_;
    std::array<f64::Coefficients, scene::most_in_series> k_;
    std::array<extended::Coefficients, scene::most_in_series> references_of_;
};

} // namespace dermis::planner
