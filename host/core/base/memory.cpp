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

double cells_of(const Grid& grid) { return double(grid.width) * double(grid.height); }

} // namespace

void out_of_memory() {
    if (reserved) throw *reserved;
    throw std::bad_alloc();
}

std::string bytes_text(double bytes) {
    const char* unit = "bytes";
    for (const auto& [name, size] : {std::pair{"GB", 1e9}, {"MB", 1e6}, {"kB", 1e3}})
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

std::string needs_of(const SkinDescription& d, const SkinOptions& options) {
    // Each cell has a pressure, and without sites a strain and responses.
    const double of_cell = 1 + (d.sites.empty() ? 1 + double(options.responses.size()) : 0);
    return std::to_string(options.count) + (options.count == 1 ? " skin of " : " skins of ") + grid_text(d.grid) +
           " and " + std::to_string(d.sites.size()) + " receptors need at least " +
           bytes_text(sizeof(float) * options.count * (cells_of(d.grid) * of_cell + double(d.sites.size())));
}

} // namespace dermis::scene
