// SPDX-License-Identifier: MIT
// Readings of a sensor array become pressure.
#include "host/core/base/float_environment.hpp"
#include "host/core/contact/landing.hpp"

namespace dermis::contact {
namespace {

void check_taxels(const TaxelReadings& t) {
    need_memory("taxels.values", bool(t.values));
    need_within("taxels.columns", t.columns, 1, greatest_count, "1..16384");
    need_within("taxels.rows", t.rows, 1, greatest_count, "1..16384");
    need_within("taxels.width", t.width, 1e-9, greatest_length, "1e-9..1e6");
    need_within("taxels.height", t.height, 1e-9, greatest_length, "1e-9..1e6");
    need_within("taxels.x", t.x, -greatest_length, greatest_length, "-1e6..1e6");
    need_within("taxels.y", t.y, -greatest_length, greatest_length, "-1e6..1e6");
    scene::need(t.column_step > 0, "taxels.column_step", 0, ">= 1");
}

size_t place_of(const TaxelReadings& t, int i, int j) {
    return size_t(i) * t.column_step + size_t(j) * (t.row_step ? t.row_step : size_t(t.columns));
}

// An interval in units of cells, and the cells that it overlaps. An overlap that rounding makes at a common border does
// not count.
struct Interval {
    double low, high;
    CellSpan cells;
    double size() const { return high - low; }
    double overlap(double from, double to) const { return std::max(0.0, std::min(high, to) - std::max(low, from)); }
};

Interval interval(double low, double high, int count) {
    const double least = 1e-9 * std::min(1.0, high - low);
    return {low, high, within(std::floor(low + least), std::ceil(high - least) - 1, {0, count - 1})};
}

// Returns the taxels of a row or column that a tile needs. The first tile needs all, because it counts them; others
// need the taxels around their cells.
CellSpan taxels_of(const Tile& tile, CellSpan cells, double spacing, double start, double size, int count) {
    const CellSpan all{0, count - 1};
    if (tile.first) return all;
    return within((cells.first * spacing - start) / size - 2, ((cells.last + 1) * spacing - start) / size + 2, all);
}

// Presses the cells of a tile that a taxel overlaps, and returns the share of the taxel's area that is on the pad.
// pressure: force/spacing^2, Pa.
double press_area(const Pad& pad, const Interval& columns, const Interval& rows, double pressure, const Tile& tile,
                  const CellPress& press) {
    const CellSpan on_x = common(columns.cells, tile.columns), on_y = common(rows.cells, tile.rows);
    const double even = pressure / (columns.size() * rows.size());
    for (int y = on_y.first; y <= on_y.last; ++y) {
        const double of_row = even * rows.overlap(y, y + 1);
        for (int x = on_x.first; x <= on_x.last; ++x) press(x, y, of_row * columns.overlap(x, x + 1));
    }
    if (columns.cells.empty() || rows.cells.empty()) return 0;
    return columns.overlap(0, pad.width) / columns.size() * (rows.overlap(0, pad.height) / rows.size());
}

} // namespace

ContactReport add_taxels(const Pad& pad, const TaxelReadings& t) {
    const DefaultFloats guard;
    check(pad);
    check_taxels(t);
    t.values.visit([&](const auto* first) {
        need_apart("taxels.values", pad, first, first + place_of(t, t.columns - 1, t.rows - 1) + 1);
    });
    const bool newtons = t.unit == TaxelReadings::Unit::newton;
    const double to_force = newtons ? 1 : t.width * t.height;
    double asked = 0;
    for (int j = 0; j < t.rows; ++j)
        for (int i = 0; i < t.columns; ++i) {
            const double value = t.values[place_of(t, i, j)];
            if (!finite(value) || value < 0 || (!newtons && value > 3.4e38))
                scene::refuse("taxels.values[" + std::to_string(place_of(t, i, j)) + "]", shortest(value),
                              newtons ? "a finite number >= 0" : "0..3.4e38");
            asked += value * to_force;
        }
    if (newtons) need_float_pressure(pad, asked);

    // Neighbouring taxels have exactly the same border.
    const auto interval_of = [&](double start, double size, int i, int count) {
        return interval((start + i * size) / pad.spacing, (start + (i + 1) * size) / pad.spacing, count);
    };
    const double most = (std::ceil(pad.spacing / t.width) + 1) * (std::ceil(pad.spacing / t.height) + 1);
    const double to_pressure = to_force / (pad.spacing * pad.spacing);
    return press_cells(pad, most, [&](const Tile& tile, const CellPress& press, ContactReport& report) {
        const CellSpan along_x = taxels_of(tile, tile.columns, pad.spacing, t.x, t.width, t.columns);
        const CellSpan along_y = taxels_of(tile, tile.rows, pad.spacing, t.y, t.height, t.rows);
        for (int j = along_y.first; j <= along_y.last; ++j) {
            const Interval rows = interval_of(t.y, t.height, j, pad.height);
            for (int i = along_x.first; i <= along_x.last; ++i) {
                const double value = t.values[place_of(t, i, j)];
                if (!(value > 0 && value * to_force <= asked)) continue; // the caller's memory may change
                const Interval columns = interval_of(t.x, t.width, i, pad.width);
                const double part = press_area(pad, columns, rows, value * to_pressure, tile, press);
                const double own = pad.tiled ? part : 1; // the rest is the neighbours', as in add()
                report.beside += own > 0 && part == 0;
                report.asked += own * (value * to_force);
                report.outside += (own - part) * (value * to_force);
            }
        }
    });
}

} // namespace dermis::contact
