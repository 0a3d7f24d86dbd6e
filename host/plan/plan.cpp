// SPDX-License-Identifier: MIT
#include "host/plan/plan.hpp"
#include "host/plan/float_environment.hpp"

#include "host/scene/scene.hpp"

#include <algorithm>

namespace dermis {
namespace f64 {
namespace {

struct Heights {
    const double* map;
    int width;
    double strain_at(int x, int y) const { return map[size_t(y) * width + x]; }
#include "kernels/gather.h"
};

} // namespace
} // namespace f64

namespace {

// L(S), once and in double: what is left to a kernel is L(eps).
std::vector<double> laplacian(const std::vector<double>& map, const Scene& s) {
    const int width = s.grid.width, height = s.grid.height, stencil = int(*s.stencil), edges = int(*s.edges);
    const double spacing = s.grid.spacing.value_or(1);
    f64::Heights heights{map.data(), width};
    std::vector<double> result(map.size());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double centre = heights.strain_at(x, y);
            result[size_t(y) * width + x] = f64::add(heights.laplacian_along_x(x, y, centre, width, stencil, edges),
                                                     heights.laplacian_along_y(x, y, centre, height, stencil, edges)) /
                                            (spacing * spacing);
        }
    return result;
}

SceneMaps maps_of(const Scene& validated) {
    SceneMaps m;
    m.surface = scene::surface_map(validated);
    m.rest_curvature = laplacian(m.surface, validated);
    m.pressure = scene::pressure_map(validated);
    return m;
}

} // namespace

SceneMaps maps(const Scene& scene) {
    const DefaultFloats guard;
    return maps_of(scene::validated(scene));
}

namespace plan {

Plan make_plan(const Scene& scene) {
    Plan p;
    p.scene = scene::validated(scene);
    const Scene& s = p.scene;
    p.stencil = int(*s.stencil);
    p.edges = int(*s.edges);
    p.maps = maps_of(s);
    p.pitch = (s.grid.width + PITCH_CELLS - 1) / PITCH_CELLS * PITCH_CELLS;
    p.tiles = (s.grid.width + TILE_CELLS - 1) / TILE_CELLS;
    const double spacing = s.grid.spacing.value_or(1);
    p.constants.bend = *s.material.thickness / (spacing * spacing);
    p.constants.curvature_length = *s.material.curvature_length;
    p.constants.gain_plus = s.receptors.fa2_gains[0];
    p.constants.gain_minus = s.receptors.fa2_gains[1];
    p.constants.thickness = *s.material.thickness;
    p.constants.width = s.grid.width;
    p.constants.height = s.grid.height;
    p.constants.pitch = p.pitch;
    p.outputs = scene::outputs(s.time);
    for (const FieldRequest& f : s.output.fields) p.field_times.push_back(scene::Waveform::snapped(f.at, s.time.step));
    std::sort(p.field_times.begin(), p.field_times.end());
    p.field_times.erase(std::unique(p.field_times.begin(), p.field_times.end()), p.field_times.end());
    return p;
}

} // namespace plan
} // namespace dermis
