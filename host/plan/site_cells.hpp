// SPDX-License-Identifier: MIT
// The cells that some points of the skin and their stencils need, and no others.
#pragma once

#include "host/plan/plan.hpp"

namespace dermis::plan {

bool ever_pressed(const Plan&, size_t cell);

struct SiteCells {
    SiteCells(const Plan&, const std::vector<Cell>& places);
    std::vector<Cell> places;
    std::vector<size_t> cells;       // y*width + x, ascending, each once; without those that are never pressed
    std::vector<Medium> media; // theirs; rows of a step come in this order
    std::vector<int> material;       // which of media each of cells is
};

// The cells that the stencil of one place reads, by their rank among SiteCells::cells; one behind them: never pressed.
struct StencilCells {
    size_t here;
    size_t x[4], y[4]; // far_low, low, high, far_high along each axis
};
StencilCells stencil_cells_of(const Plan&, const SiteCells&, Cell);

} // namespace dermis::plan
