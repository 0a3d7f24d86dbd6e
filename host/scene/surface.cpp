// SPDX-License-Identifier: MIT
// Surfaces: the three of the published study, or a given map.
#include "host/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace dermis::scene {
namespace {

// The permutation of 0..255 that Ken Perlin published with his noise.
constexpr unsigned char permutation[256] = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,  69,  142,
    8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,  94,  252, 219, 203,
    117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136, 171, 168, 68,  175, 74,  165,
    71,  134, 139, 48,  27,  166, 77,  146, 158, 231, 83,  111, 229, 122, 60,  211, 133, 230, 220, 105, 92,  41,
    55,  46,  245, 40,  244, 102, 143, 54,  65,  25,  63,  161, 1,   216, 80,  73,  209, 76,  132, 187, 208, 89,
    18,  169, 200, 196, 135, 130, 116, 188, 159, 86,  164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250,
    124, 123, 5,   202, 38,  147, 118, 126, 255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,  182, 189,
    28,  42,  223, 183, 170, 213, 119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,
    129, 22,  39,  253, 19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,
    242, 193, 238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,
    181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,  222, 114,
    67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

int hash(int i) { return permutation[i & 255]; }

// Returns the dot product of the gradient at lattice point (i, j) with the offset (dx, dy) from it. The low four bits
// of the hash choose one of the gradients.
double corner(int i, int j, double dx, double dy) {
    static constexpr int gx[16] = {1, -1, 1, -1, 1, -1, 1, -1, 0, 0, 0, 0, 1, -1, 0, 0};
    static constexpr int gy[16] = {1, 1, -1, -1, 0, 0, 0, 0, 1, -1, 1, -1, 0, 0, -1, 1};
    const int h = hash(hash(hash(i) + j)) & 15;
    return gx[h] * dx + gy[h] * dy;
}

// Perlin's interpolant: its first and second derivatives are 0 at t = 0 and t = 1.
double fade(double t) { return t * t * t * (t * (6 * t - 15) + 10); }

double octave(double x, double y) {
    const double cx = std::floor(x), cy = std::floor(y), dx = x - cx, dy = y - cy;
    const int i = int(std::fmod(cx, 256)), j = int(std::fmod(cy, 256)); // The lattice has period 256.
    const double u = fade(dx), v = fade(dy);
    const double low = std::lerp(corner(i, j, dx, dy), corner(i + 1, j, dx - 1, dy), u);
    const double high = std::lerp(corner(i, j + 1, dx, dy - 1), corner(i + 1, j + 1, dx - 1, dy - 1), u);
    return std::lerp(low, high, v);
}

// Perlin's improved gradient noise in two dimensions: four octaves, values of about -1..1.
double noise(double x, double y) {
    double sum = 0, amplitude = 1, total = 0;
    for (int k = 0; k < 4; ++k, x *= 2, y *= 2, amplitude /= 2) {
        sum += amplitude * octave(x, y);
        total += amplitude;
    }
    return sum / total;
}

} // namespace

Map surface_heights(const SkinDescription& scene) {
    const Surface& s = scene.surface;
    const int width = scene.grid.width, height = scene.grid.height;
    std::vector<double> map;
    if (s.kind == Surface::Kind::map) return s.map;
    map.assign(size_t(width) * height, 0.5);
    if (s.kind == Surface::Kind::wave || s.kind == Surface::Kind::spiral) {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double dx = x - width / 2, dy = y - height / 2; // The centre is a whole cell.
                const double phase =
                    s.kind == Surface::Kind::wave
                        ? 2 * std::numbers::pi * *s.ridges * (double(x) / width + 0.3 * std::sin(y / 30.0))
                        : *s.ridges * std::hypot(dx, dy) / width + std::atan2(dy, dx);
                map[size_t(y) * width + x] =
                    std::sin(phase) + *s.noise * noise(x / *s.noise_length, y / *s.noise_length);
            }
        const auto [low, high] = std::minmax_element(map.begin(), map.end());
        const double base = *low, range = *high - *low;
        for (double& v : map) v = range > 0 ? (v - base) / range : 0.5;
    }
    return map;
}

double cells_per_ridge(const SkinDescription& scene) {
    const double ridges = *scene.surface.ridges;
    switch (scene.surface.kind) {
    case Surface::Kind::wave: return std::abs(scene.grid.width / ridges);
    case Surface::Kind::spiral: return std::abs(2 * std::numbers::pi * scene.grid.width / ridges);
    default: return std::numeric_limits<double>::infinity();
    }
}

} // namespace dermis::scene
