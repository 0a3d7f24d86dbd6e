// SPDX-License-Identifier: MIT
// The cells that given points of the skin and their stencils read.
#pragma once

#include "host/core/model/skin.hpp"

namespace dermis::plan {

// The cells where pressure may ever act. All others stay at rest.
struct PressedCells {
    PressedBox box;
    const double* pressure = nullptr; // width*height: cells where it is 0 are not pressed; null: the whole box is
};

std::vector<Cell> cells_of(const std::vector<Site>&); // in the order of the sites

struct SiteCells {
    SiteCells(const PreparedSkin&, const PressedCells&, const std::vector<Cell>& points);
    std::vector<Cell> points;
    std::vector<size_t> cells;      // y*width + x, ascending, unique; without cells that are never pressed
    std::vector<Element> materials; // the elements of the cells; coefficients of a step are in this order
    Chain chain;                    // how many consecutive elements of `materials` belong to one cell
    std::vector<int> material_of;   // index of each cell's first element
};
bool ever_pressed(const PressedCells&, size_t cell, int width);

// The cells that the stencil of one point reads, as indices into SiteCells::cells. The index cells.size() stands for a
// cell that is never pressed.
struct StencilCells {
    size_t here;
    size_t x[4], y[4]; // far_low, low, high, far_high along each axis
};
StencilCells stencil_cells_of(const PreparedSkin&, const SiteCells&, Cell);

} // namespace dermis::plan
