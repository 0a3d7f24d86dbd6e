// SPDX-License-Identifier: MIT
// Which cells a patch presses, and how much of its force each of them gets.
#include "host/core/contact/tiles.hpp"

#include <numbers>

namespace dermis::contact {
namespace {

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
    template <size_t parts> static void fill(const Disc& disc, const Piece& piece, float* weights) {
        const double scale = 1 / disc.radius;
        double off[parts], rest[parts];
        for (size_t k = 0; k < parts; ++k) {
            off[k] = (double(k) + 0.5) / double(parts) - 0.5;
            const double dy = (piece.y - disc.y + off[k]) * scale;
            rest[k] = 1 - dy * dy;
        }
        for (int i = 0; i < piece.count; ++i) {
            float sums[parts] = {};
            double squares[parts];
            for (size_t k = 0; k < parts; ++k) {
                const double dx = (piece.x + i - disc.x + off[k]) * scale;
                squares[k] = dx * dx;
            }
            for (double r : rest)
                for (size_t k = 0; k < parts; ++k) sums[k] += std::sqrt(std::max(float(r - squares[k]), 0.0f));
            weights[i] = sums[0];
            for (size_t k = 1; k < parts; ++k) weights[i] += sums[k];
        }
    }

    static constexpr int room = 2048;
    int used_ = 0;
    float kept_[room + Piece::longest];
};

// Adds the weights of a disc's cells beyond the pad's border to `sum`, and their number to `cells`.
void add_beyond(const Disc& disc, CellSpan columns, CellSpan rows, double& sum, int& cells) {
    if (disc.radius > 128) { // the integral, which differs from the sum by less than 1e-4 of it
        sum = std::max(sum, 2 * std::numbers::pi / 3 * disc.radius * disc.radius); // such a disc has one part
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
double press_nearest(const Pad& pad, const Disc& disc, double pressure, const Tile& tile, CellPress press,
                     ContactReport& report) {
    const double x = std::floor(disc.x + 0.5), y = std::floor(disc.y + 0.5);
    if (x < 0 || x >= pad.width || y < 0 || y >= pad.height) {
        report.beside += !pad.tiled;
        return 0;
    }
    ++report.below_cell;
    if (tile.columns.has(x) && tile.rows.has(y)) press(int(x), int(y), pressure);
    return 1;
}

} // namespace

double spread(const Pad& pad, const Disc& disc, double pressure, const Tile& tile, CellPress press,
              ContactReport& report) {
    if (!tile.first && !tile.meets(disc)) return 0;
    const CellSpan columns{0, pad.width - 1}, rows{0, pad.height - 1};
    Weights weights;
    each_piece(disc, columns, rows, [&](const Piece& piece) { weights.add(disc, piece); });
    if (weights.cells == 0) return press_nearest(pad, disc, pressure, tile, press, report);

    double whole = weights.sum;
    int cells = weights.cells;
    const bool inside = disc.x - disc.reach > -1 && disc.x + disc.reach < pad.width && disc.y - disc.reach > -1 &&
                        disc.y + disc.reach < pad.height;
    if (!inside && !pad.keep) add_beyond(disc, columns, rows, whole, cells);
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

} // namespace dermis::contact
