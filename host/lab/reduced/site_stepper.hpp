// SPDX-License-Identifier: MIT
// Steps the cells of SiteCells, one step at a time, in K = f32, f64 or extended. Cells are indexed as in
// SiteCells::cells; one more at the end stands for all cells that are never pressed, and stays at rest.
#pragma once

#include "host/core/model/site_cells.hpp"
#include "host/lab/schedule/cell.hpp"
#include "host/lab/schedule/schedule.hpp"

#include <vector>

namespace dermis::plan {

template <class K> class SiteStepper {
  public:
    using real = typename K::real;
    using Constants = typename K::Constants;
    using LaneCoefficients = typename K::LaneCoefficients;

    SiteStepper(const PreparedSkin& skin, const Schedule& schedule, const SiteCells& cells)
        : cells_(cells), variant_(variant_of(skin, schedule, Precision::f64)), shape_(variant_.state()),
          sums_(SingleCell<K>::sums(shape_)), state_(cells.cells.size() * sums_), visible_(state_.size()),
          strain_(cells.cells.size() + 1), from_(cells.cells.size()), to_(from_) {
        if (!schedule.framed) frame(schedule.pressure);
    }

    void frame(const std::vector<double>& pressure) { // as Stepper::frame
        from_.swap(to_);
        for (size_t i = 0; i < to_.size(); ++i) to_[i] = real(pressure[cells_.cells[i]]);
    }

    // Steps cells first .. last - 1. k: coefficients of each material.
    void advance(const Constants& c, const LaneCoefficients* k, size_t first, size_t last) {
        for (size_t i = first; i < last; ++i)
            strain_[i] = K::step_of(cell(k, i, &visible_[i * sums_]), load_at(i, c)).motion.strain;
    }

    // The value of a quantity in a point after advance(). The point's cell must be one that is ever pressed.
    real value(const SitePlace<K>& point, Quantity q, const Constants& c, const LaneCoefficients* k) const {
        const size_t here = point.stencil.here;
        if (q == Quantity::strain) return strain_[here];
        const real C = point.curvature(strain_.data(), variant_.stencil, c.bend);
        if (q == Quantity::curvature) return C;
        const auto step = K::step_of(cell(k, here, nullptr), load_at(here, c));
        return K::answer(int(q), K::signal(int(q), step.motion, step.integral), C, c);
    }

    void keep() { state_.swap(visible_); }

  private:
    SingleCell<K> cell(const LaneCoefficients* k, size_t i, typename K::Sum* after) const {
        return {shape_, k + (1 + variant_.bent) * cells_.material_of[i], &state_[i * sums_], after};
    }

    typename K::Load load_at(size_t i, const Constants& c) const {
        return variant_.framed ? K::load_between(from_[i], to_[i], c) : K::load_of(to_[i], c);
    }

    const SiteCells& cells_;
    const Variant variant_;
    const StateShape shape_;
    const size_t sums_;                            // of a cell
    std::vector<typename K::Sum> state_, visible_; // state at the step's start; at its end
    std::vector<real> strain_;                     // of each cell at the step's end
    std::vector<real> from_, to_;                  // pressure of each cell: of the frames, or in to_ the map's
};

} // namespace dermis::plan
