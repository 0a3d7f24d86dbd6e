// SPDX-License-Identifier: MIT
// The cells of a pad, in tiles, and how pressures are added to them.
#pragma once

#include "dermis/contact.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dermis::contact {

constexpr int greatest_count = 16384;

inline size_t row_at(const Pad& pad, int y) { return size_t(y) * (pad.pitch ? pad.pitch : size_t(pad.width)); }

// Cells first..last along one axis.
struct CellSpan {
    int first, last;
    bool has(double cell) const { return cell >= first && cell <= last; }
    bool empty() const { return first > last; }
};

inline CellSpan common(CellSpan a, CellSpan b) { return {std::max(a.first, b.first), std::min(a.last, b.last)}; }

// Returns the cells of `all` at low..high. The limits stay double until they are small enough for an int.
inline CellSpan within(double low, double high, CellSpan all) {
    return {int(std::ceil(std::clamp(low, double(all.first), double(all.last) + 1))),
            int(std::floor(std::clamp(high, double(all.first) - 1, double(all.last))))};
}

// Calls each(x, lane) for 0..n-1. Each lane has a sum of its own: four independent sums hide the latency of additions.
template <class Each> void each_in_lanes(int n, Each each) {
    int x = 0;
    for (; x + 4 <= n; x += 4) each(x, 0), each(x + 1, 1), each(x + 2, 2), each(x + 3, 3);
    for (; x < n; ++x) each(x, 0);
}

// A patch in units of cells: the centre of cell (x, y) is (x, y). A cell has the mean of Hertz's profile over parts x
// parts places in it. reach: from the patch's centre to the farthest centre of a cell that may have some.
struct Disc {
    double x, y, radius, reach;
    int parts;
};

// A part of a pad that is pressed in one pass. first: whether it is the pad's first one, where the report is counted.
struct Tile {
    CellSpan columns, rows;
    bool first;
    bool meets(const Disc& disc) const {
        return disc.x + disc.reach > columns.first - 1 && disc.x - disc.reach < columns.last + 1 &&
               disc.y + disc.reach > rows.first - 1 && disc.y - disc.reach < rows.last + 1;
    }
};

// The rounding errors of the floats of a tile, whose first cell is (left, top).
struct TileRests {
    static constexpr int width = 128, height = 64;
    using Plane = float[height][width];
    int left, top;
    Plane pressure = {}, shear_x, shear_y;

    TileRests(const Pad& pad, int x, int y) : left(x), top(y) {
        if (pad.shear_x) std::memset(shear_x, 0, sizeof shear_x);
        if (pad.shear_y) std::memset(shear_y, 0, sizeof shear_y);
    }
};

// Adds pressures to the cells of a pad, and what its floats have gained by them to report.placed, Pa; and tractions to
// its maps of shear, where it has them. rests: where the rounding error of each float is kept; null: nowhere.
struct CellPress {
    const Pad& pad;
    ContactReport& report;
    TileRests* rests = nullptr;
    double along_x = 0, along_y = 0; // traction for each Pa of pressure

    CellPress dragging(double x, double y) const { return {pad, report, rests, x, y}; }
    void operator()(int x, int y, double pressure) const {
        float& cell = pad.pressure[row_at(pad, y) + size_t(x)];
        float* rest = rests ? &rest_of(rests->pressure, x, y) : nullptr;
        const double missing = rest ? double(*rest) + pressure : pressure, before = double(cell),
                     sum = before + missing;
        cell = float(sum);
        if (rest) *rest = float(sum - double(cell));
        report.placed += double(cell) - before;
        report.cells += before == 0 && cell != 0;
        report.greatest = std::max(report.greatest, double(cell));
        if (pad.shear_x && along_x != 0) drag(pad.shear_x, rests ? &rests->shear_x : nullptr, x, y, along_x * pressure);
        if (pad.shear_y && along_y != 0) drag(pad.shear_y, rests ? &rests->shear_y : nullptr, x, y, along_y * pressure);
    }

  private:
    float& rest_of(TileRests::Plane& plane, int x, int y) const { return plane[y - rests->top][x - rests->left]; }
    void drag(float* map, TileRests::Plane* kept, int x, int y, double traction) const {
        float& cell = map[row_at(pad, y) + size_t(x)];
        const double sum = double(cell) + (kept ? double(rest_of(*kept, x, y)) : 0) + traction;
        cell = float(sum);
        if (kept) rest_of(*kept, x, y) = float(sum - double(cell));
    }
};

// Calls pass(tile, press, report), where press(x, y, pressure) adds to a cell of the tile, until each cell of the pad
// has been in one tile; press.dragging(x, y) adds so many Pa of traction for each Pa as well. most: the greatest number
// of pressures that a cell gets. Sixteen additions of floats are off by at most 1e-6 of what the cell then holds. Where
// there are more, the pad is cut into tiles, and beside each float of a tile its rounding error is kept, so that no
// number of pressures loses force. Returns the report, which begins as `report`.
template <class Pass>
ContactReport press_cells(const Pad& pad, double most, const Pass& pass, ContactReport report = {}) {
    const CellSpan columns{0, pad.width - 1}, rows{0, pad.height - 1};
    constexpr int width = TileRests::width, height = TileRests::height;
    ContactReport counted_before;
    if (most <= 16) pass(Tile{columns, rows, true}, CellPress{pad, report}, report);
    else
        for (int top = 0; top < pad.height; top += height)
            for (int left = 0; left < pad.width; left += width) {
                TileRests rests(pad, left, top);
                pass(Tile{common(columns, {left, left + width - 1}), common(rows, {top, top + height - 1}),
                          top == 0 && left == 0},
                     CellPress{pad, report, &rests}, top == 0 && left == 0 ? report : counted_before);
            }
    report.placed *= pad.spacing * pad.spacing; // from Pa into N
    return report;
}

// Presses the cells of a tile that a disc covers, and returns the share of the force that falls on the pad, 0..1.
// pressure: force/spacing^2, Pa.
double spread(const Pad&, const Disc&, double pressure, const Tile&, CellPress, ContactReport&);

} // namespace dermis::contact
