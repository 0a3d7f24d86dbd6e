// SPDX-License-Identifier: MIT
// The cells that given points of the skin and their stencils read.
#pragma once

#include "host/core/model/laplacian.hpp"

namespace dermis::model {

// The cells where pressure may ever act. All others stay at rest.
struct PressedCells {
    PressedBox box;
    const double* pressure = nullptr; // width*height: cells where it is 0 are not pressed; null: the whole box is
    bool spread = false;              // it acts below other cells too: a point that is never pressed has a response
};

struct SiteCells {
    SiteCells(const PreparedSkin&, const PressedCells&, const std::vector<Cell>& points);
    std::vector<Cell> points;
    std::vector<size_t> cells;      // y*width + x, ascending, unique; without cells that are never pressed
    std::vector<Element> materials; // the elements of the cells; coefficients of a step are in this order
    Chain chain;                    // how many consecutive elements of `materials` belong to one cell
    std::vector<int> material_of;   // index of each cell's first element
};
// The cells that the sites of a skin read; no cells without sites.
SiteCells site_cells_of(const PreparedSkin&);
bool ever_pressed(const PressedCells&, size_t cell, int width);

// The cells that the stencil of one point reads, as indices into SiteCells::cells. The index cells.size() stands for a
// cell that is never pressed.
struct StencilCells {
    size_t here;
    size_t x[4], y[4]; // far_low, low, high, far_high along each axis
};
StencilCells stencil_cells_of(const PreparedSkin&, const SiteCells&, Cell);

// A receptor, or another point, among the cells of SiteCells, in K = f32, f64 or extended.
template <class K> struct SitePlace {
    using real = typename K::real;
    SitePlace(const PreparedSkin& skin, const SiteCells& cells, Cell c)
        : stencil(stencil_cells_of(skin, cells, c)), x(K::axis(c.x, skin.width(), skin.stencil, skin.edges)),
          y(K::axis(c.y, skin.height(), skin.stencil, skin.edges)), rest_curvature(real(rest_curvature_at(skin, c))) {}

    // The skin's curvature here. strain: of the cells of SiteCells, and 0 behind them. kind: the stencil.
    real curvature(const real* strain, int kind, real bend) const {
        const real eps = strain[stencil.here];
        const auto along = [&](const size_t(&at)[4], const typename K::Axis& axis) {
            return K::difference(strain[at[0]], strain[at[1]], eps, strain[at[2]], strain[at[3]], axis, kind);
        };
        return K::curvature_of(rest_curvature, K::add(along(stencil.x, x), along(stencil.y, y)), bend);
    }

    StencilCells stencil;
    typename K::Axis x, y;
    real rest_curvature;
};

} // namespace dermis::model
