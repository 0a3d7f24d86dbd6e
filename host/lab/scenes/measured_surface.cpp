// SPDX-License-Identifier: MIT
// Surfaces that are measured: their heights and curvature in the cells of a grid, and the period of their ridges.
#include "host/core/base/refusal.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/spline.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#define kissfft dermis_kissfft // a host may have another version
#include <kissfft/kissfft.hh>

namespace dermis::scene {
namespace {

// Reads a map in the middle of each cell of a grid. cell: numbers of the map from cell to cell.
std::vector<double> sampled(std::vector<double> map, int width, int height, const Grid& grid, double cell) {
    to_spline(map, width, height, Border::mirrored);
    const auto taps = [&](int cells) {
        std::vector<SplineTaps> all;
        for (int i = 0; i < cells; ++i) all.push_back(spline_taps((i + 0.5) * cell - 0.5));
        return all;
    };
    const std::vector<SplineTaps> along = taps(grid.width), down = taps(grid.height);
    std::vector<double> values(down.size() * along.size()), row(static_cast<size_t>(width));
    for (size_t y = 0; y < down.size(); ++y) {
        std::ranges::fill(row, 0);
        for (int j = 0; j < 4; ++j) {
            const double* line = map.data() + index_beyond(down[y].first + j, height, Border::mirrored) * size_t(width);
            for (size_t x = 0; x < row.size(); ++x) row[x] += down[y].weights[j] * line[x];
        }
        for (size_t x = 0; x < along.size(); ++x)
            for (int i = 0; i < 4; ++i)
                values[y * along.size() + x] +=
                    along[x].weights[i] * row[index_beyond(along[x].first + i, width, Border::mirrored)];
    }
    return values;
}

// A square of the map in its middle, of n x n numbers without their mean, which fades out to its border.
std::vector<std::complex<double>> faded(const FileMap& map, size_t n) {
    const size_t left = (size_t(map.width) - n) / 2, top = (size_t(map.height) - n) / 2;
    std::vector<std::complex<double>> square(n * n);
    double sum = 0;
    for (size_t y = 0; y < n; ++y)
        for (size_t x = 0; x < n; ++x) {
            square[y * n + x] = map.values[(top + y) * size_t(map.width) + left + x];
            sum += square[y * n + x].real();
        }
    const auto fade = [n](size_t i) { return 1 - std::cos(2 * std::numbers::pi * (double(i) + 0.5) / double(n)); };
    for (size_t y = 0; y < n; ++y)
        for (size_t x = 0; x < n; ++x)
            square[y * n + x] = (square[y * n + x] - sum / double(n * n)) * fade(x) * fade(y);
    return square;
}

// The mean power of all waves with as many periods in the square, rounded, from 0 to n/2.
std::vector<double> radial_power(std::vector<std::complex<double>> square, size_t n) {
    kissfft<double> transform(n, false);
    std::vector<std::complex<double>> line(n), turned(n);
    for (size_t y = 0; y < n; ++y) {
        transform.transform(square.data() + y * n, turned.data());
        std::ranges::copy(turned, square.begin() + long(y * n));
    }
    std::vector<double> power(n / 2 + 1), count(power);
    for (size_t x = 0; x < n; ++x) {
        for (size_t y = 0; y < n; ++y) line[y] = square[y * n + x];
        transform.transform(line.data(), turned.data());
        for (size_t y = 0; y < n; ++y) {
            const size_t ring = size_t(std::lround(std::hypot(std::min(x, n - x), std::min(y, n - y))));
            if (ring < power.size()) power[ring] += std::norm(turned[y]), ++count[ring];
        }
    }
    for (size_t k = 0; k < power.size(); ++k) power[k] /= std::max(1.0, count[k]);
    return power;
}

} // namespace

MeasuredSurface measured_surface(const FileMap& map, double spacing, const Grid& grid) {
    const double cell = *grid.spacing / spacing;
    const auto covers = [cell](int numbers, int cells) { return numbers >= (1 - 1e-9) * cells * cell; };
    if (!covers(map.width, grid.width) || !covers(map.height, grid.height))
        refuse("surface.spacing", shortest(spacing),
               "a spacing with which the file covers the grid: it has " + std::to_string(map.width) + " x " +
                   std::to_string(map.height) + " numbers, the grid " + std::to_string(grid.width) + " x " +
                   std::to_string(grid.height) + " cells of " + shortest(*grid.spacing) + " m");
    const Grid own{.width = map.width, .height = map.height, .spacing = spacing};
    std::vector<double> curvature = model::laplacian(map.values.values(), own, STENCIL_FOURTH_ORDER, EDGES_MIRROR);
    return {.heights = sampled(map.values.values(), map.width, map.height, grid, cell),
            .curvature = sampled(std::move(curvature), map.width, map.height, grid, cell)};
}

std::optional<double> ridge_period_of(const FileMap& map) {
    constexpr size_t most = 512, fewest = 32; // numbers along a side of the square
    constexpr double prominent = 8;           // times the mean of the powers of half and of twice as many periods
    const size_t n = std::min({most, size_t(map.width), size_t(map.height)}) / 2 * 2;
    if (n < fewest) return {};
    const std::vector<double> power = radial_power(faded(map, n), n);
    // Compares the power at k periods with the powers at half and at twice as many. The ratio is 1 where the power
    // falls as k^-n, as it does on a rough surface.
    const auto prominence = [&](size_t k) {
        return power[k] / std::sqrt(power[k / 2] * power[std::min(2 * k, n / 2)]);
    };
    size_t peak = 0;
    for (size_t k = 4; k < n / 2; ++k)
        if (power[k] > power[k - 1] && power[k] >= power[k + 1] && prominence(k) > prominent &&
            (peak == 0 || power[k] > power[peak]))
            peak = k;
    if (peak == 0) return {};
    const double low = std::log(power[peak - 1]), high = std::log(power[peak + 1]), top = std::log(power[peak]);
    const double off = low + high < 2 * top ? (high - low) / (2 * (2 * top - low - high)) : 0; // of a parabola
    return double(n) / (double(peak) + off);
}

} // namespace dermis::scene
