// SPDX-License-Identifier: MIT
// The cells that some points of the skin and their stencils need, and no others.
#pragma once

#include "host/plan/schedule.hpp"

namespace dermis::plan {

// Where pressure may ever act. A cell elsewhere stays at rest.
struct PressedCells {
    PressedBox box;
    const double* pressure = nullptr; // width*height: without frames only where it is not 0
};

struct SiteCells {
    SiteCells(const PreparedSkin&, const PressedCells&, const std::vector<Cell>& points);
    std::vector<Cell> points;
    std::vector<size_t> cells;      // y*width + x, ascending, each once; without those that are never pressed
    std::vector<Element> materials; // theirs; the coefficients of a step come in this order
    std::vector<int> material_of;   // which of the materials each of cells has
};
PressedCells pressed_cells(const Schedule&);
bool ever_pressed(const PressedCells&, size_t cell, int width);

// The cells that the stencil of one point reads, by their rank among SiteCells::cells; one behind them: never pressed.
struct StencilCells {
    size_t here;
    size_t x[4], y[4]; // far_low, low, high, far_high along each axis
};
StencilCells stencil_cells_of(const PreparedSkin&, const SiteCells&, Cell);

} // namespace dermis::plan
