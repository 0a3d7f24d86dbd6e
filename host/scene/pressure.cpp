// SPDX-License-Identifier: MIT
// Pressure maps: the published study's three, or a map.
#include "host/scene/scene.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::scene {
namespace {

// Smooths along one axis of stride `stride` with a Gaussian, reflecting at the ends (d c b a | a b c d | d c b a).
void smooth(std::vector<double>& map, const std::vector<double>& kernel, int n, size_t stride, int lines, size_t line) {
    const int radius = int(kernel.size()) - 1;
    std::vector<double> in(n);
    for (int l = 0; l < lines; ++l) {
        double* first = map.data() + l * line;
        for (int i = 0; i < n; ++i) in[i] = first[i * stride];
        const auto at = [&](int i) {
            i = ((i % (2 * n)) + 2 * n) % (2 * n);
            return in[i < n ? i : 2 * n - 1 - i];
        };
        for (int i = 0; i < n; ++i) {
            double sum = kernel[0] * in[i];
            for (int k = 1; k <= radius; ++k) sum += kernel[k] * (at(i - k) + at(i + k));
            first[i * stride] = sum;
        }
    }
}

// A unit impulse smoothed by a Gaussian, cut at four standard deviations.
std::vector<double> point_map(int width, int height, Cell center, double sigma) {
    const int radius = int(4 * sigma + 0.5);
    std::vector<double> kernel(radius + 1);
    double total = 0;
    for (int k = 0; k <= radius; ++k) total += (k ? 2 : 1) * (kernel[k] = std::exp(-0.5 * k * k / (sigma * sigma)));
    for (double& w : kernel) w /= total;
    std::vector<double> map(size_t(width) * height, 0);
    map[size_t(center.y) * width + center.x] = 1;
    smooth(map, kernel, height, width, width, 1);
    smooth(map, kernel, width, 1, height, width);
    return map;
}

} // namespace

std::vector<double> pressure_map(const Scene& scene) {
    const Load& l = scene.load;
    const int width = scene.grid.width, height = scene.grid.height;
    const Cell center = *l.center;
    const double radius = *l.radius;
    std::vector<double> map;
    if (l.kind == Load::Kind::map) map = l.map;
    else if (l.kind == Load::Kind::point) map = point_map(width, height, center, radius / 4);
    else {
        map.resize(size_t(width) * height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double distance =
                    l.kind == Load::Kind::circular ? std::hypot(x - center.x, y - center.y) : std::abs(y - center.y);
                map[size_t(y) * width + x] = std::max(0.0, 1 - distance / radius);
            }
    }
    for (double& v : map) v *= l.intensity;
    return map;
}

} // namespace dermis::scene
