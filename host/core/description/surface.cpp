// SPDX-License-Identifier: MIT
// Surfaces: the three of the published study, or a given map.
#include "host/core/base/pool.hpp"
#include "host/core/base/watch.hpp"
#include "host/core/description/description.hpp"
#include "host/core/description/noise.hpp"
#include "host/core/description/skin_keys.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace dermis::scene {
namespace {

// A surface with ridges, before its heights are scaled.
class Ridges {
  public:
    explicit Ridges(const SkinDescription& scene)
        : surface_(scene.surface), width_(scene.grid.width), height_(scene.grid.height) {
        for (int x = 0; x < width_; ++x) across_.push_back(double(x) / width_);
        if (*surface_.noise != 0) noise_.emplace(width_, *surface_.noise_length);
    }

    // Computes the heights of row y. heights: one per column, 0 before the call.
    void row(int y, double* heights) const {
        if (noise_) noise_->row(y, heights);
        const double noise = *surface_.noise;
        const double ridges = *surface_.ridges;
        if (surface_.kind == Surface::Kind::wave) {
            const double bend = 0.3 * std::sin(y / 30.0), turns = 2 * std::numbers::pi * ridges;
            for (int x = 0; x < width_; ++x)
                heights[x] = std::sin(turns * (across_[size_t(x)] + bend)) + noise * heights[x];
        } else {
            const double dy = y - height_ / 2; // The centre is a whole cell.
            for (int x = 0; x < width_; ++x) {
                const double dx = x - width_ / 2;
                heights[x] = std::sin(ridges * std::hypot(dx, dy) / width_ + std::atan2(dy, dx)) + noise * heights[x];
            }
        }
    }

  private:
    const Surface& surface_;
    const int width_, height_;
    std::vector<double> across_; // x/width
    std::optional<Noise> noise_; // none where its amplitude is 0
};

} // namespace

Map surface_heights(const SkinDescription& scene, int threads) {
    const Surface& s = scene.surface;
    const int width = scene.grid.width, height = scene.grid.height;
    if (s.kind == Surface::Kind::map) return s.map;
    const bool flat = s.kind == Surface::Kind::flat;
    std::vector<double> map = simd::map_of(size_t(width) * size_t(height), flat ? 0.5 : 0.0);
    if (flat) return map;
    const Ridges ridges(scene);
    simd::Pool pool(simd::useful_threads(map.size(), threads));
    std::vector<double> least(size_t(height), 0), greatest(least); // of each row
    pool.share(height, [&](int first, int last) {
        for (int y = first; y < last; ++y) {
            if (pool.failed()) return;
            look();
            double* row = map.data() + size_t(y) * size_t(width);
            ridges.row(y, row);
            const auto [low, high] = std::minmax_element(row, row + width);
            least[size_t(y)] = *low;
            greatest[size_t(y)] = *high;
        }
    });
    const double base = *std::min_element(least.begin(), least.end());
    const double range = *std::max_element(greatest.begin(), greatest.end()) - base;
    pool.share(height, [&](int first, int last) {
        const auto from = map.begin() + std::ptrdiff_t(first) * width, to = map.begin() + std::ptrdiff_t(last) * width;
        std::for_each(from, to, [=](double& v) { v = range > 0 ? (v - base) / range : 0.5; });
    });
    return map;
}

double cells_per_ridge(const SkinDescription& scene) {
    const Surface& s = scene.surface;
    const double turn = s.kind == Surface::Kind::spiral ? 2 * std::numbers::pi : 1;
    if (of_ridges.holds(s)) return std::abs(turn * scene.grid.width / *s.ridges);
    // A curvature that is given is not computed on the cells of the grid, so that their number does not matter.
    const bool measured = s.kind == Surface::Kind::map && s.ridge_period && s.curvature.empty();
    return measured ? *s.ridge_period / *scene.grid.spacing : std::numeric_limits<double>::infinity();
}

} // namespace dermis::scene
