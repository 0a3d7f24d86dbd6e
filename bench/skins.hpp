// SPDX-License-Identifier: MIT
// Skins as robots have them, and their pressures.
#pragma once

#include "bench/bench.hpp"

#include <cmath>
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

// Retardation times from 4 ms on, each three times the one before.
inline dermis::Material chain_of(int elements, bool spring) {
    dermis::Material m;
    if (elements == 1 && !spring) return m;
    for (int e = 0; e < elements; ++e) m.elements.push_back({2e6 / (1 + e), 8e3 * std::pow(3, e) / (1 + e)});
    if (spring) m.spring = 4e6;
    return m;
}

// How materials are spread over a grid.
enum class Spread { uniform, patches, random, thousand, each };

// The index of each cell's material; empty if there is one.
inline std::vector<size_t> materials_of(Spread spread, size_t n) {
    if (spread == Spread::uniform) return {};
    std::vector<size_t> of(n * n);
    std::mt19937 random(1);
    for (size_t i = 0; i < of.size(); ++i)
        of[i] = spread == Spread::patches    ? (i / n / (n / 4) + i % n / (n / 8)) % 4
                : spread == Spread::random   ? random() % 4
                : spread == Spread::thousand ? random() % 1000
                                             : i;
    return of;
}

// The shape of a batch, in the column `method`.
inline std::string shape_of(const dermis::SkinDescription& d, int pads) {
    return fmt::format("exact-{}x{}x{}", d.grid.width, d.grid.height, pads);
}

} // namespace bench
