// SPDX-License-Identifier: MIT
// A body presses an elastic foundation (Winkler): the pressure of a cell is k*(depth + level + tilts), where that is
// above 0. The level is such that the pressures sum to the force; the tilts bring their centre to the force's.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace dermis::contact {

// The cells below a body: width*height of them, the first row first.
struct Bed {
    int width = 0, height = 0;
    std::vector<double> deep;     // m, the depths as they are found; not_below: no cell of the patch
    std::vector<double> outer, inner; // depths of shapes that are larger, and smaller, by half the diagonal of a cell
    std::vector<float> depth;     // m, relative to the deepest cell's; at most 0
    std::vector<float> share;     // of each cell the part that the body is below, 0..1
    std::vector<float> pressure;  // Pa, the answer
    double deepest = 0;           // m

    void reserve(std::size_t cells);
    void resize(int columns, int rows);
    // Fills depth from deep, and returns whether any cell has a share.
    bool settle();
};

// What presses the bed. Lengths are in cells, from the middle of the bed.
struct Push {
    double force;              // N, > 0
    double stiffness;          // Pa/m
    double area;               // m^2, of a cell
    bool centred = false;      // whether the pressure's centre is to be (x, y)
    double x = 0, y = 0;
};

// What became of it.
struct Rest {
    double x = 0, y = 0;           // the pressure's centre, cells from the middle
    double round = 0;              // the mean square of the distance from it, cells^2
    double stiffness = 0;          // Pa/m: the push's, or less, so that a patch is two cells wide
    bool bound = false;            // whether the tilts are held back, so that the centre is not the force's
    std::array<int, 4> cells = {}; // columns and rows that hold pressures: first and last column, first and last row
};

// Fills the pressures of the bed, whose sum times area is the force, to rounding.
Rest press(Bed&, const Push&);

} // namespace dermis::contact
