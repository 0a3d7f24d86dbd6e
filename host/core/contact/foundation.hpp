// SPDX-License-Identifier: MIT
// A body presses an elastic foundation (Winkler): the pressure of a cell is k*(depth + level + tilts), where that is
// above 0. The level is such that the pressures sum to the force; the tilts bring their centre to the force's.
#pragma once

#include "dermis/contact.hpp"
#include "host/core/contact/loops.hpp"

#include <algorithm>
#include <vector>

namespace dermis::contact {

// The cells below a body, in rows of `pitch`: those beyond the width belong to no pad. Cell (left, top) is the pad's
// cell (0, 0).
struct Bed {
    int width = 0, height = 0, left = 0, top = 0;
    std::size_t pitch = 0;
    std::vector<double> deep;    // m, the depths as they are found; not_below: no cell of the patch
    double deepest = not_below;  // m
    double level = 0;            // m, level_of() the last press asked of these depths; 0: not known
    std::vector<float> depth;    // m, relative to the deepest cell's; at most 0
    std::vector<float> share;    // of each cell the part that the body is below, 0..1
    std::vector<float> pressure; // the answer: in proportion to the pressure

    void reserve(int columns, int rows);
    void resize(int columns, int rows, int left, int top);
    // Fills depth from deep, and the shares too if asked for, 1 where there is a depth. Returns whether any cell has
    // one.
    bool settle(bool shares);
    bool presses_border() const;
    BedCells cells() const { return {width, height, pitch, depth.data(), share.data()}; }
    // The number of a pad's cell.
    std::size_t number(int x, int y) const { return std::size_t(y + top) * pitch + std::size_t(x + left); }
    // The pad's middle, cells from the bed's.
    double off_x(const Pad& pad) const { return left + 0.5 * (pad.width - width); }
    double off_y(const Pad& pad) const { return top + 0.5 * (pad.height - height); }
};

// What presses the bed. Lengths are in cells, from the middle of the bed.
struct Push {
    double force, area;   // N, > 0; m^2, of a cell
    double asked;         // m: asked_of() these and the stiffness
    bool centred = false; // whether the pressure's centre is to be (x, y)
    double x = 0, y = 0;
};
// The sum of excesses that carries a force, m. Depths are known to about 1e-15 m, and floats hold levels of 1e9 m.
inline double asked_of(double force, double area, double stiffness) {
    return std::clamp(force / (stiffness * area), 1e-15, 1e9);
}

// What became of it.
struct Rest {
    double x = 0, y = 0; // the pressure's centre, cells from the middle
    double round = 0;    // the mean square of the distance from it, cells^2
    double level = 0;    // m: how far the deepest cell is above the border of the pressure, before tilts
    double scale = 0;    // Pa/m: the pressures are by so much greater than what the bed holds
    bool bound = false;  // whether the tilts are held back, so that the centre is not the force's
};

// The level at which the excesses of the cells, each by its share, sum to `asked`, m. Some cell has a share.
double level_of(const Bed&, double asked);

// Fills the pressures of the bed: Rest::scale times them are Pa, and sum to the force over the area, to rounding.
Rest press(Bed&, const Push&);

} // namespace dermis::contact
