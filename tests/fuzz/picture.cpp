// SPDX-License-Identifier: MIT
// A map of any size: a PNG, or a .npy file. Of a small one also the surface that it is.
#include "host/lab/scenes/scene.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>

using namespace dermis;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    fuzz::taken([&] {
        const scene::FileMap map = scene::read_map(fuzz::file_of(data, size), 0, 0, "surface.path");
        fuzz::need(map.values.size() == size_t(map.width) * size_t(map.height), "another number of numbers");
        for (double x : map.values) fuzz::need(std::isfinite(x) && (!map.picture || (x >= 0 && x <= 1)), "no height");
        if (map.values.size() > 4096) return;
        if (const auto period = scene::ridge_period_of(map)) fuzz::need(*period >= 1, "a period below a number");
        scene::measured_surface(map, 1, {.width = map.width, .height = map.height, .spacing = 1});
    });
    return 0;
}
