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

double laplacian_at(const std::vector<double>& map, int x, int y, const Grid& grid, int stencil, int edges) {
    f64::Heights heights{map.data(), grid.width};
    const double centre = heights.strain_at(x, y), spacing = grid.spacing.value_or(1);
    return f64::add(heights.laplacian_along_x(x, y, centre, grid.width, stencil, edges),
                    heights.laplacian_along_y(x, y, centre, grid.height, stencil, edges)) /
           (spacing * spacing);
}

// L(S), once and in double: what is left to a kernel is L(eps).
std::vector<double> laplacian(const std::vector<double>& map, const Grid& grid, int stencil, int edges) {
    std::vector<double> result;
    result.reserve(map.size());
    for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) result.push_back(laplacian_at(map, x, y, grid, stencil, edges));
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
    StencilEstimate e;
    double largest = 0;
    std::vector<double> kinks;
    for (int y = 0; y < s.grid.height; ++y)
        for (int x = 0; x < s.grid.width; ++x) {
            const double C = laplacian_at(deformed, x, y, s.grid, STENCIL_FIVE_POINT, edges);
            const double differs = std::abs(C - laplacian_at(deformed, x, y, s.grid, STENCIL_FOURTH_ORDER, edges));
            largest = std::max(largest, std::abs(C));
            e.greatest = std::max(e.greatest, differs);
            if (differs > std::abs(C) / 2) kinks.push_back(differs);
        }
    // small against the largest: an inflection, not a kink
    e.kinks = std::count_if(kinks.begin(), kinks.end(), [=](double differs) { return differs > 1e-3 * largest; });
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
