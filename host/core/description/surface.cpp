// SPDX-License-Identifier: MIT
// Surfaces: the three of the published study, or a given map.
#include "host/core/base/pool.hpp"
#include "host/core/base/watch.hpp"
#include "host/core/description/description.hpp"
#include "host/core/description/skin_keys.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

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

// Gradients at lattice points. The low four bits of a point's hash choose one of them.
constexpr double gradient_x[16] = {1, -1, 1, -1, 1, -1, 1, -1, 0, 0, 0, 0, 1, -1, 0, 0};
constexpr double gradient_y[16] = {1, 1, -1, -1, 0, 0, 0, 0, 1, -1, 1, -1, 0, 0, -1, 1};

// Perlin's interpolant: its first and second derivatives are 0 at t = 0 and t = 1. Rounding may carry it above 1.
double fade(double t) { return t * t * t * (t * (6 * t - 15) + 10); }

// Returns std::lerp(a, b, t), bit for bit. Where t < 1 is known, it is computed without branches, so that loops
// vectorise.
template <bool below_one> double interpolated(double a, double b, double t) {
    if constexpr (!below_one) return std::lerp(a, b, t);
    const double sum = t * b + (1 - t) * a, between = a + t * (b - a);
    const double low = b < between ? b : between, high = b < between ? between : b;
    const double bounded = a < b ? low : high; // rounding does not carry the result past b
    const double least = a < b ? a : b, greatest = a < b ? b : a;
    return least > 0 ? bounded : greatest < 0 ? bounded : sum;
}

// The part of a corner's value that all cells of a row between two lattice points share.
struct Corner {
    double x, along_y; // the gradient's x; its y times the offset in y
    Corner(int i, int j, double dy) {
        const int h = hash(hash(hash(i) + j)) & 15;
        x = gradient_x[h];
        along_y = gradient_y[h] * dy;
    }
    // The dot product of the gradient with the offset.
    double at(double dx) const { return x * dx + along_y; }
};

// Perlin's improved gradient noise in two dimensions: four octaves, values of about -1..1. Whatever depends on the
// column alone is computed once.
class Noise {
  public:
    // length: cells between the lattice points of the first octave.
    Noise(int width, double length) : length_(length) {
        for (size_t k = 0; k < octaves_.size(); ++k) {
            Octave& octave = octaves_[k];
            for (int x = 0; x < width; ++x) {
                const Place place(x / length_ * double(1 << k));
                if (octave.spans.empty() || octave.spans.back().point != place.point)
                    octave.spans.push_back({.first = x, .last = x, .point = place.point, .below_one = true});
                octave.spans.back().last = x + 1;
                octave.spans.back().below_one &= place.weight < 1;
                octave.offset.push_back(place.offset);
                octave.weight.push_back(place.weight);
            }
        }
    }
    // Computes the noise of the cells of row y. values: one per column, 0 before the call.
    void row(int y, double* values) const {
        double amplitude = 1, total = 0;
        for (size_t k = 0; k < octaves_.size(); ++k, amplitude /= 2) {
            const Octave& octave = octaves_[k];
            const Place place(y / length_ * double(1 << k));
            for (const Span& span : octave.spans) {
                if (span.below_one && place.weight < 1) add<true>(octave, span, place, amplitude, values);
                else add<false>(octave, span, place, amplitude, values);
            }
            total += amplitude;
        }
        for (size_t x = 0; x < octaves_[0].offset.size(); ++x) values[x] /= total;
    }

  private:
    // The place of a column or a row: the lattice point before it, the offset from it, and the weight of the next one.
    struct Place {
        int point;
        double offset, weight;
        explicit Place(double at) {
            const double floor = std::floor(at);
            point = int(std::fmod(floor, 256)); // the lattice has period 256
            offset = at - floor;
            weight = fade(offset);
        }
    };
    // Columns first .. last - 1, which have the same lattice point before them.
    struct Span {
        int first, last, point;
        bool below_one; // every weight is below 1
    };
    struct Octave {
        std::vector<double> offset, weight; // of each column's Place
        std::vector<Span> spans;
    };

