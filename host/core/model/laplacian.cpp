// SPDX-License-Identifier: MIT
#include "host/core/model/laplacian.hpp"

#include "host/core/base/watch.hpp"
#include "host/core/simd/isa.hpp"

#include <cmath>

namespace dermis::model {

std::vector<double> laplacian(const std::vector<double>& map, const Grid& grid, int stencil, int edges) {
    std::vector<double> result(map.size());
    for (int y = 0; y < grid.height; ++y)
        laplacian_row(map, y, 0, grid.width, grid, stencil, edges, result.data() + size_t(y) * size_t(grid.width));
    return result;
}

void laplacian_row(const std::vector<double>& map, int y, int first, int last, const Grid& grid, int stencil, int edges,
                   double* L) {
    const auto rows = simd::neighbours<double>(y, grid.width, grid.height, stencil, edges,
                                               [&](int row) { return map.data() + size_t(row) * size_t(grid.width); });
    simd::best().in_f64.laplacian(rows, first, last, L);
    if (!grid.spacing) return;
    const double area = *grid.spacing * *grid.spacing;
    for (int x = 0; x < last - first; ++x) L[x] /= area;
}

double laplacian_at(const std::vector<double>& map, Cell c, const Grid& grid, int stencil, int edges) {
    double L = 0;
    laplacian_row(map, c.y, c.x, c.x + 1, grid, stencil, edges, &L);
    return L;
}

Grid without_spacing(Grid grid) {
    grid.spacing.reset();
    return grid;
}

void rest_curvature_row(const PreparedSkin& skin, int y, int first, int last, double* L) {
    scene::look();
    const Map& given = skin.description.surface.curvature;
    if (given.empty()) laplacian_row(skin.heights, y, first, last, skin.description.grid, skin.stencil, skin.edges, L);
    else std::copy_n(given.data() + skin.number_of({first, y}), last - first, L);
    for (int x = 0; x < last - first; ++x) L[x] *= skin.relief;
}

double rest_curvature_at(const PreparedSkin& skin, Cell cell) {
    double L = 0;
    rest_curvature_row(skin, cell.y, cell.x, cell.x + 1, &L);
    return L;
}

double greatest_rest_curvature(const PreparedSkin& skin) {
    std::vector<double> L(size_t(skin.width()));
    double greatest = 0;
    for (int y = 0; y < skin.height(); ++y) {
        rest_curvature_row(skin, y, 0, skin.width(), L.data());
        for (double v : L) greatest = std::max(greatest, std::abs(v));
    }
    return greatest;
}

} // namespace dermis::model
