// SPDX-License-Identifier: MIT
#include "host/plan/site_cells.hpp"

#include <algorithm>
#include <unordered_map>

namespace dermis::plan {
namespace {

// Along each axis: far_low, low, high, far_high; the nearest stencil looks no further than low and high.
struct Neighbours {
    size_t x[4], y[4]; // y*width + x
};

Neighbours neighbours_of(const Plan& plan, Cell c) {
    const size_t width = size_t(plan.constants.width);
    const f64::Axis x = f64::axis(c.x, plan.constants.width, plan.stencil, plan.edges);
    const f64::Axis y = f64::axis(c.y, plan.constants.height, plan.stencil, plan.edges);
    const int xs[] = {x.far_low, x.low, x.high, x.far_high}, ys[] = {y.far_low, y.low, y.high, y.far_high};
    Neighbours n;
    for (int i = 0; i < 4; ++i) {
        n.x[i] = size_t(c.y) * width + size_t(xs[i]);
        n.y[i] = size_t(ys[i]) * width + size_t(c.x);
    }
    if (plan.stencil == STENCIL_FIVE_POINT)
        for (size_t* along : {n.x, n.y}) along[0] = along[1], along[3] = along[2];
    return n;
}

} // namespace

// Cells that are never pressed stay at rest: they are one cell, behind the others.
bool ever_pressed(const Plan& plan, size_t cell) {
    if (!plan.framed) return plan.maps.pressure[cell] != 0;
    const int x = int(cell % size_t(plan.constants.width)), y = int(cell / size_t(plan.constants.width));
    const Pressed& box = plan.pressed;
    return y >= box.first_row && y < box.last_row && x >= box.first_tile * TILE_CELLS && x < box.last_tile * TILE_CELLS;
}

SiteCells::SiteCells(const Plan& plan, const std::vector<Cell>& at) : places(at) {
    const size_t width = size_t(plan.constants.width);
    for (const Cell& c : places) {
        const Neighbours n = neighbours_of(plan, c);
        const size_t cell = size_t(c.y) * width + size_t(c.x);
        if (!ever_pressed(plan, cell)) continue;
        cells.push_back(cell);
        for (const auto& along : {n.x, n.y})
            for (int i = 0; i < 4; ++i)
                if (ever_pressed(plan, along[i])) cells.push_back(along[i]);
    }
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    std::unordered_map<int, int> known;
    for (size_t cell : cells) {
        const int kind = plan.material.empty() ? 0 : plan.material[cell / width * plan.pitch + cell % width];
        const auto [rank, fresh] = known.try_emplace(kind, int(media.size()));
        if (fresh) media.push_back(plan.media[size_t(kind)]);
        material.push_back(rank->second);
    }
    if (media.empty()) media.push_back(plan.media.front()); // a timeline has at least one
}

StencilCells stencil_cells_of(const Plan& plan, const SiteCells& cells, Cell c) {
    const auto rank = [&](size_t cell) {
        const auto at = std::lower_bound(cells.cells.begin(), cells.cells.end(), cell);
        return size_t((at != cells.cells.end() && *at == cell ? at : cells.cells.end()) - cells.cells.begin());
    };
    const Neighbours n = neighbours_of(plan, c);
    StencilCells looks{rank(size_t(c.y) * size_t(plan.constants.width) + size_t(c.x)), {}, {}};
    for (int i = 0; i < 4; ++i) {
        looks.x[i] = rank(n.x[i]);
        looks.y[i] = rank(n.y[i]);
    }
    return looks;
}

} // namespace dermis::plan
