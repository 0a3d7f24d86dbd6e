// SPDX-License-Identifier: MIT
// Steps the cells of SiteCells, one step at a time, in K = f32, f64 or extended. Cells are indexed as in
// SiteCells::cells; one more at the end stands for all cells that are never pressed, and stays at rest.
#pragma once

#include "host/core/model/laplacian.hpp"
#include "host/core/model/site_cells.hpp"
#include "host/lab/schedule/cell.hpp"

#include <vector>

namespace dermis::plan {

template <class K> class SiteStepper {
  public:
    using real = typename K::real;
    using Constants = typename K::Constants;
    using LaneCoefficients = typename K::LaneCoefficients;

    struct Point {
        StencilCells stencil;
        typename K::Axis x, y;
        real rest_curvature;
    };

    // The pressure of each cell over a step: from frame `from` to frame `to`, or only `from` under a map and envelope.
    struct Pressures {
        const real *from, *to;
    };

    SiteStepper(const SiteCells& cells, const Variant& variant)
        : cells_(cells), variant_(variant), shape_(shape_of(variant)), sums_(shape_.sums()),
          state_(cells.cells.size() * sums_), visible_(state_.size()), strain_(cells.cells.size() + 1) {}

    Point point(const PreparedSkin& skin, Cell c) const {
        return {stencil_cells_of(skin, cells_, c), K::axis(c.x, skin.width(), skin.stencil, skin.edges),
                K::axis(c.y, skin.height(), skin.stencil, skin.edges), real(rest_curvature_at(skin, c))};
    }

    // Steps cells first .. last - 1. k: coefficients of each material.
    void advance(const Constants& c, const LaneCoefficients* k, Pressures p, size_t first, size_t last) {
        for (size_t i = first; i < last; ++i)
            strain_[i] =
                press_cell<K>(&state_[i * sums_], &visible_[i * sums_], load_at(i, c, p), of_cell(k, i), shape_).strain;
    }

    // The value of a quantity in a point after advance(). The point's cell must be one that is ever pressed.
    real value(const Point& point, Quantity q, const Constants& c, const LaneCoefficients* k, Pressures p) const {
        const size_t here = point.stencil.here;
        const real eps = strain_[here];
        if (q == Quantity::strain) return eps;
        const real L = K::add(along(point.stencil.x, eps, point.x), along(point.stencil.y, eps, point.y)),
                   C = K::curvature_of(point.rest_curvature, L, c.bend);
        if (q == Quantity::curvature) return C;
        const typename K::Sum *before = &state_[here * sums_], *after = &visible_[here * sums_];
        const auto motion = motion_between<K>(before, after, load_at(here, c, p), of_cell(k, here), shape_);
        return K::answer(int(q), K::signal(int(q), motion, after[shape_.integral()].value), C, c);
    }

    void keep() { state_.swap(visible_); }

  private:
    // The coefficients of a cell's elements.
    const LaneCoefficients* of_cell(const LaneCoefficients* k, size_t cell) const {
        return k + cells_.material_of[cell];
    }

    typename K::Load load_at(size_t i, const Constants& c, Pressures p) const {
        return variant_.framed ? K::load_between(p.from[i], p.to[i], c) : K::load_of(p.from[i], c);
    }

    real along(const size_t (&cells)[4], real centre, const typename K::Axis& axis) const {
        const auto eps = [&](int i) { return strain_[cells[i]]; };
        return K::difference(eps(0), eps(1), centre, eps(2), eps(3), axis, variant_.stencil);
    }

    const SiteCells& cells_;
    const Variant variant_;
    const CellShape shape_;
    const size_t sums_;                            // of a cell
    std::vector<typename K::Sum> state_, visible_; // state at the step's start; at its end
    std::vector<real> strain_;                     // of each cell at the step's end
};

} // namespace dermis::plan