    template <bool below_one>
    static void add(const Octave& octave, const Span& span, const Place& y, double amplitude, double* values) {
        const int i = span.point, j = y.point;
        const Corner low_left(i, j, y.offset), low_right(i + 1, j, y.offset);
        const Corner high_left(i, j + 1, y.offset - 1), high_right(i + 1, j + 1, y.offset - 1);
        const double *offset = octave.offset.data(), *weight = octave.weight.data();
        const double rise = y.weight;
        for (int x = span.first; x < span.last; ++x) {
            const double dx = offset[x], t = weight[x];
            const double low = interpolated<below_one>(low_left.at(dx), low_right.at(dx - 1), t);
            const double high = interpolated<below_one>(high_left.at(dx), high_right.at(dx - 1), t);
            values[x] += amplitude * interpolated<below_one>(low, high, rise);
        }
    }

    double length_;
    std::array<Octave, 4> octaves_;
};

// A surface with ridges, before its heights are scaled.
class Ridges {
  public:
    explicit Ridges(const SkinDescription& scene)
        : surface_(scene.surface), width_(scene.grid.width), height_(scene.grid.height) {
        for (int x = 0; x < width_; ++x) across_.push_back(double(x) / width_);
        if (*surface_.noise != 0) noise_.emplace(width_, *surface_.noise_length);
    }

    // Computes the heights of row y. heights: one per column, 0 before the call.
    void row(int y, double* heights) const {
        if (noise_) noise_->row(y, heights);
        const double noise = *surface_.noise;
        const double ridges = *surface_.ridges;
        if (surface_.kind == Surface::Kind::wave) {
            const double bend = 0.3 * std::sin(y / 30.0), turns = 2 * std::numbers::pi * ridges;
            for (int x = 0; x < width_; ++x)
                heights[x] = std::sin(turns * (across_[size_t(x)] + bend)) + noise * heights[x];
        } else {
            const double dy = y - height_ / 2; // The centre is a whole cell.
            for (int x = 0; x < width_; ++x) {
                const double dx = x - width_ / 2;
                heights[x] = std::sin(ridges * std::hypot(dx, dy) / width_ + std::atan2(dy, dx)) + noise * heights[x];
            }
        }
    }

  private:
    const Surface& surface_;
    const int width_, height_;
    std::vector<double> across_; // x/width
    std::optional<Noise> noise_; // none where its amplitude is 0
};

} // namespace

Map surface_heights(const SkinDescription& scene, int threads) {
    const Surface& s = scene.surface;
    const int width = scene.grid.width, height = scene.grid.height;
    if (s.kind == Surface::Kind::map) return s.map;
    const bool flat = s.kind == Surface::Kind::flat;
    std::vector<double> map = simd::map_of(size_t(width) * size_t(height), flat ? 0.5 : 0.0);
    if (flat) return map;
    const Ridges ridges(scene);
    simd::Pool pool(simd::useful_threads(map.size(), threads));
    std::vector<double> least(size_t(height), 0), greatest(least); // of each row
    pool.share(height, [&](int first, int last) {
        for (int y = first; y < last; ++y) {
            if (pool.failed()) return;
            look();
            double* row = map.data() + size_t(y) * size_t(width);
            ridges.row(y, row);
            const auto [low, high] = std::minmax_element(row, row + width);
            least[size_t(y)] = *low;
            greatest[size_t(y)] = *high;
        }
    });
    const double base = *std::min_element(least.begin(), least.end());
    const double range = *std::max_element(greatest.begin(), greatest.end()) - base;
    pool.share(height, [&](int first, int last) {
        const auto from = map.begin() + std::ptrdiff_t(first) * width, to = map.begin() + std::ptrdiff_t(last) * width;
        std::for_each(from, to, [=](double& v) { v = range > 0 ? (v - base) / range : 0.5; });
    });
    return map;
}

double cells_per_ridge(const SkinDescription& scene) {
    const Surface& s = scene.surface;
    const double turn = s.kind == Surface::Kind::spiral ? 2 * std::numbers::pi : 1;
    if (of_ridges.holds(s)) return std::abs(turn * scene.grid.width / *s.ridges);
    // A curvature that is given is not computed on the cells of the grid, so that their number does not matter.
    const bool measured = s.kind == Surface::Kind::map && s.ridge_period && s.curvature.empty();
    return measured ? *s.ridge_period / *scene.grid.spacing : std::numeric_limits<double>::infinity();
}

} // namespace dermis::scene
