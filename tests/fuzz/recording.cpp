// SPDX-License-Identifier: MIT
// A recording of taxels, two in a row, as a CSV file.
#include "host/lab/scenes/scene.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>

using namespace dermis;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    Scene s;
    s.grid = {.width = 8, .height = 8, .spacing = {}};
    s.load.path = fuzz::file_of(data, size);
    s.load.taxels =
        Taxels{.spacing = 2, .columns = 2, .rows = 2, .skip = size % 2 ? 1 : 0, .unit = -0.5, .first_at_rest = true};
    fuzz::taken([&] {
        const auto frames = scene::taxel_frames(s);
        std::vector<double> map;
        for (long long i = 0; i < frames->maps(); ++i) {
            frames->read(i, map);
            fuzz::need(map.size() == 64, "another number of cells");
            for (double x : map) fuzz::need(!std::isnan(x), "a number that is none");
        }
    });
    return 0;
}
