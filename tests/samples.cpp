// SPDX-License-Identifier: MIT
#include "tests/samples.hpp"

namespace test {

Scene small_scene(int width, int height) {
    Scene s;
    s.grid = {width, height, {}};
    s.surface.kind = Surface::Kind::wave;
    s.time = {0.05, 0.4};
    s.output.probes = {{width / 2, height / 2}, {width - 1, 0}};
    return s;
}

SkinDescription ridged(int width, int height) {
    SkinDescription d = small_scene(width, height);
    d.material.modulus = 1.3;
    d.material.viscosity = 0.7;
    return d;
}

SkinDescription finger(int width, int height, double spacing) {
    SkinDescription d = fingertip();
    d.grid = {width, height, spacing};
    return d;
}

Scene flat_finger(int cells, double spacing) {
    Scene s{fingertip()};
    s.grid = {cells, cells, spacing};
    s.surface = {.kind = Surface::Kind::flat, .relief = *s.surface.relief};
    s.load.control = Control::depth;
    s.output.traces = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1};
    s.output.probes = {{cells / 2, cells / 2}};
    return s;
}

Scene flat_strip(double step, double duration) {
    Scene s;
    s.grid = {50, 8, 1e-4};
    s.surface = {.kind = Surface::Kind::flat, .relief = 1e-6};
    s.material = {.modulus = 2e4, .viscosity = 2e2, .thickness = 1e-3, .curvature_length = 0};
    s.load = {.kind = Load::Kind::map, .intensity = 1e3, .map = std::vector<double>(50 * 8, 1)};
    s.time = {step, duration};
    s.output.traces = {Quantity::strain};
    s.output.probes = {{7, 4}};
    return s;
}

SkinDescription with_sites(SkinDescription d, int count) {
    for (int i = 0; i < count; ++i)
        d.sites.push_back({all_responses[i % 4], {i * 13 % d.grid.width, i * 7 % d.grid.height}});
    return d;
}

SkinDescription with_materials(SkinDescription d) {
    std::vector<double> moduli;
    for (int i = 0; i < d.grid.width * d.grid.height; ++i) moduli.push_back(1 + 0.1 * (i % 7));
    d.material.modulus_map = moduli;
    return d;
}

SkinDescription with_chain(SkinDescription d) {
    d.material.elements = {{3, 0.1}, {2, 0.9, d.material.modulus_map}, {1, 7}};
    d.material.modulus_map = {};
    d.material.modulus = d.material.viscosity = {};
    d.material.spring = 5;
    d.material.dashpot = 40;
    return d;
}

std::vector<float> frame(const SkinDescription& d, int n) {
    std::vector<float> map(size_t(d.grid.width) * size_t(d.grid.height));
    for (size_t i = 0; i < map.size(); ++i) map[i] = float(std::sin(0.37 * double(i) + n) + 0.2 * n);
    return map;
}

std::vector<float> frames_of(const SkinDescription& d, int n, size_t pads) {
    std::vector<float> all;
    for (size_t pad = 0; pad < pads; ++pad) {
        const std::vector<float> one = frame(d, n + int(pad));
        all.insert(all.end(), one.begin(), one.end());
    }
    return all;
}

std::vector<float> answers(const Skin& skin, std::span<const Quantity> what) {
    std::vector<float> all;
    for (Quantity q : what) {
        const Skin::Response r = skin.response(q);
        all.insert(all.end(), r.begin(), r.end());
    }
    return all;
}

std::vector<Spike> spikes_of(const Skin& skin) {
    const Skin::Spikes s = skin.spikes();
    return {s.begin(), s.end()};
}

} // namespace test
