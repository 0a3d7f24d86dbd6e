// SPDX-License-Identifier: MIT
// Sites, drawn at random from densities.
#include "host/core/base/float_environment.hpp"
#include "host/core/base/memory.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"

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
    int below(int n) { return int(double(next() >> 11) * 0x1p-53 * n); }
};

} // namespace

std::vector<Site> population(const Grid& grid, const Density& density, unsigned long long seed) {
    const DefaultFloats guard;
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

std::string receptor_class_names() {
    std::string names;
    for (const ReceptorClass& c : receptor_classes) names += (names.empty() ? "" : ", ") + std::string(name(c.type));
    return names;
}

} // namespace scene
} // namespace dermis
