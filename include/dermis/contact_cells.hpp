// SPDX-License-Identifier: MIT
// Which cells a patch presses, and how pressures are added to them. contact.hpp has what users need to know.
//
// contact.hpp comes first even where a file includes this header alone. It includes this one, so the guard is below.
#include <dermis/contact.hpp>

#ifndef DERMIS_CONTACT_CELLS_HPP
#define DERMIS_CONTACT_CELLS_HPP

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dermis::contact::detail {

inline constexpr int greatest_count = 16384;
inline constexpr double pi = 3.14159265358979323846;

inline std::size_t row_at(const Pad& pad, int y) {
    return std::size_t(y) * (pad.pitch ? pad.pitch : std::size_t(pad.width));
}
inline float* row_of(const Pad& pad, int y) { return pad.pressure + row_at(pad, y); }

// Adds `pressure`, Pa, to a cell of the caller's buffer, and what the float has gained by it to report.placed.
inline void press(float& cell, double pressure, Report& report) {
    const float before = cell;
    cell = float(double(before) + pressure);
    report.placed += double(cell) - double(before);
    report.cells += before == 0 && cell != 0;
    report.greatest = std::max(report.greatest, double(cell));
}

// Turns report.placed from Pa into N, once all cells of the pad have been pressed.
inline void finish(const Pad& pad, Report& report) { report.placed *= pad.spacing * pad.spacing; }

// Cells first..last along one axis.
struct CellSpan {
    int first, last;
    bool has(double cell) const { return cell >= first && cell <= last; }
};

inline CellSpan common(CellSpan a, CellSpan b) { return {std::max(a.first, b.first), std::min(a.last, b.last)}; }

// Returns the cells of `all` at low..high. The limits stay double until they are small enough for an int.
inline CellSpan within(double low, double high, CellSpan all) {
    return {int(std::ceil(std::clamp(low, double(all.first), double(all.last) + 1))),
            int(std::floor(std::clamp(high, double(all.first) - 1, double(all.last))))};
}

// A patch in units of cells: the centre of cell (x, y) is (x, y). A cell has the mean of Hertz's profile over parts x
// parts places in it. reach: from the patch's centre to the farthest centre of a cell that may have some.
struct Disc {
    double x, y, radius, reach;
    int parts;
};

// The profile at the centres of cells alone makes the middle and the width of a small patch jump while the patch moves
// within a cell. The mean over several places in each cell does not, but it widens the patch: it adds 1/6 to the mean
// square radius, which is 0.4*radius^2. The radius is made smaller by as much.
inline Disc disc_of(double x, double y, double radius) {
    constexpr double corner = 0.54; // from the centre of a cell to the farthest of its places, and more
    if (radius < 1.5 || radius >= 8) return {x, y, radius, radius, 1};
    const double own = std::sqrt(radius * radius - 1.0 / 6 / 0.4);
    return {x, y, own, own + corner, radius < 4 ? 4 : 2};
}

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

// Adds pressures to the cells of a pad, and tractions to its maps of shear, where it has them. rests: where the
// rounding error of each float is kept; null: nowhere.
struct CellPress {
    const Pad& pad;
    Report& report;
    TileRests* rests = nullptr;
    double along_x = 0, along_y = 0; // traction for each Pa of pressure

    CellPress dragging(double x, double y) const { return {pad, report, rests, x, y}; }
    void operator()(int x, int y, double pressure) const {
        float& cell = row_of(pad, y)[x];
        if (rests) {
            float& rest = rest_of(rests->pressure, x, y);
            const double missing = double(rest) + pressure, sum = double(cell) + missing;
            press(cell, missing, report);
            rest = float(sum - double(cell));
        } else press(cell, pressure, report);
        if (pad.shear_x && along_x != 0) drag(pad.shear_x, rests ? &rests->shear_x : nullptr, x, y, along_x * pressure);
        if (pad.shear_y && along_y != 0) drag(pad.shear_y, rests ? &rests->shear_y : nullptr, x, y, along_y * pressure);
    }

  private:
    float& rest_of(TileRests::Plane& plane, int x, int y) const { return plane[y - rests->top][x - rests->left]; }
    void drag(float* map, TileRests::Plane* kept, int x, int y, double traction) const {
        float& cell = map[row_at(pad, y) + std::size_t(x)];
        const double sum = double(cell) + (kept ? double(rest_of(*kept, x, y)) : 0) + traction;
        cell = float(sum);
        if (kept) rest_of(*kept, x, y) = float(sum - double(cell));
    }
};

// Calls pass(tile, press, report), where press(x, y, pressure) adds to a cell of the tile, until each cell of the pad
// has been in one tile; press.dragging(x, y) adds so many Pa of traction for each Pa as well. most: the greatest number
// of pressures that a cell gets. Sixteen additions of floats are off by at most 1e-6 of what the cell then holds. Where
// there are more, the pad is cut into tiles, and beside each float of a tile its rounding error is kept, so that no
// number of pressures loses force.
template <class Pass> Report press_cells(const Pad& pad, double most, const Pass& pass) {
    Report report;
    if (most <= 16) {
        pass(Tile{{0, pad.width - 1}, {0, pad.height - 1}, true}, CellPress{pad, report}, report);
        finish(pad, report);
        return report;
    }
    constexpr int width = TileRests::width, height = TileRests::height;
    Report counted_before;
    for (int top = 0; top < pad.height; top += height)
        for (int left = 0; left < pad.width; left += width) {
            const Tile tile{common({0, pad.width - 1}, {left, left + width - 1}),
                            common({0, pad.height - 1}, {top, top + height - 1}), top == 0 && left == 0};
            TileRests rests(pad, left, top);
            pass(tile, CellPress{pad, report, &rests}, tile.first ? report : counted_before);
        }
    finish(pad, report);
    return report;
}

// Neighbouring cells in one row of a disc: `count` cells from (x, y) on.
struct Piece {
    static constexpr int longest = 256;
    int x, y, count;
};

// Calls each(piece) for the cells in `columns` and `rows` that have their centre within the disc's reach, row by row.
template <class Each> void each_piece(const Disc& disc, CellSpan columns, CellSpan rows, Each each) {
    if (disc.radius < 1e-6) return; // At most the nearest centre is inside; press_nearest() presses that.
    const double scale = 1 / disc.reach;
    rows = within(disc.y - disc.reach, disc.y + disc.reach, rows);
    for (int y = rows.first; y <= rows.last; ++y) {
        const double dy = (y - disc.y) * scale, rest = 1 - dy * dy;
        if (rest <= 0) continue;
        const double half = disc.reach * std::sqrt(rest);
        const CellSpan covered = within(disc.x - half, disc.x + half, columns);
        for (int x = covered.first; x <= covered.last; x += Piece::longest)
            each(Piece{x, y, std::min(Piece::longest, covered.last + 1 - x)});
    }
}

// Calls each(x, lane) for 0..n-1. Each lane has a sum of its own: four independent sums hide the latency of additions.
template <class Each> void each_in_lanes(int n, Each each) {
    int x = 0;
    for (; x + 4 <= n; x += 4) each(x, 0), each(x + 1, 1), each(x + 2, 2), each(x + 3, 3);
    for (; x < n; ++x) each(x, 0);
}

// The weights of a disc's cells by Hertz's profile. They are computed once and kept, up to `room` of them, because the
// square roots take most of the time.
class Weights {
  public:
    double sum = 0;
    int cells = 0; // of a weight above 0

    // Adds the cells of a piece.
    void add(const Disc& disc, const Piece& piece) {
        const float* weights = of(disc, piece, used_);
        used_ += piece.count;
        double sums[4] = {0, 0, 0, 0};
        each_in_lanes(piece.count, [&](int i, int lane) { sums[lane] += double(weights[i]), cells += weights[i] > 0; });
        sum += (sums[0] + sums[1]) + (sums[2] + sums[3]);
    }
    // Returns the weights of a piece. before: the number of cells in the disc's earlier pieces.
    const float* of(const Disc& disc, const Piece& piece, int before) {
        const bool fits = before + piece.count <= room, made = before < used_;
        float* weights = fits ? kept_ + before : kept_ + room;
        if (fits && made) return weights;
        if (disc.parts == 1) fill<1>(disc, piece, weights);
        else if (disc.parts == 2) fill<2>(disc, piece, weights);
        else fill<4>(disc, piece, weights);
        return weights;
    }

  private:
    // Sums up the profile over parts x parts places in each cell of a piece.
    template <std::size_t parts> static void fill(const Disc& disc, const Piece& piece, float* weights) {
        const double scale = 1 / disc.radius;
        double off[parts], rest[parts];
        for (std::size_t k = 0; k < parts; ++k) {
            off[k] = (double(k) + 0.5) / double(parts) - 0.5;
            const double dy = (piece.y - disc.y + off[k]) * scale;
            rest[k] = 1 - dy * dy;
        }
        for (int i = 0; i < piece.count; ++i) {
            float sums[parts] = {};
            double squares[parts];
            for (std::size_t k = 0; k < parts; ++k) {
                const double dx = (piece.x + i - disc.x + off[k]) * scale;
                squares[k] = dx * dx;
            }
            for (double r : rest)
                for (std::size_t k = 0; k < parts; ++k) sums[k] += std::sqrt(std::max(float(r - squares[k]), 0.0f));
            weights[i] = sums[0];
            for (std::size_t k = 1; k < parts; ++k) weights[i] += sums[k];
        }
    }

    static constexpr int room = 2048;
    int used_ = 0;
    float kept_[room + Piece::longest];
};

// Adds the weights of a disc's cells beyond the pad's border to `sum`, and their number to `cells`.
inline void add_beyond(const Disc& disc, CellSpan columns, CellSpan rows, double& sum, int& cells) {
    if (disc.radius > 128) { // the integral, which differs from the sum by less than 1e-4 of it
        sum = std::max(sum, 2 * pi / 3 * disc.radius * disc.radius); // such a disc has one part
        ++cells;
        return;
    }
    constexpr int far_away = 2 * greatest_count;
    Weights beyond;
    const auto add = [&](CellSpan some_columns, CellSpan some_rows) {
        each_piece(disc, some_columns, some_rows, [&](const Piece& piece) { beyond.add(disc, piece); });
    };
    add({-far_away, far_away}, {-far_away, -1});
    add({-far_away, far_away}, {rows.last + 1, far_away});
    add({-far_away, -1}, rows);
    add({columns.last + 1, far_away}, rows);
    sum += beyond.sum;
    cells += beyond.cells;
}

// Presses a patch that covers no cell's centre on the pad: it covers none at all, or only centres beside the pad.
// Returns the share of the force that falls on the pad, 0 or 1.
template <class Press>
double press_nearest(const Pad& pad, const Disc& disc, double pressure, const Tile& tile, const Press& press,
                     Report& report) {
    const double x = std::floor(disc.x + 0.5), y = std::floor(disc.y + 0.5);
    if (x < 0 || x >= pad.width || y < 0 || y >= pad.height) {
        report.beside += !pad.tiled;
        return 0;
    }
    ++report.below_cell;
    if (tile.columns.has(x) && tile.rows.has(y)) press(int(x), int(y), pressure);
    return 1;
}

// Presses the cells of a tile that a disc covers, and returns the share of the force that falls on the pad, 0..1.
// pressure: force/spacing^2, Pa.
template <class Press>
double spread(const Pad& pad, const Disc& disc, double pressure, const Tile& tile, const Press& press, Report& report) {
    if (!tile.first && !tile.meets(disc)) return 0;
    const CellSpan columns{0, pad.width - 1}, rows{0, pad.height - 1};
    Weights weights;
    each_piece(disc, columns, rows, [&](const Piece& piece) { weights.add(disc, piece); });
    if (weights.cells == 0) return press_nearest(pad, disc, pressure, tile, press, report);

    double whole = weights.sum;
    int cells = weights.cells;
    const bool inside = disc.x - disc.reach > -1 && disc.x + disc.reach < pad.width && disc.y - disc.reach > -1 &&
                        disc.y + disc.reach < pad.height;
    if (!inside) add_beyond(disc, columns, rows, whole, cells);
    report.below_cell += cells == 1;
    const double peak = pressure / whole;
    int before = 0;
    each_piece(disc, columns, rows, [&](const Piece& piece) {
        const CellSpan covered = common({piece.x, piece.x + piece.count - 1}, tile.columns);
        if (tile.rows.has(piece.y) && covered.first <= covered.last) {
            const float* weight = weights.of(disc, piece, before);
            for (int x = covered.first; x <= covered.last; ++x) press(x, piece.y, peak * double(weight[x - piece.x]));
        }
        before += piece.count;
    });
    return weights.sum / whole;
}

} // namespace dermis::contact::detail

#endif
