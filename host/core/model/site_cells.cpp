// SPDX-License-Identifier: MIT
#include "host/core/model/site_cells.hpp"

#include <algorithm>
#include <map>

namespace dermis::model {
namespace {

// A point and its neighbours as y*width + x. For the five-point stencil the far ones repeat the near.
StencilCells numbers_of(const PreparedSkin& skin, Cell c) {
    const size_t width = size_t(skin.width());
    const f64::Axis x = f64::axis(c.x, skin.width(), skin.stencil, skin.edges);
    const f64::Axis y = f64::axis(c.y, skin.height(), skin.stencil, skin.edges);
    const int xs[] = {x.far_low, x.low, x.high, x.far_high}, ys[] = {y.far_low, y.low, y.high, y.far_high};
    StencilCells n{.here = skin.number_of(c), .x = {}, .y = {}};
    for (int i = 0; i < 4; ++i) {
        n.x[i] = size_t(c.y) * width + size_t(xs[i]);
        n.y[i] = size_t(ys[i]) * width + size_t(c.x);
    }
    if (f64::reach(skin.stencil) == 1)
        for (size_t* along : {n.x, n.y}) along[0] = along[1], along[3] = along[2];
    return n;
}

} // namespace

SiteCells site_cells_of(const PreparedSkin& skin) {
    std::vector<Cell> points;
    for (const Site& site : skin.description.sites) points.push_back(site.cell);
    return {skin, {skin.whole()}, points};
}

bool ever_pressed(const PressedCells& pressed, size_t cell, int width) {
    if (pressed.pressure) return pressed.pressure[cell] != 0;
    const int x = int(cell % size_t(width)), y = int(cell / size_t(width));
    const PressedBox& box = pressed.box;
    return y >= box.first_row && y < box.last_row && x >= box.first_column() && x < box.last_tile * TILE_CELLS;
}

SiteCells::SiteCells(const PreparedSkin& skin, const PressedCells& pressed, const std::vector<Cell>& at)
    : points(at), chain(skin.chain) {
    const bool many = points.size() > skin.cells() / 256; // then marking cells is faster than sorting them
    std::vector<bool> marked(many ? skin.cells() : 0);
    const auto add = [&](size_t cell) {
        if (!ever_pressed(pressed, cell, skin.width())) return false;
        if (many) marked[cell] = true;
        else cells.push_back(cell);
        return true;
    };
    for (const Cell& c : points) {
        const StencilCells n = numbers_of(skin, c);
        if (!add(n.here) && !pressed.spread) continue;
        for (const auto& along : {n.x, n.y})
            for (int i = 0; i < 4; ++i) add(along[i]);
    }
    for (size_t cell = 0; cell < marked.size(); ++cell)
        if (marked[cell]) cells.push_back(cell);
    if (!many) std::ranges::sort(cells);
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    std::map<int, int> known;
    for (size_t cell : cells) {
        const int kind = int(skin.material_at(cell));
        const auto [rank, fresh] = known.try_emplace(kind, int(materials.size()));
        if (fresh)
            materials.insert(materials.end(), skin.materials.begin() + kind,
                             skin.materials.begin() + kind + long(chain.length));
        material_of.push_back(rank->second);
    }
    if (materials.empty()) // a timeline has at least one
        materials.assign(skin.materials.begin(), skin.materials.begin() + long(chain.length));
}

StencilCells stencil_cells_of(const PreparedSkin& skin, const SiteCells& cells, Cell c) {
    StencilCells n = numbers_of(skin, c);
    const auto rank = [&](size_t cell) {
        const auto at = std::lower_bound(cells.cells.begin(), cells.cells.end(), cell);
        return size_t((at != cells.cells.end() && *at == cell ? at : cells.cells.end()) - cells.cells.begin());
    };
    n.here = rank(n.here);
    for (size_t* along : {n.x, n.y}) std::transform(along, along + 4, along, rank);
    return n;
}

} // namespace dermis::model
