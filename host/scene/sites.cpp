// SPDX-License-Identifier: MIT
// Receptor populations: drawn from densities, or read from a list.
#include "host/scene/refusal.hpp"
#include "host/scene/scene.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <sstream>

namespace dermis {
namespace {

// Steele, Lea and Flood (2014): the same everywhere, unlike the standard library's distributions.
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

constexpr Quantity classes[] = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};

} // namespace

std::vector<Site> population(const Grid& grid, const Density& density, unsigned long long seed) {
    if (!grid.spacing) scene::refuse("grid.spacing", "(not given)", "metres, required for sites by density");
    const double area = grid.width * *grid.spacing * grid.height * *grid.spacing * 1e4; // cm2
    const double densities[] = {density.sa1, density.sa2, density.fa1, density.fa2};
    SplitMix64 random{seed};
    std::vector<Site> sites;
    for (int i = 0; i < 4; ++i) {
        const std::string key = std::string("sites.density.") + name(classes[i]);
        scene::need_not_negative(key.c_str(), densities[i]);
        const double count = std::round(densities[i] * area);
        scene::need(count <= 1e8, key.c_str(), densities[i], "at most 1e8 receptors of a class");
        for (double n = 0; n < count; ++n) {
            const int x = random.below(grid.width);
            sites.push_back({classes[i], {x, random.below(grid.height)}});
        }
    }
    return sites;
}

namespace scene {

std::vector<Site> read_sites(const std::string& path) {
    std::ifstream in(path);
    const auto fail = [&](const std::string& what) -> Error {
        return Error(Error::Code::bad_input, "sites.path",
                     "sites.path = \"" + path + "\": " + what +
                         "; allowed: a first line type,x,y, then lines such as sa1,12,40 (sa1, sa2, fa1, fa2; cells)");
    };
    if (!in) throw fail(std::string("cannot be read (") + std::strerror(errno) + ")");
    std::vector<Site> sites;
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (number == 1) {
            if (line != "type,x,y") throw fail("begins with " + line);
            continue;
        }
        std::istringstream parts(line);
        std::string type;
        Site site;
        char comma = 0;
        std::getline(parts, type, ',');
        const auto known =
            std::find_if(std::begin(classes), std::end(classes), [&](Quantity q) { return type == name(q); });
        if (known == std::end(classes) || !(parts >> site.cell.x >> comma >> site.cell.y) || comma != ',' ||
            parts.peek() != std::istringstream::traits_type::eof())
            throw fail("line " + std::to_string(number) + " is " + line);
        site.type = *known;
        sites.push_back(site);
    }
    if (sites.empty()) throw fail("holds no receptor");
    return sites;
}

} // namespace scene
} // namespace dermis
