// SPDX-License-Identifier: MIT
// Steps the cells of SiteCells, one step at a time, in K = f32, f64 or extended. Cells are indexed as in
// SiteCells::cells; one more stands for all cells that are never pressed, and stays at rest. Behind it are the deep
// cells: cells under the stress at the depth of a class, whose response in some point they are; and, where a class
// follows the stress under frames, one cell for each of Schedule::modes.
#pragma once

#include "host/core/model/site_cells.hpp"
#include "host/lab/schedule/cell.hpp"
#include "host/lab/schedule/schedule.hpp"

#include <vector>

namespace dermis::model {

// The deep cells of points, and which of them is each point's, by quantity: a number of SiteStepper's cells, 0 if none.
struct DeepCells {
    struct Place {
        Cell cell;
        size_t number; // of the cell, y*width + x
        size_t quantity;
        size_t material; // 0, or the place of its mode among the elements of elements_of()
    };
    // classes: the quantity that each point is asked for; below 0: all.
    DeepCells(const PreparedSkin& skin, const Schedule& schedule, const SiteCells& cells,
              const std::vector<int>& classes)
        : of_point(classes.size()) {
        for (size_t i = 0; i < classes.size(); ++i)
            for (size_t q = 0; q < schedule.half_space.size(); ++q) {
                const bool sums = schedule.sums_modes(q);
                if (!(schedule.half_space[q] || sums) || (classes[i] >= 0 && classes[i] != int(q))) continue;
                of_point[i][q] = cells.cells.size() + 1 + places.size();
                for (size_t m = 0; m < (sums ? schedule.modes.size() : 1); ++m)
                    places.push_back(
                        {cells.points[i], skin.number_of(cells.points[i]), q, sums ? skin.materials.size() + m : 0});
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
            const auto& [cell, number, q, material] = deep_[i];
            real& to = to_[cells_.cells.size() + 1 + i];
            using Sum = std::conditional_t<(sizeof(real) > sizeof(double)), long double, double>;
            const Map& stress = schedule_.stress[q]; // long double takes the sum itself
            if (!schedule_.half_space[q]) to = real(pressure[number]);
            else if (!stress.empty() && sizeof(real) == sizeof(double)) to = real(stress[number]);
            else to = real(schedule_.half_space[q]->at<Sum>(pressure, cell));
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
        const auto signal = [&](size_t i) {
            const auto step = K::step_of(cell(k, i, nullptr), load_at(i, c));
            return K::signal(int(q), step.motion, step.integral);
        };
        if (!schedule_.sums_modes(size_t(q))) return K::answer(int(q), signal(here), K::gain_at(C, c), c);
        real stress = 0;
        for (size_t m = 0; m < schedule_.modes.size(); ++m) stress += real(schedule_.shares[m]) * signal(here + m);
        return K::answer(int(q), stress, K::gain_at(C, c), c);
    }

    void keep() { state_.swap(visible_); }

  private:
    SingleCell<K> cell(const LaneCoefficients* k, size_t i, typename K::Sum* after) const {
        const size_t n = cells_.cells.size(), material = i < n    ? size_t(cells_.material_of[i])
                                                         : i == n ? 0
                                                                  : deep_[i - n - 1].material;
        return {shape_, k + (1 + variant_.parabolic) * material, &state_[i * sums_], after};
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

} // namespace dermis::model
