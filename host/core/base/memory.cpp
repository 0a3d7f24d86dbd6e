// SPDX-License-Identifier: MIT
#include "host/core/base/memory.hpp"

#include <cstdio>

namespace dermis::scene {
namespace {

// The error of a failed allocation, made before memory runs out; a copy allocates nothing. Empty if it could not be
// made.
const std::optional<Error> reserved = []() -> std::optional<Error> {
    try {
        return Error(Error::Code::no_memory, "", "out of memory");
    } catch (const std::bad_alloc&) {
        return {};
    }
}();

} // namespace

void out_of_memory() {
    if (reserved) throw *reserved;
    throw std::bad_alloc();
}

std::string bytes_text(double bytes) {
    const char* unit = "bytes";
    for (const auto& [name, size] : {std::pair{"TB", 1e12}, {"GB", 1e9}, {"MB", 1e6}, {"kB", 1e3}})
        if (bytes >= size) {
            bytes /= size;
            unit = name;
            break;
        }
    char text[32];
    std::snprintf(text, sizeof text, "%.3g %s", bytes, unit);
    return text;
}

std::string grid_text(const Grid& grid) {
    return std::to_string(grid.width) + " x " + std::to_string(grid.height) + " cells";
}

double bytes_of(const SkinDescription& d, const SkinOptions& options) {
    // A cell has a pressure, and without sites what a site has: a strain of each element, and responses.
    const double strains = std::max(1.0, double(d.material.elements.size())), sites = double(d.sites.size());
    const double shear = options.shear ? 2 * (1 + strains + 1) : 0; // along x and y, with one response
    const double cell = sites ? 1 : 1 + strains + double(options.responses.size()) + shear;
    return sizeof(float) * options.count * (double(d.grid.width) * d.grid.height * cell + sites * (strains + 1));
}

std::string needs_of(const SkinDescription& d, const SkinOptions& options) {
    return std::to_string(options.count) + (options.count == 1 ? " skin of " : " skins of ") + grid_text(d.grid) +
           " and " + std::to_string(d.sites.size()) + " sites need at least " + bytes_text(bytes_of(d, options));
}

} // namespace dermis::scene
