// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/base/float_environment.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/lab/schedule/timeline.hpp"

namespace dermis {

// The maps that a scene is made of, width*height each: the surface S, m; its curvature L(S), 1/m; and the pressure, Pa,
// with the intensity and without the envelope.
struct SceneMaps {
    Map surface, rest_curvature, pressure;
};

// The sum of the maps of all loads.
inline Map sum_of_maps(const Scene& scene) {
    scene::ValidatedScene one{scene, nullptr};
    one.scene.more_loads.clear();
    Map sum = scene::pressure_map(one);
    for (const Load& load : scene.more_loads) {
        one.scene.load = load;
        const Map map = scene::pressure_map(one);
        std::vector<double>& values = sum.edit();
        for (size_t i = 0; i < values.size(); ++i) values[i] += map[i];
    }
    return sum;
}

inline SceneMaps maps(const Scene& scene) {
    const DefaultFloats guard;
    const model::PreparedRun run = model::prepare_run(scene);
    std::vector<double> surface = run.skin.heights.values(), rest(surface.size());
    for (double& height : surface) height *= run.skin.relief;
    for (int y = 0; y < run.skin.height(); ++y)
        model::rest_curvature_row(run.skin, y, 0, run.skin.width(), rest.data() + run.skin.number_of({0, y}));
    Map pressure = run.schedule.pressure;
    if (run.schedule.framed) pressure = model::FrameFeed(run.schedule, run.skin.width()).frame(0);
    if (scene::is_sum(scene)) pressure = sum_of_maps(scene::validate(scene).scene);
    return {.surface = std::move(surface), .rest_curvature = std::move(rest), .pressure = pressure};
}

} // namespace dermis
