// SPDX-License-Identifier: MIT
#pragma once

#include "dermis/scene.hpp"

namespace dermis {

// The maps that a scene is made of, width*height each: the surface S, m; its curvature L(S), 1/m; and the pressure, Pa,
// with the intensity and without the envelope.
struct SceneMaps {
    Map surface, rest_curvature, pressure;
};
SceneMaps maps(const Scene&);

} // namespace dermis
