// SPDX-License-Identifier: MIT
// The Laplacian of maps in double, the curvature of the skin at rest, and the estimated error of a stencil.
#pragma once

#include "host/core/base/pool.hpp"
#include "host/core/base/text.hpp"
#include "host/core/model/skin.hpp"

#include <algorithm>
#include <limits>

namespace dermis::model {

// The Laplacian of a map of width*height, in its unit per m^2, or per cell^2 without spacing. stencil, edges: as in
// kernels/layout.h.
std::vector<double> laplacian(const std::vector<double>& map, const Grid&, int stencil, int edges);
double laplacian_at(const std::vector<double>& map, Cell, const Grid&, int stencil, int edges);
// The same for columns first .. last - 1 of row y.
void laplacian_row(const std::vector<double>& map, int y, int first, int last, const Grid&, int stencil, int edges,
                   double* L);
Grid without_spacing(Grid);

// L(S), 1/m. The relief multiplies differences, so that heights far from 0 lose nothing. L: columns first .. last - 1
// of row y.
void rest_curvature_row(const PreparedSkin&, int y, int first, int last, double* L);
double rest_curvature_at(const PreparedSkin&, Cell);
double greatest_rest_curvature(const PreparedSkin&);

// A map in the precision of a backend, with rows padded to the pitch by zeros. row(y) points to row y in double. out:
// an earlier result, whose memory is used again. Throws Error::bad_input naming `parameter` if a value is too large.
template <class real, class RowOf>
std::vector<real> padded_rows(const PreparedSkin& skin, const char* parameter, RowOf row, std::vector<real> out = {}) {
    using Limits = std::numeric_limits<real>;
    const int width = skin.width(), height = skin.height();
    if (out.empty()) out = simd::map_of(skin.padded_cells(), real(0));
    const auto fits = [](double v) { return int(v <= double(Limits::max())) & int(v >= double(Limits::lowest())); };
    for (int y = 0; y < height; ++y) {
        const double* values = row(y);
        real* to = out.data() + size_t(y) * size_t(skin.pitch);
        int all = 1; // no early exit, so that the loop vectorises
        for (int x = 0; x < width; ++x) all &= fits(values[x]), to[x] = real(values[x]);
        if (all) continue;
        const auto x = std::find_if_not(values, values + width, fits) - values;
        throw Error(Error::Code::bad_input, parameter,
                    std::string(parameter) + " = " + shortest(values[x]) + " in cell [" + std::to_string(x) + ", " +
                        std::to_string(y) + "]; allowed: up to " + shortest(double(Limits::max())) +
                        " (f32: 3.4e38, f64: 1.8e308)");
    }
    return out;
}

template <class real>
std::vector<real> padded(const std::vector<double>& map, const PreparedSkin& skin, const char* parameter,
                         std::vector<real> out = {}) {
    const auto row = [&](int y) { return map.data() + size_t(y) * size_t(skin.width()); };
    return padded_rows<real>(skin, parameter, row, std::move(out));
}

// L(S) of every cell, pitch*height, 1/m.
template <class real> std::vector<real> padded_rest_curvature(const PreparedSkin& skin) {
    std::vector<double> L(size_t(skin.width()));
    return padded_rows<real>(skin, "surface.relief", [&](int y) {
        rest_curvature_row(skin, y, 0, skin.width(), L.data());
        return L.data();
    });
}

} // namespace dermis::model
