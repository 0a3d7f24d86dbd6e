// SPDX-License-Identifier: MIT
// Skins as robots have them, and their pressures.
#pragma once

#include "bench/bench.hpp"

#include <cstring>
#include <random>

#include <fmt/format.h>

namespace bench {

constexpr double press_dt = 0.001; // s

// Cells of 0.25 mm.
inline dermis::SkinDescription rectangle(int width, int height) {
    dermis::SkinDescription d;
    d.grid = {width, height, 2.5e-4};
    d.surface.relief = 5e-5;
    d.material = {.modulus = 20e3, .viscosity = 1e3, .thickness = 1e-3, .curvature_length = 1e-5};
    return d;
}

// Receptors of all classes in turn, in cells drawn at random.
inline dermis::SkinDescription with_sites(dermis::SkinDescription d, int count) {
    using dermis::Quantity;
    std::mt19937 random(7);
    constexpr Quantity types[] = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    for (int i = 0; i < count; ++i)
        d.sites.push_back(
            {types[i % 4], {int(random() % unsigned(d.grid.width)), int(random() % unsigned(d.grid.height))}});
    return d;
}

// Pressures of `count` frames one after another, Pa.
inline std::vector<float> random_frames(size_t cells, size_t count) {
    std::mt19937 random(11);
    std::vector<float> frames(cells * count);
    for (float& p : frames) p = float(random() % 20000);
    return frames;
}

inline bool same(const dermis::Skin::Response& a, const dermis::Skin::Response& b) {
    return a.size == b.size && std::memcmp(a.data, b.data, a.size * sizeof(float)) == 0;
}

// The shape of a batch, in the column `method`.
inline std::string shape_of(const dermis::SkinDescription& d, int pads) {
    return fmt::format("exact-{}x{}x{}", d.grid.width, d.grid.height, pads);
}

} // namespace bench
