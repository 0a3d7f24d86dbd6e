// SPDX-License-Identifier: MIT
// The model `sites`: a march, in double, of no more cells than some places and their stencils need. A place has the
// bits that the CPU path in double gives its cell.
#pragma once

#include "host/plan/marcher.hpp"

#include <memory>

namespace dermis::model {

struct SiteCells {
    SiteCells(const plan::Plan&, const std::vector<Cell>& places);
    std::vector<Cell> places;
    std::vector<size_t> cells;       // y*width + x, ascending, each once; without those that are never pressed
    std::vector<plan::Medium> media; // theirs; rows of a step come in this order
    std::vector<int> material;       // which of media each of cells is
};

// The cells that the stencil of one place reads, by their rank among SiteCells::cells; one behind them: never pressed.
struct Looks {
    size_t here;
    size_t x[4], y[4]; // far_low, low, high, far_high along each axis
};
Looks looks_of(const plan::Plan&, const SiteCells&, Cell);

// Takes the steps of plan::timing(plan, cells.media, ..). threads: 0 = one per core.
std::unique_ptr<plan::Marcher> sites(const plan::Plan&, const SiteCells& cells, int threads, plan::Marcher::Sink);

} // namespace dermis::model
