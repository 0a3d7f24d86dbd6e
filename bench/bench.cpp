// SPDX-License-Identifier: MIT
// What doing less gains: seconds of one run of this program, medians, as Markdown.
#include "dermis/dermis.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>

namespace {

using namespace dermis;

double seconds(int runs, const std::function<void()>& work) {
    std::vector<double> times;
    work(); // warms up
    for (int i = 0; i < runs; ++i) {
        const auto start = std::chrono::steady_clock::now();
        work();
        times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

void row(const char* what, double time, const char* against, double other) {
    std::printf("| %s | %.4g | %s | %.4g | %.0f |\n", what, time, against, other, other / time);
}

// The scene with its maps made beforehand.
Scene with_maps(Scene s) {
    const SceneMaps m = maps(s);
    s.surface = {Surface::Kind::map, {}, {}, {}, s.grid.spacing ? std::optional(1.0) : std::nullopt, m.surface};
    s.load.kind = Load::Kind::map;
    s.load.map = m.pressure;
    return s;
}

std::vector<Scene> nine_scenes() {
    std::vector<Scene> scenes;
    for (Surface::Kind surface : {Surface::Kind::flat, Surface::Kind::wave, Surface::Kind::spiral})
        for (Load::Kind load : {Load::Kind::circular, Load::Kind::point, Load::Kind::linear}) {
            Scene s;
            s.surface.kind = surface;
            s.load.kind = load;
            s.output.probes = {{75, 75}, {85, 85}, {60, 80}, {37, 37}, {112, 112}};
            scenes.push_back(with_maps(s));
        }
    return scenes;
}

} // namespace

// Argument: seconds of one scene in NumPy (bench/numpy_study.py).
int main(int argc, char** argv) {
    const Device cpu = Device::cpu();
    std::printf("| what | s | against | s | times |\n|---|---|---|---|---|\n");
    const std::vector<Scene> nine = nine_scenes();
    const auto all_of = [&](std::optional<Model> model) {
        return seconds(11, [&] {
            for (Scene s : nine) {
                s.model = model;
                run(s, cpu);
            }
        });
    };
    const double moments = all_of(std::nullopt);
    if (argc > 1)
        row("the study's nine scenes, moments", moments, "every cell stepped in NumPy float64", 9 * std::stod(argv[1]));
    row("the study's nine scenes, moments", moments, "every cell marched in f32", all_of(Model::march));

    Scene large;
    large.grid = {2048, 2048, {}};
    large.surface.kind = Surface::Kind::wave;
    large = with_maps(large);
    std::vector<Material> materials;
    for (int i = 0; i < 100; ++i) materials.push_back({1 + 0.01 * i, 1, {}, {}});
    const double hundred = seconds(5, [&] { run(large, materials, cpu); });
    row("one of 100 materials on 2048 x 2048", hundred / 100, "one material alone",
        seconds(5, [&] { run(large, cpu); }));

    Scene hand; // 4 materials: it has to step
    hand.grid = {4096, 4096, 50e-6};
    hand.surface.relief = 5e-5;
    hand.material = {20e3, 1e3, 1e-3, 1e-5};
    hand.load.intensity = 1e4;
    hand = with_maps(hand);
    for (int i = 0; i < 4096 * 4096; ++i) hand.material.modulus_map.edit().push_back(20e3 * (1 + (i / 512) % 4));
    hand.time = {0.01, 0.5};
    Scene field = hand;
    hand.sites = population(hand.grid);
    hand.output.traces.clear();
    double sites = 0, whole = 0;
    seconds(3, [&] { sites = run(hand, cpu).seconds; });
    field.precision = Precision::f32;
    seconds(1, [&] { whole = run(field, cpu).seconds; });
    row("250 receptors per cm2, 4096 x 4096, 50 steps, sites", sites, "the whole field in f32", whole);
}
