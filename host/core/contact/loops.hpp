// SPDX-License-Identifier: MIT
// Loops over the cells that a body may press, compiled once for each instruction set of the processor family. The text
// is the same, and so are the bits: a sum has eight lanes, whatever a register holds.
#pragma once

#include <cstddef>

namespace dermis::contact {

constexpr double not_below = -1e6; // m, the depth of a cell that is neither above nor below a body

// Places of a pad's surface, in cells from the centre of cell (0, 0): columns and rows of cells from (x, y) on, whose
// depths stand in rows of `pitch`; or, scattered, one row of places that LineRow lists.
struct Block {
    double x, y;
    int columns, rows;
    std::size_t pitch;
    bool scattered = false;
};

// The lines from places along the surface's inward normals, in the frame of a body: from + t*along, |along| = 1.
struct LineRow {
    static constexpr int most = 64;
    bool flat;                                       // whether the lines are parallel: the next four hold
    double origin[3], step_x[3], step_y[3], down[3]; // from = origin + x*step_x + y*step_y, along = down
    double from[3][most], along[3][most]; // else these, of one row; of scattered parallel lines from has x and y
    double deepest;                       // m: what is deeper counts as if it were not there
    const double* faces;                  // of a hull, as in Body
    std::size_t face_count;
};

// Cells in rows of `pitch`, a multiple of 8; those beyond the width have no share. Places are in cells from the middle.
struct BedCells {
    int width, height;
    std::size_t pitch;
    const float *depth, *share; // m, at most 0; 0..1
};

// A rigid surface over the depths: the excess of a cell is depth + level + along_x*x + along_y*y, m.
struct Plane {
    double level, along_x, along_y;
};

// Sums over the cells whose excess e is above 0, each by its share: of 1, x, y, x^2, xy, y^2, and of these times e.
struct Sums {
    double n, x, y, xx, xy, yy, e, ex, ey, exx, exy, eyy, ee;
};

// Rows of a pad, to which pressures are added, and tractions for each Pa: drag_x - twist*y and drag_y + twist*x of cell
// (x, y).
struct AddedRows {
    int width, height;
    std::size_t pitch, bed_pitch;
    const float* pressure; // of the bed, before `scale`
    float scale;
    float *to, *shear_x, *shear_y; // shear: null without
    float drag_x, drag_y, twist;
};
// What the rows have got: the sums of pressures, of them times x and y, and of what the pad's floats have gained by
// them, Pa; the greatest pressure that a pressed cell holds then, the number of cells that held 0 before, and the first
// and the last column and row that are pressed.
struct Gained {
    double pressed, x, y, placed;
    float greatest;
    int cells, left, right, top, bottom;
};

struct CellLoops {
    // Writes to the depth of each place the greater of what it holds and how far its line leads to where it leaves the
    // body, m. kind and size: of a Body.
    void (*deepen)(int kind, const double* size, const LineRow&, const Block&, double* depth);
    // Writes depths relative to the greatest one, and shares, 1 where there is a depth, unless `share` is null. count:
    // a multiple of 8. Returns the greatest depth.
    double (*settle)(const double* deep, std::size_t count, float* depth, float* share);
    // The sums n and e of every step-th row.
    void (*level)(const BedCells&, float level, int step, double* n, double* e);
    void (*sums)(const BedCells&, const Plane&, Sums*);
    // Writes share*excess of each cell, and returns the sum.
    double (*write)(const BedCells&, const Plane&, float* excess);
    Gained (*add)(const AddedRows&);
};
extern const CellLoops plain_loops;
#ifdef DERMIS_X86_64
extern const CellLoops avx2_loops;
#endif
const CellLoops& loops(); // the best that this processor supports

} // namespace dermis::contact
