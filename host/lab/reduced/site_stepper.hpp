// SPDX-License-Identifier: MIT
// Steps the cells of SiteCells, one step at a time, in K = f32, f64 or extended. Cells are indexed as in
// SiteCells::cells; one more stands for all cells that are never pressed, and stays at rest. Behind it are the deep
// cells: cells under the stress at the depth of a class, whose response in some point they are.
#pragma once

#include "host/core/model/site_cells.hpp"
#include "host/lab/schedule/cell.hpp"
#include "host/lab/schedule/schedule.hpp"

#include <vector>

namespace dermis::plan {

// The deep cells of points, and which of them is each point's, by quantity: a number of SiteStepper's cells, 0 if none.
struct DeepCells {
    struct Place {
        Cell cell;
        size_t number; // of the cell, y*width + x
        size_t quantity;
    };
    // classes: the quantity that each point is asked for; below 0: all.
    DeepCells(const PreparedSkin& skin, const Schedule& schedule, const SiteCells& cells,
              const std::vector<int>& classes)
        : of_point(classes.size()) {
        for (size_t i = 0; i < classes.size(); ++i)
            for (size_t q = 0; q < schedule.half_space.size(); ++q)
                if (schedule.half_space[q] && (classes[i] < 0 || classes[i] == int(q))) {
                    places.push_back({cells.points[i], skin.number_of(cells.points[i]), q});
                    of_point[i][q] = cells.cells.size() + places.size();
                }
    }
    std::vector<Place> places;
    std::vector<std::array<size_t, size_t(Quantity::curvature) + 1>> of_point;
};

template <class K> class SiteStepper {
  public:
    using real = typename K::real;
    using Constants = typename K::Constants;
    using LaneCoefficients = typename K::LaneCoefficients;

    SiteStepper(const PreparedSkin& skin, const Schedule& schedule, const SiteCells& cells,
                const std::vector<DeepCells::Place>& deep)
        : schedule_(schedule), cells_(cells), deep_(deep), variant_(variant_of(skin, schedule, Precision::f64)),
          shape_(variant_.state()), sums_(SingleCell<K>::sums(shape_)), state_(size() * sums_), visible_(state_.size()),
          strain_(size()), from_(size()), to_(from_) {
        if (!schedule.framed) frame(schedule.pressure);
    }

    // The number of cells, with the one at rest and the deep ones.
    size_t size() const { return cells_.cells.size() + 1 + deep_.size(); }

    void frame(const std::vector<double>& pressure) { // as Stepper::frame
        from_.swap(to_);
        for (size_t i = 0; i < cells_.cells.size(); ++i) to_[i] = real(pressure[cells_.cells[i]]);
        for (size_t i = 0; i < deep_.size(); ++i) {
            const auto& [cell, number, q] = deep_[i];
            using Sum = std::conditional_t<(sizeof(real) > sizeof(double)), long double, double>;
            const Map& stress = schedule_.stress[q]; // long double takes the sum itself
            to_[cells_.cells.size() + 1 + i] = stress.empty() || sizeof(real) > sizeof(double)
                                                   ? real(schedule_.half_space[q]->at<Sum>(pressure, cell))
                                                   : real(stress[number]);
        }
    }

    // Steps cells first .. last - 1 of size(). k: coefficients of each material.
    void advance(const Constants& c, const LaneCoefficients* k, size_t first, size_t last) {
        for (size_t i = first; i < last; ++i)
            strain_[i] = K::step_of(cell(k, i, &visible_[i * sums_]), load_at(i, c)).motion.strain;
    }

    // The value of a quantity in a point after advance(). deep: its deep cell, or 0.
    real value(const SitePlace<K>& point, Quantity q, size_t deep, const Constants& c,
               const LaneCoefficients* k) const {
        if (q == Quantity::strain) return strain_[point.stencil.here];
        const real C = point.curvature(strain_.data(), variant_.stencil, c.bend);
        if (q == Quantity::curvature) return C;
        const size_t here = deep ? deep : point.stencil.here;
        const auto step = K::step_of(cell(k, here, nullptr), load_at(here, c));
        return K::answer(int(q), K::signal(int(q), step.motion, step.integral), C, c);
    }

    void keep() { state_.swap(visible_); }

  private:
    SingleCell<K> cell(const LaneCoefficients* k, size_t i, typename K::Sum* after) const {
        const int material = i < cells_.cells.size() ? cells_.material_of[i] : 0; // deep cells: a uniform skin's
        return {shape_, k + (1 + variant_.bent) * material, &state_[i * sums_], after};
    }

    typename K::Load load_at(size_t i, const Constants& c) const {
        return variant_.framed ? K::load_between(from_[i], to_[i], c) : K::load_of(to_[i], c);
    }

    const Schedule& schedule_;
    const SiteCells& cells_;
    const std::vector<DeepCells::Place>& deep_;
    const Variant variant_;
    const StateShape shape_;
    const size_t sums_;                            // of a cell
    std::vector<typename K::Sum> state_, visible_; // state at the step's start; at its end
    std::vector<real> strain_;                     // of each cell at the step's end
    std::vector<real> from_, to_;                  // pressure of each cell: of the frames, or in to_ the map's
};

} // namespace dermis::plan
