// SPDX-License-Identifier: MIT
#include "host/plan/plan.hpp"
#include "host/simd/isa.hpp"
#include "host/plan/float_environment.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace dermis {
namespace plan {
namespace {

simd::Lines<double> lines_of(const std::vector<double>& map, int y, const Grid& grid, int stencil, int edges) {
    return simd::lines<double>(y, grid.width, grid.height, stencil, edges,
                                [&](int row) { return map.data() + size_t(row) * grid.width; });
}

} // namespace

std::vector<double> laplacian(const std::vector<double>& map, const Grid& grid, int stencil, int edges) {
    std::vector<double> result(map.size());
    for (int y = 0; y < grid.height; ++y)
        laplacian_row(map, y, 0, grid.width, grid, stencil, edges, result.data() + size_t(y) * grid.width);
    return result;
}

void laplacian_row(const std::vector<double>& map, int y, int first, int last, const Grid& grid, int stencil, int edges,
                   double* L) {
    simd::best().f64.laplacian(lines_of(map, y, grid, stencil, edges), first, last, L);
    if (!grid.spacing) return;
    const double area = *grid.spacing * *grid.spacing;
    for (int x = 0; x < last - first; ++x) L[x] /= area;
}

double laplacian_at(const std::vector<double>& map, Cell c, const Grid& grid, int stencil, int edges) {
    double L = 0;
    laplacian_row(map, c.y, c.x, c.x + 1, grid, stencil, edges, &L);
    return L;
}

} // namespace plan

namespace {

SceneMaps maps_of(const Scene& validated, bool frames) {
    SceneMaps m;
    m.surface = scene::surface_map(validated);
    if (!frames) m.pressure = scene::pressure_map(validated);
    return m;
}

} // namespace

SceneMaps maps(const Scene& scene) {
    const DefaultFloats guard;
    const Scene s = scene::validated(scene);
    SceneMaps m = maps_of(s, false);
    m.rest_curvature = plan::laplacian(m.surface, s.grid, int(*s.stencil), int(*s.edges));
    return m;
}

