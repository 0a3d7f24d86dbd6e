// SPDX-License-Identifier: MIT
// Pressure maps: the three shapes of the published study, a given map, a punch, or the first frame of a sequence.
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/spline.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::scene {
namespace {

// A unit impulse at cell `center` of n, smoothed.
std::vector<double> smoothed_impulse(int n, int center, double sigma) {
    std::vector<double> line(size_t(n), 0.0);
    line[size_t(center)] = 1;
    return smoothed(line, sigma, 4);
}

std::vector<double> point_map(int width, int height, Cell center, double sigma) {
    const std::vector<double> row = smoothed_impulse(width, center.x, sigma),
                              column = smoothed_impulse(height, center.y, sigma);
    std::vector<double> map;
    map.reserve(size_t(width) * height);
    for (double y : column)
        for (double x : row) map.push_back(y * x);
    return map;
}

} // namespace

std::vector<double> smoothed(const std::vector<double>& line, double sigma, double reach) {
    const int n = int(line.size()), radius = int(reach * sigma + 0.5);
    std::vector<double> weights;
    double total = 0;
    for (int k = -radius; k <= radius; ++k) total += weights.emplace_back(std::exp(-0.5 * k * k / (sigma * sigma)));
    std::vector<double> wide; // the line with `radius` more cells at each end
    for (int k = -radius; k < n + radius; ++k) wide.push_back(line[index_beyond(k, n, Border::mirrored)]);
    std::vector<double> smooth(line.size(), 0.0);
    for (size_t x = 0; x < smooth.size(); ++x) {
        for (size_t k = 0; k < weights.size(); ++k) smooth[x] += weights[k] * wide[x + k];
        smooth[x] /= total;
    }
    return smooth;
}

Map shape_of(const Scene& s) {
    const Load& l = s.load;
    const int width = s.grid.width, height = s.grid.height;
    const Cell center = *l.center;
    const double radius = *l.radius;
    if (l.kind == Load::Kind::map) return l.map;
    if (l.kind == Load::Kind::punch) return punch_map(s);
    if (l.kind == Load::Kind::point) return point_map(width, height, center, radius / 4);
    std::vector<double> map(size_t(width) * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double distance =
                l.kind == Load::Kind::circular ? std::hypot(x - center.x, y - center.y) : std::abs(y - center.y);
            map[size_t(y) * width + x] = std::max(0.0, 1 - distance / radius);
        }
    return map;
}

Map pressure_map(const ValidatedScene& validated) {
    Map map;
    if (validated.frames) validated.frames->read(0, map.edit());
    else {
        map = validated.scene.load.grating ? grating_at_rest(validated.scene) : shape_of(validated.scene);
        if (presses_cells(validated.scene.load)) to_strain(validated.scene, map.edit());
    }
    const double intensity = validated.scene.load.intensity;
    if (intensity != 1)
        for (double& v : map.edit()) v = product(v, intensity);
    return map;
}

} // namespace dermis::scene
