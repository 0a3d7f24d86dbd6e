// SPDX-License-Identifier: MIT
// What is drawn at random: sites from densities, the endings of afferents around sites, and their factors s. No
// function of the standard library is used whose last digit depends on the machine.
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"

#include <algorithm>
#include <cmath>

namespace dermis {
namespace {

// The generator SplitMix64 of Steele, Lea and Flood (2014). It draws the same cells with every compiler; distributions
// of the standard library would not.
struct SplitMix64 {
    uint64_t state;
    uint64_t next() {
        state += 0x9e3779b97f4a7c15;
        uint64_t z = state;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
        z = (z ^ z >> 27) * 0x94d049bb133111eb;
        return z ^ z >> 31;
    }
    double within(double n) { return double(next() >> 11) * 0x1p-53 * n; }
    int below(int n) { return int(within(n)); }
};

// Draws for one afferent of an entry, whatever is drawn for others.
enum class Draw { factor, endings };
SplitMix64 sequence_of(const Afferents& a, size_t afferent, Draw draw) {
    SplitMix64 random{uint64_t(a.seed)};
    random.state = random.next() ^ (uint64_t(a.type) << 1 | uint64_t(draw));
    random.state = random.next() ^ afferent;
    return random;
}

double exponential(double x) { // to 1e-13 of it, for |x| up to 50
    double sum = 1, term = 1;
    for (int k = 1; k <= 8; ++k) sum += term *= x / 1024 / k;
    for (int squared = 0; squared < 10; ++squared) sum *= sum;
    return sum;
}

double normal(SplitMix64 random) { // one beyond 8 is not missed
    for (;;) {
        const double x = random.within(16) - 8;
        if (random.within(1) < exponential(-x * x / 2)) return x;
    }
}

// A cell that holds a point of the circle's part on the grid. radius: in cells.
Cell cell_within(double radius, Cell middle, const Grid& grid, SplitMix64& random) {
    const double x0 = middle.x + 0.5, y0 = middle.y + 0.5, left = std::max(x0 - radius, 0.0),
                 top = std::max(y0 - radius, 0.0), width = std::min(x0 + radius, double(grid.width)) - left,
                 height = std::min(y0 + radius, double(grid.height)) - top;
    for (;;) {
        const double x = left + random.within(width), y = top + random.within(height);
        if ((x - x0) * (x - x0) + (y - y0) * (y - y0) <= radius * radius)
            return {std::min(int(x), grid.width - 1), std::min(int(y), grid.height - 1)};
    }
}

} // namespace

std::vector<Site> population(const Grid& grid, const Density& density, unsigned long long seed) {
    const DefaultFloats guard;
    scene::check_grid(grid);
    if (!grid.spacing) scene::refuse("grid.spacing", "(not given)", "metres, required for sites by density");
    const double area = grid.width * *grid.spacing * grid.height * *grid.spacing * 1e4; // cm2
    double all = 0;
    for (const scene::ReceptorClass& c : scene::receptor_classes) all += std::round(density.*c.density * area);
    const auto words = [&] {
        return "about " + shortest(all) + " sites need " + scene::bytes_text(all * sizeof(Site));
    };
    return scene::guarded(words, [&] {
        SplitMix64 random{seed};
        std::vector<Site> sites;
        for (const scene::ReceptorClass& c : scene::receptor_classes) {
            const std::string key = std::string("sites.density.") + name(c.type);
            const double per_area = density.*c.density, count = std::round(per_area * area);
            scene::need_not_negative(key.c_str(), per_area);
            scene::need(count <= 1e8, key.c_str(), per_area, "at most 1e8 sites of a class");
            for (double n = 0; n < count; ++n) {
                const int x = random.below(grid.width);
                sites.push_back({c.type, {x, random.below(grid.height)}});
            }
        }
        return sites;
    });
}

namespace scene {

std::vector<Cell> endings_around(const std::vector<Cell>& middles, const Afferents& a, const Grid& grid) {
    std::vector<Cell> endings;
    for (size_t n = 0; n < middles.size(); ++n) {
        SplitMix64 random = sequence_of(a, n, Draw::endings);
        for (int i = 0; i < a.endings; ++i)
            endings.push_back(cell_within(*a.radius / grid.spacing.value_or(1), middles[n], grid, random));
    }
    return endings;
}

std::vector<double> drawn_factors(const Afferents& a) {
    std::vector<double> all(a.cells.size() / size_t(a.endings), 1.0);
    for (size_t n = 0; n < all.size() && a.model->spread > 0; ++n)
        all[n] = exponential(a.model->spread * normal(sequence_of(a, n, Draw::factor)));
    return all;
}

std::string receptor_class_names() {
    std::string names;
    for (const ReceptorClass& c : receptor_classes) names += (names.empty() ? "" : ", ") + std::string(name(c.type));
    return names;
}

} // namespace scene
} // namespace dermis
