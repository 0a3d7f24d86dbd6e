// SPDX-License-Identifier: MIT
// Steps the cells of SiteCells, one step at a time, in K = f32 or f64. Cells are indexed as in SiteCells::cells; one
// more at the end stands for all that are never pressed and stays at rest. The state of a cell is that of each of its
// elements in series, whose strains and signals add up.
#pragma once

#include "host/plan/laplacian.hpp"
#include "host/plan/site_cells.hpp"

#include <algorithm>

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

    SiteStepper(const PreparedSkin& skin, const SiteCells& cells, const Variant& variant)
        : skin_(skin), cells_(cells), variant_(variant), chain_(cells.chain), state_((cells.cells.size() + 1) * chain_),
          visible_(state_.size()) {}

    Point point(Cell c) const {
        return {stencil_cells_of(skin_, cells_, c), K::axis(c.x, skin_.width(), skin_.stencil, skin_.edges),
                K::axis(c.y, skin_.height(), skin_.stencil, skin_.edges), real(rest_curvature_at(skin_, c))};
    }

    // Steps cells first .. last - 1. k: coefficients of each material.
    void advance(const Constants& c, const LaneCoefficients* k, Pressures p, size_t first, size_t last) {
        for (size_t i = first; i < last; ++i)
            for (size_t e = 0, at = i * chain_; e < chain_; ++e, ++at)
                visible_[at] = K::advanced(state_[at], load_at(i, c, p), of_element(k, i, e), variant_.compensated);
    }

    // The value of a quantity in a point after advance(). The point's cell must be one that is ever pressed.
    real value(const Point& point, Quantity q, const Constants& c, const LaneCoefficients* k, Pressures p) const {
        const size_t here = point.stencil.here;
        const real eps = strain(here);
        if (q == Quantity::strain) return eps;
        const real L = K::add(along(point.stencil.x, eps, point.x), along(point.stencil.y, eps, point.y)),
                   C = K::curvature_of(point.rest_curvature, L, c.bend);
        real x = 0;
        for (size_t e = 0, at = here * chain_; e < chain_; ++e, ++at) {
            const real of = K::signal(int(q), state_[at], visible_[at], load_at(here, c, p), of_element(k, here, e));
            x = e == 0 ? of : x + of;
        }
        return K::answer(int(q), x, C, c);
    }

    void keep() { state_.swap(visible_); }
    void reset() { std::fill(state_.begin(), state_.end(), typename K::CellState{}); }

  private:
    const LaneCoefficients& of_element(const LaneCoefficients* k, size_t cell, size_t element) const {
        return k[size_t(cells_.material_of[cell]) + element];
    }

    // The strain of a cell after advance().
    real strain(size_t cell) const {
        real eps = visible_[cell * chain_].strain.value;
        for (size_t e = 1; e < chain_; ++e) eps = eps + visible_[cell * chain_ + e].strain.value;
        return eps;
    }

    typename K::Load load_at(size_t i, const Constants& c, Pressures p) const {
        return variant_.framed ? K::load_between(p.from[i], p.to[i], c) : K::load_of(p.from[i], c);
    }

    real along(const size_t (&cells)[4], real centre, const typename K::Axis& axis) const {
        const auto eps = [&](int i) { return strain(cells[i]); };
        return K::difference(eps(0), eps(1), centre, eps(2), eps(3), axis, variant_.stencil);
    }

    const PreparedSkin& skin_;
    const SiteCells& cells_;
    const Variant variant_;
    const size_t chain_;
    std::vector<typename K::CellState> state_, visible_; // state at the step's start; at its end
};

} // namespace dermis::plan
