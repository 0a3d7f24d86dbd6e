// SPDX-License-Identifier: MIT
// A skin prepared from its description: the constant numbers, materials and maps that every run, stream and backend
// reads.
#pragma once

#include "dermis/skin.hpp"
#include "host/core/description/description.hpp"
#include "host/core/model/coefficients.hpp"

namespace dermis::model {

// What the state of a cell holds, on every backend.
struct StateShape {
    size_t elements = 1;      // elements in series, whose strains the state holds
    bool spring = false;      // a spring in series with them, whose strain follows from the pressure
    bool compensated = false; // with each strain and the integral the rounding error of that sum
    bool strain = false;      // the strain of the cell: the sum over its elements and spring
    bool integral = false;    // the integral of the cell's strain, for SA2
    bool rate = false;        // the rate of the spring's strain, for FA2 between frames
    bool previous = false;    // the pressure of the frame before the one that the next step starts from

    // The numbers of a cell.
    int planes() const {
        return STATE_PLANES(int(elements), int(compensated), int(strain), int(integral), int(rate), int(previous));
    }
};

// Flags of the strain and the responses: whether any output needs the quantity.
using Wanted = std::array<bool, REDUCED_MAPS>;

// The rows and tiles of columns outside which no cell is ever pressed; all values of such cells are +0.
struct PressedBox {
    int first_row = 0, last_row = 0, first_tile = 0, last_tile = 0; // the last is exclusive
    int first_column() const { return first_tile * TILE_CELLS; }
    int last_column(int width) const { return std::min(last_tile * TILE_CELLS, width); }
};

// The cells of a skin that have one retardation time. Their elements are multiples of one element, by their resistance
// (description/element.hpp): the strain of a cell is this element's strain under the pressure over the resistance.
struct TimeGroup {
    Element element;   // modulus 1, or modulus 0 and viscosity 1
    Element low, high; // the same with the least and the greatest time of the cells, which differ by rounding
    // Whether these times differ by more than rounding in double, because maps were rounded in float.
    bool rough() const { return high.viscosity - low.viscosity > 0x1p-48 * high.viscosity; }
};

// The elements in series that a cell is made of: `length` of them, the last of them a spring where `spring` says so.
// Its strain follows the pressure at once, so that no state holds it.
struct Chain {
    size_t length = 1;
    bool spring = false;
    size_t elements() const { return length - size_t(spring); } // whose strains a state holds
};

struct PreparedSkin {
    SkinDescription description;    // validated, every default filled in
    Map heights;                    // width*height: the surface is S = relief*heights
    double relief = 1;              // m per unit of height
    int pitch = 0, tiles = 0;       // cells from row to row, tiles per row
    int stencil = 0, edges = 0;     // numbers of kernels/layout.h
    f64::Constants constants{};     // the members that do not change from step to step
    std::vector<Element> materials; // each once, in the order of its first cell: elements in series one after another
    Chain chain;                    // the same for every material
    std::vector<int> material_of;   // index of each cell's first element, pitch*height; empty if there is one material
    std::vector<TimeGroup> parts;   // where materials differ, by retardation time; none if there are more than 8 times
    std::vector<int> part_of;       // index into parts of each material
    ResponseRule rule{};

    int width() const { return constants.width; }
    int height() const { return constants.height; }
    size_t cells() const { return size_t(width()) * size_t(height()); }
    size_t padded_cells() const { return size_t(pitch) * size_t(height()); }
    bool uniform() const { return material_of.empty(); }
    // Whether kernels read the coefficients from a table, because the constants hold a single element's only.
    bool tabled() const { return !uniform() || chain.length > 1; }
    size_t number_of(Cell c) const { return size_t(c.y) * size_t(width()) + size_t(c.x); } // y*width + x
    // The index of the first element of the cell y*width + x.
    size_t material_at(size_t cell) const {
        const size_t across = size_t(width());
        return uniform() ? 0 : size_t(material_of[cell / across * size_t(pitch) + cell % across]);
    }
    // Whether so many materials differ that each row of cells makes its own coefficients.
    bool differs_everywhere() const { return materials.size() > std::max<size_t>(4096, cells() / 16); }
    PressedBox whole() const { return {0, height(), 0, tiles}; }
    double spacing() const { return description.grid.spacing.value_or(1); }
};

// Prepares a skin. `description` is validated. threads: as for Device::cpu. The pitch is a multiple of pitch_cells.
PreparedSkin prepare_skin(const SkinDescription& description, int threads, int pitch_cells = PITCH_CELLS);
// The same skin with the elements of another material.
PreparedSkin with_material(PreparedSkin, const Material&);
// Releases the maps once a backend has copied what it needs.
void drop_maps(PreparedSkin&);

// The constants of a kernel in the precision of a backend, K = f32 or f64. base_row is set where memory is bound.
template <class K> typename K::Constants constants_of(const PreparedSkin& skin, const PressedBox& pressed) {
    const auto r = [](double x) { return static_cast<typename K::scalar>(x); };
    const f64::Constants& p = skin.constants;
    typename K::Constants c{};
    c.bend = r(p.bend);
    c.curvature_length = r(p.curvature_length);
    c.gain_plus = r(p.gain_plus);
    c.gain_minus = r(p.gain_minus);
    c.thickness = r(p.thickness);
    c.width = p.width;
    c.height = p.height;
    c.pitch = p.pitch;
    c.first_column = pressed.first_column();
    c.first_row = pressed.first_row;
    return c;
}

// The specialization of a kernel (see kernels/layout.h).
struct Variant {
    int stencil = 0, edges = 0;
    bool compensated = false, materials = false;
    bool framed = false;    // the pressure runs from frame to frame
    bool parabolic = false; // along a parabola; the table then has two coefficients for each element
    Chain chain;
    bool keeps_strain = false;                              // the state holds the sum of strains in series
    enum class Pads { none, alike, own } pads = Pads::none; // in a batch: whether each pad has coefficients of its own
    bool spreads = false; // responses are signals, in maps with zeros around them (kernels/spread.h)
    bool sites = false;   // only sites respond, and only the cells that they read are needed
    Wanted wanted{};
    bool tabled() const { return materials || chain.length > 1 || parabolic; }
    StateShape state() const {
        return {.elements = chain.elements(),
                .spring = chain.spring,
                .compensated = compensated,
                .strain = keeps_strain,
                .integral = wanted[QUANTITY_SA2],
                .rate = chain.spring && framed && wanted[QUANTITY_FA2],
                .previous = parabolic};
    }
};

} // namespace dermis::model
