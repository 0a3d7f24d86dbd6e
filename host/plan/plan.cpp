// SPDX-License-Identifier: MIT
#include "host/plan/plan.hpp"
#include "host/plan/float_environment.hpp"

#include "host/scene/scene.hpp"

#include <algorithm>
#include <cmath>

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

// In double: of the surface once, so that only L(eps) is left to a kernel.
std::vector<double> laplacian(const std::vector<double>& map, const Grid& grid, int stencil, int edges) {
    const double spacing = grid.spacing.value_or(1);
    f64::Heights heights{map.data(), grid.width};
    std::vector<double> result(map.size());
    for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) {
            const double centre = heights.strain_at(x, y);
            result[size_t(y) * grid.width + x] =
                f64::add(heights.laplacian_along_x(x, y, centre, grid.width, stencil, edges),
                         heights.laplacian_along_y(x, y, centre, grid.height, stencil, edges)) /
                (spacing * spacing);
        }
    return result;
}

SceneMaps maps_of(const Scene& validated) {
    SceneMaps m;
    m.surface = scene::surface_map(validated);
    m.rest_curvature = laplacian(m.surface, validated.grid, int(*validated.stencil), int(*validated.edges));
    m.pressure = scene::pressure_map(validated);
    return m;
}

} // namespace

SceneMaps maps(const Scene& scene) {
    const DefaultFloats guard;
    return maps_of(scene::validated(scene));
}

namespace plan {

namespace {

// Each step rounds by 2^-24 and forgets e^-z of what was before; the plain integral forgets nothing.
Precision choose(const Scene& s, long long steps) {
    const double z = s.time.step * s.material.modulus / s.material.viscosity, N = double(steps);
    const double strain = std::min(N, 1 / -std::expm1(-z)),
                 sum = std::min(N, s.receptors.sa2_adaptation.value_or(INFINITY) / s.time.step);
    return 0x1p-24 * (strain + sum) > 1e-4 ? Precision::f32_compensated : Precision::f32;
}

} // namespace

StencilEstimate stencil_estimate(const Plan& plan, const std::vector<double>& strain) {
    const Scene& s = plan.scene;
    std::vector<double> deformed = plan.maps.surface;
    for (size_t i = 0; i < deformed.size(); ++i) deformed[i] -= *s.material.thickness * strain[i];
    const int edges = *s.edges == Edges::periodic ? EDGES_PERIODIC : EDGES_MIRROR;
    const std::vector<double> second = laplacian(deformed, s.grid, STENCIL_FIVE_POINT, edges);
    const std::vector<double> fourth = laplacian(deformed, s.grid, STENCIL_FOURTH_ORDER, edges);
    double largest = 0;
    for (double C : second) largest = std::max(largest, std::abs(C));
    StencilEstimate e;
    for (size_t i = 0; i < second.size(); ++i) {
        const double differs = std::abs(second[i] - fourth[i]);
        e.greatest = std::max(e.greatest, differs);
        e.kinks += differs > std::abs(second[i]) / 2 && differs > 1e-3 * largest; // below: an inflection, not a kink
    }
    return e;
}

Plan make_plan(const Scene& scene, std::optional<Precision> precision) {
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
    p.precision = precision.value_or(choose(s, p.outputs));
    p.compensated = p.precision == Precision::f32_compensated;
    for (const FieldRequest& f : s.output.fields) p.field_times.push_back(scene::Waveform::snapped(f.at, s.time.step));
    std::sort(p.field_times.begin(), p.field_times.end());
    p.field_times.erase(std::unique(p.field_times.begin(), p.field_times.end()), p.field_times.end());
    return p;
}

} // namespace plan
} // namespace dermis
