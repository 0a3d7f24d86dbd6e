// SPDX-License-Identifier: MIT
// What never changes of a skin, made once from its description: numbers, materials and maps that every run, stream and
// backend reads.
#pragma once

#include "dermis/dermis.hpp"
#include "host/plan/coefficients.hpp"
#include "host/scene/scene.hpp"

namespace dermis::plan {

// Flags of strain, SA1, SA2, FA1, FA2: whether anything is asked of a quantity.
using Wanted = std::array<bool, REDUCED_MAPS>;

// Rows and tiles of columns outside which no cell is ever pressed: all that such cells have is +0.
struct PressedBox {
    int first_row = 0, last_row = 0, first_tile = 0, last_tile = 0; // the last is one behind
    int first_column() const { return first_tile * TILE_CELLS; }
    int last_column(int width) const { return std::min(last_tile * TILE_CELLS, width); }
};

struct PreparedSkin {
    SkinDescription description;    // validated, every default filled in
    Map surface;                    // S, width*height
    int pitch = 0, tiles = 0;       // cells from row to row, tiles per row
    int stencil = 0, edges = 0;     // names in kernels/layout.h
    f64::Constants constants{};     // what does not change from step to step
    std::vector<Element> materials; // each once, in the order of its first cell
    std::vector<int> material_of;   // which of them a cell has, pitch*height; empty where there is one
    ResponseRule rule{};

    int width() const { return constants.width; }
    int height() const { return constants.height; }
    size_t cells() const { return size_t(width()) * size_t(height()); }
    size_t padded_cells() const { return size_t(pitch) * size_t(height()); }
    bool uniform() const { return material_of.empty(); }
    PressedBox whole() const { return {0, height(), 0, tiles}; }
    double spacing() const { return description.grid.spacing.value_or(1); }
};

// `description` is validated.
PreparedSkin prepare_skin(const SkinDescription& description);
// The same skin of another modulus and viscosity, one number each.
PreparedSkin with_material(PreparedSkin, double modulus, double viscosity);
// Lets go of the maps once a backend holds what it needs of them.
void drop_maps(PreparedSkin&);

// What a kernel is specialized by (see kernels/layout.h).
struct Variant {
    int stencil = 0, edges = 0;
    bool compensated = false, materials = false;
    bool framed = false; // the pressure runs from frame to frame
    Wanted wanted{};
};

} // namespace dermis::plan
