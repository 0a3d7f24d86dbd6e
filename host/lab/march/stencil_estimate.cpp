// SPDX-License-Identifier: MIT
#include "host/lab/march/stepper.hpp"

#include "host/core/model/laplacian.hpp"
#include "host/core/simd/isa.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::model {
namespace {

// Rows of the curvature of the skin under the strain shape*scale, in units without spacing.
struct CurvatureRows {
    const PreparedSkin& skin;
    const std::vector<double>& shape;
    double bend;
    Grid unit;
    std::vector<double> L;

    void compute(int y, int stencil, int edges, std::vector<double>& rest, std::vector<double>& C) {
        const int width = skin.width();
        if (skin.description.surface.curvature.empty()) {
            laplacian_row(skin.heights, y, 0, width, unit, stencil, edges, rest.data());
            for (double& v : rest) v *= skin.relief;
        } else { // of no stencil of this grid
            rest_curvature_row(skin, y, 0, width, rest.data());
            for (double& v : rest) v *= skin.spacing() * skin.spacing();
        }
        laplacian_row(shape, y, 0, width, unit, stencil, edges, L.data());
        for (int x = 0; x < width; ++x) C[size_t(x)] = rest[size_t(x)] - bend * L[size_t(x)];
    }
};

double largest_in(const std::vector<double>& values) { return *std::ranges::max_element(values); }

} // namespace

StencilEstimate stencil_estimate(const PreparedSkin& skin, const std::vector<double>& shape, double scale) {
    const size_t width = size_t(skin.width());
    const int edges = skin.edges == EDGES_PERIODIC ? EDGES_PERIODIC : EDGES_MIRROR;
    const bool five_is_own = skin.stencil == STENCIL_FIVE_POINT; // never with the published edges
    CurvatureRows rows{.skin = skin,
                       .shape = shape,
                       .bend = skin.constants.thickness * scale,
                       .unit = without_spacing(skin.description.grid),
                       .L = std::vector<double>(width)};
    std::vector<double> C5(width), C4(width), C(width), R(width);
    std::vector<double> differ(width), bent(width), curved(width); // column maxima
    std::vector<double> kinks(width + 1);                          // the first `count` are candidates
    size_t count = 0;
    double largest = 0; // greatest |C5| so far
    for (int y = 0; y < skin.height(); ++y) {
        rows.compute(y, STENCIL_FOURTH_ORDER, edges, R, C4);
        rows.compute(y, STENCIL_FIVE_POINT, edges, R, C5);
        if (!five_is_own) rows.compute(y, skin.stencil, skin.edges, R, C);
        if (!simd::best().compare(C5.data(), C4.data(), five_is_own ? C5.data() : C.data(), R.data(), int(width),
                                  differ.data(), bent.data(), curved.data()))
            continue;
        if (kinks.size() < count + width + 1) kinks.resize(2 * kinks.size() + width);
        for (size_t x = 0; x < width; ++x) { // branch-free
            const double differs = std::abs(C5[x] - C4[x]);
            kinks[count] = differs;
            count += (differs > std::abs(C5[x]) / 2) & (differs > 1e-3 * largest);
        }
        if (y % 16 == 0) largest = largest_in(bent);
    }
    largest = largest_in(bent);
    const double area = skin.spacing() * skin.spacing();
    StencilEstimate e;
    e.greatest = largest_in(differ) / area;
    e.curvature = largest_in(curved) / area;
    // A difference that is small against the largest curvature marks an inflection, not a kink.
    e.kinks = std::count_if(kinks.begin(), kinks.begin() + std::ptrdiff_t(count),
                            [=](double differs) { return differs > 1e-3 * largest; });
    return e;
}

} // namespace dermis::model