namespace plan {

namespace {

struct PairHash {
    size_t operator()(const std::pair<double, double>& p) const {
        const std::hash<double> hash;
        return hash(p.first) * 31 + hash(p.second);
    }
};

// Each material once, in the order of its first cell, and which one every cell is.
void find_materials(Plan& p) {
    const Scene& s = p.scene;
    const double adaptation = s.receptors.sa2_adaptation.value_or(INFINITY);
    const bool mean = *s.receptors.fa2 == Fa2::step_mean;
    if (s.material.modulus_map.empty() && s.material.viscosity_map.empty()) {
        p.media = {{s.material.modulus, s.material.viscosity, adaptation, mean}};
        return;
    }
    p.media.clear();
    std::unordered_map<std::pair<double, double>, int, PairHash> known;
    p.material.assign(size_t(p.pitch) * s.grid.height, 0);
    for (size_t i = 0, y = 0; y < size_t(s.grid.height); ++y)
        for (int x = 0; x < s.grid.width; ++x, ++i) {
            const double E = scene::modulus_at(s.material, i), eta = scene::viscosity_at(s.material, i);
            const auto [material, fresh] = known.try_emplace({E, eta}, int(p.media.size()));
            if (fresh) p.media.push_back({E, eta, adaptation, mean});
            p.material[y * p.pitch + x] = material->second;
        }
    if (p.media.size() == 1) p.material.clear();
}

// Widens what is pressed by a map.
void add_pressed(Plan& p, const std::vector<double>& map) {
    const int width = p.scene.grid.width, height = p.scene.grid.height;
    int first = p.pressed.first_tile * TILE_CELLS, last = p.pressed.last_tile * TILE_CELLS; // columns
    for (int y = 0; y < height; ++y) {
        const double* row = map.data() + size_t(y) * width;
        bool none = true; // without a way out, for the compiler's vectors
        for (int x = 0; x < width; ++x) none &= row[x] == 0;
        if (none) continue;
        p.pressed.first_row = std::min(p.pressed.first_row, y);
        p.pressed.last_row = std::max(p.pressed.last_row, y + 1);
        first = int(std::find_if(row, row + std::min(first, width), [](double v) { return v != 0; }) - row);
        for (int x = width; x > last; --x)
            if (row[x - 1] != 0) last = x;
    }
    p.pressed.first_tile = first / TILE_CELLS;
    p.pressed.last_tile = (last + TILE_CELLS - 1) / TILE_CELLS;
}

} // namespace

StencilEstimate stencil_estimate(const Plan& plan, const std::vector<double>& shape, double scale) {
    const Scene& s = plan.scene;
    const int width = s.grid.width, height = s.grid.height;
    const int edges = *s.edges == Edges::periodic ? EDGES_PERIODIC : EDGES_MIRROR;
    const bool five_is_own = plan.stencil == STENCIL_FIVE_POINT; // never with the published edges
    Grid unit = s.grid;
    unit.spacing.reset();
    const double bend = *s.material.thickness * scale;
    std::vector<double> C5(width), C4(width), C(width), R(width), L(width);
    std::vector<double> differ(width), bent(width), curved(width); // by columns
    std::vector<double> kinks(size_t(width) + 1);                  // the first ones count
    size_t count = 0;
    const auto curvature = [&](int y, int stencil, int edge, std::vector<double>& rest, std::vector<double>& C) {
        laplacian_row(plan.maps.surface, y, 0, width, unit, stencil, edge, rest.data());
        laplacian_row(shape, y, 0, width, unit, stencil, edge, L.data());
        for (int x = 0; x < width; ++x) C[x] = rest[x] - bend * L[x];
    };
    double largest = 0; // |C5| so far
    for (int y = 0; y < height; ++y) {
        curvature(y, STENCIL_FOURTH_ORDER, edges, R, C4);
        curvature(y, STENCIL_FIVE_POINT, edges, R, C5);
        if (!five_is_own) curvature(y, plan.stencil, plan.edges, R, C);
        if (!simd::best().compare(C5.data(), C4.data(), five_is_own ? C5.data() : C.data(), R.data(), width,
                                   differ.data(), bent.data(), curved.data()))
            continue;
        if (kinks.size() < count + size_t(width) + 1) kinks.resize(2 * kinks.size() + size_t(width));
        for (int x = 0; x < width; ++x) { // without branches
            const double differs = std::abs(C5[x] - C4[x]);
            kinks[count] = differs;
            count += (differs > std::abs(C5[x]) / 2) & (differs > 1e-3 * largest);
        }
        if (y % 16 == 0) largest = *std::max_element(bent.begin(), bent.end());
    }
    largest = *std::max_element(bent.begin(), bent.end());
    const double area = s.grid.spacing.value_or(1) * s.grid.spacing.value_or(1);
    StencilEstimate e;
    e.greatest = *std::max_element(differ.begin(), differ.end()) / area;
    e.curvature = *std::max_element(curved.begin(), curved.end()) / area;
    // small against the largest: an inflection, not a kink
    e.kinks = std::count_if(kinks.begin(), kinks.begin() + std::ptrdiff_t(count),
                            [=](double differs) { return differs > 1e-3 * largest; });
    return e;
}

std::string why_not_separable(const Plan& p) {
    const auto& gains = p.scene.receptors.fa2_gains;
    if (p.media.size() > 1) return "the material is not uniform";
    if (p.framed) return "the load is not one map times an envelope";
    if (gains[0] != -gains[1]) return "receptors.fa2_gains make FA2 depend on its sign";
    return "";
}

std::string why_not(const Plan& p, Model model) {
    const Output& o = p.scene.output;
    if (model == Model::march) return "";
    if (model == Model::sites) {
        if (p.scene.sites.empty()) return "there are no sites";
        return o.traces.empty() && o.fields.empty() ? "" : "traces or fields of all cells are asked for";
    }
    if (model == Model::moments && !o.fields.empty()) return "fields are asked for";
    return why_not_separable(p);
}

void set_material(Plan& p, const Material& material) {
    p.scene.material.modulus = material.modulus;
    p.scene.material.viscosity = material.viscosity;
    scene::check_material(p.scene);
    find_materials(p);
}

Plan make_plan(const Scene& scene, Precision precision) {
    Plan p = prepare(scene);
    p.precision = precision;
    p.compensated = precision == Precision::f32_compensated;
    p.wanted.fill(true);
    p.keeps_maps = p.derives = true;
    complete(p);
    return p;
}

void complete(Plan& p) { p.maps.rest_curvature = laplacian(p.maps.surface, p.scene.grid, p.stencil, p.edges); }

Plan prepare(const Scene& scene, bool frames) {
    Plan p;
    p.scene = scene::validated(scene);
    const Scene& s = p.scene;
    p.stencil = int(*s.stencil);
    p.edges = int(*s.edges);
    p.maps = maps_of(p.scene, frames);
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
    p.places = s.output.probes;
    for (const Site& site : s.sites) p.places.push_back(site.cell);
    for (int q = 0; q < REDUCED_MAPS; ++q) p.wanted[q] = scene::wants(s, Quantity(q));
    p.keeps_maps = !p.places.empty() || !s.output.fields.empty();
    for (const FieldRequest& f : s.output.fields)
        for (Quantity q : f.what) p.derives |= q >= Quantity::curvature;
    find_materials(p);
    p.pressed = {s.grid.height, 0, p.tiles, 0};
    if (frames) {
        p.framed = true;
        p.pressed = {0, s.grid.height, 0, p.tiles};
    } else if (s.load.kind != Load::Kind::sequence) {
        add_pressed(p, p.maps.pressure);
    } else {
        p.framed = true;
        p.frames = std::make_shared<scene::NpyFile>(s.load.path, s.grid.width, s.grid.height, true, "load.path");
        std::vector<double> frame;
        for (long long k = 0; k < p.frames->maps(); ++k) { // finite, before anything else
            p.frames->read(k, frame);
            add_pressed(p, frame);
            double peak = 0;
            for (double v : frame) peak = std::max(peak, std::abs(v));
            p.frame_peaks.push_back(peak * std::abs(s.load.intensity));
        }
    }
    if (p.pressed.last_row == 0) p.pressed = {0, 0, 0, 0};
    for (const FieldRequest& f : s.output.fields) p.field_times.push_back(scene::Waveform::snapped(f.at, s.time.step));
    std::sort(p.field_times.begin(), p.field_times.end());
    p.field_times.erase(std::unique(p.field_times.begin(), p.field_times.end()), p.field_times.end());
    return p;
}

} // namespace plan
} // namespace dermis
