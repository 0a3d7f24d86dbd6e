// SPDX-License-Identifier: MIT
// A map, or with an odd first byte a sequence of maps, of 3 x 2 cells: the rest is a .npy file.
#include "host/lab/scenes/scene.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cmath>

using namespace dermis;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (!size) return 0;
    fuzz::taken([&] {
        scene::NpyFile file(fuzz::file_of(data + 1, size - 1), 3, 2, data[0] & 1, "load.path");
        std::vector<double> map;
        for (long long i = 0; i < file.maps(); ++i) {
            file.read(i, map);
            fuzz::need(map.size() == 6, "another number of cells");
            for (double x : map) fuzz::need(std::isfinite(x), "a number that is not finite");
        }
    });
    return 0;
}
