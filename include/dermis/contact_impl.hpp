// SPDX-License-Identifier: MIT
// How contacts become pressure. What users need to know stands in contact.hpp, which includes this header.
#pragma once

#include <dermis/contact.hpp>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace dermis::contact {

namespace detail {

inline constexpr double greatest_length = 1e6;
inline constexpr int greatest_count = 16384;
inline constexpr double pi = 3.14159265358979323846;

// These test the bits of the exponent, so that no compiler flag about NaN and infinity changes the result.
inline bool finite(double x) {
    std::uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    return (bits >> 52 & 0x7ff) != 0x7ff;
}
inline bool finite(float x) {
    std::uint32_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    return (bits >> 23 & 0xff) != 0xff;
}

inline std::string text(double x) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.9g", x);
    return digits;
}

[[noreturn]] inline void refuse(const std::string& name, const std::string& value, const std::string& allowed) {
    throw std::invalid_argument(name + " = " + value + "; allowed: " + allowed);
}
inline void need_within(const char* name, double value, double low, double high) {
    if (!finite(value) || value < low || value > high) refuse(name, text(value), (text(low) + ".." + text(high)));
}
inline void need_at_least_0(const char* name, double value) {
    if (!finite(value) || value < 0) refuse(name, text(value), "a finite number >= 0");
}
inline void need_positive(const char* name, double value) {
    if (!finite(value) || value <= 0) refuse(name, text(value), "a finite number > 0");
}
inline void need_memory(const char* name, const void* memory) {
    if (!memory) refuse(name, "null", "an address");
}
inline void need_pitch(const char* name, std::size_t pitch, int width) {
    if (pitch != 0 && pitch < std::size_t(width))
        refuse(name, std::to_string(pitch), ("0, or >= " + std::to_string(width) + ", the pad's width"));
}

inline void check(const Pad& pad) {
    need_within("pad.width", pad.width, 1, greatest_count);
    need_within("pad.height", pad.height, 1, greatest_count);
    need_within("pad.spacing", pad.spacing, 1e-9, greatest_length);
    need_memory("pad.pressure", pad.pressure);
    need_pitch("pad.pitch", pad.pitch, pad.width);
}

// Refuses a force which would, all on one cell, be more than a float can hold.
inline void need_float_pressure(const Pad& pad, double force) {
    const double pressure = force / (pad.spacing * pad.spacing);
    if (!(pressure <= double(FLT_MAX)))
        refuse("force/spacing^2", text(pressure), "at most 3.4e38 Pa, the greatest float");
}

// The name of a contact's number, which is only made where the number is refused.
inline std::string of_contact(std::size_t i, const char* member) {
    return "contacts[" + std::to_string(i) + "]" + member;
}

// Checks the numbers that a Contact and a WorldContact have in common.
template <class AnyContact> void check_patch(const AnyContact& c, std::size_t i) {
    const auto need_size = [&](const char* member, double value, double high, const char* allowed) {
        if (!finite(value) || value < 0 || value > high) refuse(of_contact(i, member), text(value), allowed);
    };
    need_size(".force", c.force, DBL_MAX, "a finite number >= 0");
    need_size(".radius", c.radius, greatest_length, "0..1e6");
    need_size(".area", c.area, greatest_length * greatest_length, "0..1e12");
    if (c.radius > 0 && c.area > 0) refuse(of_contact(i, ".area"), text(c.area), "0 beside a radius > 0");
}

inline void check_length(const char* member, double value, std::size_t i) {
    if (!finite(value) || std::abs(value) > greatest_length) refuse(of_contact(i, member), text(value), "-1e6..1e6");
}

inline float* row_of(const Pad& pad, int y) {
    return pad.pressure + std::size_t(y) * (pad.pitch ? pad.pitch : std::size_t(pad.width));
}

inline void press(float& cell, double pressure, Report& report) {
    const float before = cell;
    cell = float(double(before) + pressure);
    report.cells += before == 0 && cell != 0;
    report.greatest = std::max(report.greatest, double(cell));
}

// Cells first..last along one axis.
struct Range {
    int first, last;
};

// Returns the cells of `all` at low..high. The limits stay double until they are small enough for an int.
inline Range within(double low, double high, Range all) {
    return {int(std::ceil(std::clamp(low, double(all.first), double(all.last) + 1))),
            int(std::floor(std::clamp(high, double(all.first) - 1, double(all.last))))};
}

// A patch in units of cells: the centre of cell (x, y) is (x, y).
struct Disc {
    double x, y, radius;
};

// Neighbouring cells of a row of a disc: count of them from (x, y) on. rest is 1 - dy^2/radius^2.
struct Piece {
    static constexpr int longest = 256;
    int x, y, count;
    double rest;
};

// Calls each(piece) for each of these cells whose centre the disc covers, row by row.
template <class Each> void each_piece(const Disc& disc, Range columns, Range rows, Each each) {
    if (disc.radius < 1e-6) return; // It covers none, but for a centre that it is in, which is the nearest.
    const double scale = 1 / disc.radius;
    rows = within(disc.y - disc.radius, disc.y + disc.radius, rows);
    for (int y = rows.first; y <= rows.last; ++y) {
        const double dy = (y - disc.y) * scale, rest = 1 - dy * dy;
        if (rest <= 0) continue;
        const double half = disc.radius * std::sqrt(rest);
        const Range covered = within(disc.x - half, disc.x + half, columns);
        for (int x = covered.first; x <= covered.last; x += Piece::longest)
            each(Piece{x, y, std::min(Piece::longest, covered.last + 1 - x), rest});
    }
}

// Calls each(x, lane) for 0..n-1. Four lanes run side by side, because an addition takes longer than what is added.
template <class Each> void each_in_lanes(int n, Each each) {
    int x = 0;
    for (; x + 4 <= n; x += 4) each(x, 0), each(x + 1, 1), each(x + 2, 2), each(x + 3, 3);
    for (; x < n; ++x) each(x, 0);
}

// Weights by Hertz's profile of the cells of a disc. They are kept as far as there is room, because roots are what
// takes time.
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
    // Returns the weights of a piece before which there were `before` cells.
    const float* of(const Disc& disc, const Piece& piece, int before) {
        const bool fits = before + piece.count <= room, made = before < used_;
        float* weights = fits ? kept_ + before : kept_ + room;
        if (fits && made) return weights;
        const double scale = 1 / disc.radius;
        for (int i = 0; i < piece.count; ++i) {
            const double dx = (piece.x + i - disc.x) * scale, square = piece.rest - dx * dx;
            weights[i] = std::sqrt(std::max(float(square), 0.0f));
        }
        return weights;
    }

  private:
    static constexpr int room = 2048;
    int used_ = 0;
    float kept_[room + Piece::longest];
};

// Adds the weights that a disc which overhangs has beyond the border.
inline void add_beyond(const Disc& disc, Range columns, Range rows, double& sum, int& cells) {
    if (disc.radius > 128) { // the integral, which differs from the sum by less than 1e-4 of it
        sum = std::max(sum, 2 * pi / 3 * disc.radius * disc.radius);
        ++cells;
        return;
    }
    constexpr int far_away = 2 * greatest_count;
    Weights beyond;
    const auto add = [&](Range some_columns, Range some_rows) {
        each_piece(disc, some_columns, some_rows, [&](const Piece& piece) { beyond.add(disc, piece); });
    };
    add({-far_away, far_away}, {-far_away, -1});
    add({-far_away, far_away}, {rows.last + 1, far_away});
    add({-far_away, -1}, rows);
    add({columns.last + 1, far_away}, rows);
    sum += beyond.sum;
    cells += beyond.cells;
}

// Presses a patch of which the pad has no covered centre: it has none at all, or all of them are beside the pad.
inline double press_nearest(const Pad& pad, const Disc& disc, double force, Report& report) {
    const double x = std::floor(disc.x + 0.5), y = std::floor(disc.y + 0.5);
    if (x < 0 || x >= pad.width || y < 0 || y >= pad.height) {
        ++report.beside;
        return 0;
    }
    ++report.below_cell;
    press(row_of(pad, int(y))[int(x)], force / (pad.spacing * pad.spacing), report);
    return force;
}

// Returns the part of the force that falls on the pad.
inline double spread(const Pad& pad, const Contact& c, Report& report) {
    const double radius = c.area > 0 ? std::sqrt(c.area / pi) : c.radius;
    const Disc disc{c.x / pad.spacing - 0.5, c.y / pad.spacing - 0.5, radius / pad.spacing};
    const Range columns{0, pad.width - 1}, rows{0, pad.height - 1};
    Weights weights;
    each_piece(disc, columns, rows, [&](const Piece& piece) { weights.add(disc, piece); });
    if (weights.cells == 0) return press_nearest(pad, disc, c.force, report);

    double whole = weights.sum;
    int cells = weights.cells;
    const bool inside = disc.x - disc.radius > -1 && disc.x + disc.radius < pad.width && disc.y - disc.radius > -1 &&
                        disc.y + disc.radius < pad.height;
    if (!inside) add_beyond(disc, columns, rows, whole, cells);
    report.below_cell += cells == 1;
    const double peak = c.force / (pad.spacing * pad.spacing * whole);
    int before = 0;
    each_piece(disc, columns, rows, [&](const Piece& piece) {
        const float* weight = weights.of(disc, piece, before);
        float* row = row_of(pad, piece.y) + piece.x;
        for (int i = 0; i < piece.count; ++i) press(row[i], peak * double(weight[i]), report);
        before += piece.count;
    });
    return c.force * (weights.sum / whole);
}

inline void add(const Pad& pad, const Contact& c, Report& report) {
    if (c.force == 0) return;
    const double placed = spread(pad, c, report);
    report.placed += placed;
    report.outside += c.force - placed;
}

// Adds contacts, one after another, to a pad that is checked, once all of them are. contact_at returns the one at an
// index.
template <class ContactAt> Report add_each(const Pad& pad, std::size_t count, const ContactAt& contact_at) {
    Report report;
    for (std::size_t i = 0; i < count; ++i) {
        const Contact& c = contact_at(i);
        check_patch(c, i);
        check_length(".x", c.x, i);
        check_length(".y", c.y, i);
        report.asked += c.force;
    }
    need_float_pressure(pad, report.asked);
    for (std::size_t i = 0; i < count; ++i) add(pad, contact_at(i), report);
    return report;
}

inline void check(const Pose& pose) {
    for (double p : pose.position) need_within("pose.position", p, -greatest_length, greatest_length);
    const std::array<double, 9>& r = pose.rotation;
    for (double v : r) need_within("pose.rotation", v, -1.001, 1.001);
    double worst = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double product = 0;
            for (int k = 0; k < 3; ++k) product += r[std::size_t(3 * k + i)] * r[std::size_t(3 * k + j)];
            worst = std::max(worst, std::abs(product - (i == j)));
        }
    if (worst > 1e-3)
        refuse("pose.rotation", "a matrix whose columns' products are off by " + text(worst), "up to 1e-3");
    const double determinant =
        r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) + r[2] * (r[3] * r[7] - r[4] * r[6]);
    if (determinant < 0)
        refuse("pose.rotation", "a matrix of determinant " + text(determinant), "a rotation: determinant 1");
}

inline void check(const WorldContact& c, std::size_t i) {
    check_patch(c, i);
    for (double p : c.position) check_length(".position", p, i);
    for (double d : c.direction) check_length(".direction", d, i);
}

// Returns the components of a vector of the world in the pad's frame.
inline std::array<double, 3> turned(const Pose& pose, const std::array<double, 3>& v) {
    const std::array<double, 9>& r = pose.rotation;
    return {r[0] * v[0] + r[3] * v[1] + r[6] * v[2], r[1] * v[0] + r[4] * v[1] + r[7] * v[2],
            r[2] * v[0] + r[5] * v[1] + r[8] * v[2]};
}

inline void add(const Pad& pad, const Pose& pose, double reach, const WorldContact& c, Report& report) {
    if (c.force == 0) return;
    std::array<double, 3> place;
    for (std::size_t k = 0; k < 3; ++k) place[k] = c.position[k] - pose.position[k];
    place = turned(pose, place);
    const std::array<double, 3>& d = c.direction;
    const double length = std::hypot(d[0], d[1], d[2]);
    const double inward = length == 0 ? 1 : std::min(1.0, -turned(pose, d)[2] / length);
    const bool distant = std::abs(place[2]) > reach, away = inward <= 0;
    if (distant || away) {
        report.too_far += distant;
        report.turned_away += !distant && away;
        report.outside += c.force;
        return;
    }
    Contact local;
    local.x = place[0], local.y = place[1];
    local.force = c.force * inward;
    local.radius = c.radius, local.area = c.area;
    report.sideways += c.force - local.force;
    add(pad, local, report);
}

// The same for contacts of the world.
template <class ContactAt>
Report add_each(const Pad& pad, const Pose& pose, double reach, std::size_t count, const ContactAt& contact_at) {
    check(pose);
    need_at_least_0("reach", reach);
    Report report;
    for (std::size_t i = 0; i < count; ++i) {
        const WorldContact& c = contact_at(i);
        check(c, i);
        report.asked += c.force;
    }
    need_float_pressure(pad, report.asked);
    for (std::size_t i = 0; i < count; ++i) add(pad, pose, reach, contact_at(i), report);
    return report;
}

// What depths above a level sum up to. The depths count from a reference.
struct Excess {
    double sum = 0;         // of the depths above the level
    std::int64_t cells = 0; // as many are above it
};

inline const float* row_of(const Pad& pad, const Depths& d, int y) {
    return d.depth + std::size_t(y) * (d.pitch ? d.pitch : std::size_t(pad.width));
}

inline Excess above(const Pad& pad, const Depths& d, double reference, double level) {
    double sums[4] = {0, 0, 0, 0};
    std::int64_t cells[4] = {0, 0, 0, 0};
    for (int y = 0; y < pad.height; ++y) {
        const float* row = row_of(pad, d, y);
        each_in_lanes(pad.width, [&](int x, int lane) {
            const double depth = double(row[x]) - reference;
            const bool counts = depth > level;
            sums[lane] += counts ? depth : 0.0;
            cells[lane] += counts;
        });
    }
    return {(sums[0] + sums[1]) + (sums[2] + sums[3]), cells[0] + cells[1] + cells[2] + cells[3]};
}

// Returns the greatest depth, and refuses one that is not finite. The first loop has no early exit.
inline double checked_depths(const Pad& pad, const Depths& d) {
    float greatest[4] = {-FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX};
    for (int y = 0; y < pad.height; ++y) {
        const float* row = row_of(pad, d, y);
        bool all_finite = true;
        each_in_lanes(pad.width, [&](int x, int lane) {
            all_finite &= finite(row[x]);
            greatest[lane] = row[x] > greatest[lane] ? row[x] : greatest[lane];
        });
        for (int x = 0; x < pad.width && !all_finite; ++x)
            if (!finite(row[x]))
                refuse("depths.depth[" + std::to_string(x) + ", " + std::to_string(y) + "]", text(double(row[x])),
                       "a finite number");
    }
    return double(*std::max_element(greatest, greatest + 4));
}

// Returns the level, from a reference, above which the depths sum up to `target`, by Newton's method. That sum is
// convex and piecewise linear in the level. Each step takes the cells above a level for all that count, and so never
// goes too high, whichever level it starts from; from then on cells are only dropped, until none is.
inline double level_of(const Pad& pad, const Depths& d, double reference, double target) {
    Excess active = above(pad, d, reference, reference > 0 ? -reference : -DBL_MAX); // what the depths say
    for (;;) {
        const double level = (active.sum - target) / double(active.cells);
        const Excess next = above(pad, d, reference, level);
        if (next.cells == active.cells) return level;
        active = next;
    }
}

inline void check(const Taxels& t) {
    need_memory("taxels.values", t.values);
    need_within("taxels.columns", t.columns, 1, greatest_count);
    need_within("taxels.rows", t.rows, 1, greatest_count);
    need_within("taxels.width", t.width, 1e-9, greatest_length);
    need_within("taxels.height", t.height, 1e-9, greatest_length);
    need_within("taxels.x", t.x, -greatest_length, greatest_length);
    need_within("taxels.y", t.y, -greatest_length, greatest_length);
    if (t.column_step == 0) refuse("taxels.column_step", "0", ">= 1");
}

inline std::size_t place_of(const Taxels& t, int i, int j) {
    return std::size_t(i) * t.column_step + std::size_t(j) * (t.row_step ? t.row_step : std::size_t(t.columns));
}

// An interval in units of cells, and the cells that it overlaps by more than what rounding makes of a common border.
struct Interval {
    double low, high;
    Range cells;
    double overlap(double from, double to) const { return std::max(0.0, std::min(high, to) - std::max(low, from)); }
};

inline Interval interval(double low, double high, int count) {
    const double least = 1e-9 * std::min(1.0, high - low);
    return {low, high, within(std::floor(low + least), std::ceil(high - least) - 1, {0, count - 1})};
}

// Adds a taxel and returns the part of its area that is on the pad.
inline double press_area(const Pad& pad, const Interval& columns, const Interval& rows, double pressure,
                         Report& report) {
    for (int y = rows.cells.first; y <= rows.cells.last; ++y) {
        const double of_row = pressure * rows.overlap(y, y + 1);
        for (int x = columns.cells.first; x <= columns.cells.last; ++x)
            press(row_of(pad, y)[x], of_row * columns.overlap(x, x + 1), report);
    }
    return columns.overlap(0, pad.width) / (columns.high - columns.low) * rows.overlap(0, pad.height) /
           (rows.high - rows.low);
}

} // namespace detail

inline std::string Report::doubts() const {
    std::string sentences;
    if (below_cell > 0)
        sentences += std::to_string(below_cell) + (below_cell == 1 ? " patch presses" : " patches press") +
                     " one cell alone: the pressure is force/spacing^2, whatever the radius. ";
    if (greatest > doubtful_pressure)
        sentences += "The greatest pressure is " + detail::text(greatest) + " Pa, above " +
                     detail::text(doubtful_pressure) + " Pa; touch and grasp press skin with 1e3 to 1e5 Pa. ";
    if (!sentences.empty()) sentences += "Are radius and spacing in m, and forces in N?";
    return sentences;
}

inline Report add_contacts(const Pad& pad, const Contact* contacts, std::size_t count) {
    detail::check(pad);
    if (count > 0) detail::need_memory("contacts", contacts);
    return detail::add_each(pad, count, [contacts](std::size_t i) -> const Contact& { return contacts[i]; });
}

inline Report add_contacts(const Pad& pad, const std::vector<Contact>& contacts) {
    return add_contacts(pad, contacts.data(), contacts.size());
}

inline double hertz_radius(double force, double ball, double modulus) {
    detail::need_at_least_0("force", force);
    detail::need_positive("ball", ball);
    detail::need_positive("modulus", modulus);
    return std::cbrt(0.75 * force * ball / modulus);
}

inline Pose Pose::from_matrix(const double position[3], const double rotation[9]) {
    detail::need_memory("position", position);
    detail::need_memory("rotation", rotation);
    Pose pose;
    std::copy_n(position, 3, pose.position.begin());
    std::copy_n(rotation, 9, pose.rotation.begin());
    return pose;
}

inline Pose Pose::from_quaternion(const double position[3], const double quaternion[4]) {
    detail::need_memory("position", position);
    detail::need_memory("quaternion", quaternion);
    const double square = quaternion[0] * quaternion[0] + quaternion[1] * quaternion[1] +
                          quaternion[2] * quaternion[2] + quaternion[3] * quaternion[3];
    detail::need_positive("|quaternion|^2", square);
    const double scale = 1 / std::sqrt(square);
    const double w = scale * quaternion[0], x = scale * quaternion[1], y = scale * quaternion[2],
                 z = scale * quaternion[3];
    Pose pose;
    std::copy_n(position, 3, pose.position.begin());
    pose.rotation = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                     2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                     2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    return pose;
}

inline Pose Pose::from_middle(const Pad& pad) const {
    const double x = -0.5 * pad.width * pad.spacing, y = -0.5 * pad.height * pad.spacing;
    Pose corner = *this;
    for (std::size_t k = 0; k < 3; ++k) corner.position[k] += rotation[3 * k] * x + rotation[3 * k + 1] * y;
    return corner;
}

inline Report add_contacts(const Pad& pad, const Pose& pose, double reach, const WorldContact* contacts,
                           std::size_t count) {
    detail::check(pad);
    if (count > 0) detail::need_memory("contacts", contacts);
    return detail::add_each(pad, pose, reach, count,
                            [contacts](std::size_t i) -> const WorldContact& { return contacts[i]; });
}

inline Report add_contacts(const Pad& pad, const Pose& pose, double reach, const std::vector<WorldContact>& contacts) {
    return add_contacts(pad, pose, reach, contacts.data(), contacts.size());
}

inline Report add_depths(const Pad& pad, const Depths& d) {
    detail::check(pad);
    detail::need_memory("depths.depth", d.depth);
    detail::need_pitch("depths.pitch", d.pitch, pad.width);
    detail::need_at_least_0("depths.force", d.force);
    if (d.stiffness != 0) detail::need_within("depths.stiffness", d.stiffness, 1e-6, 1e30);
    detail::need_float_pressure(pad, d.force);
    const double greatest = detail::checked_depths(pad, d);

    Report report;
    report.asked = d.force;
    if (d.force == 0) return report;
    // Depths count from the greatest where a level is looked for: so little is lost to rounding.
    double reference = 0, level = 0;
    const double area = pad.spacing * pad.spacing;
    if (d.stiffness != 0) {
        reference = greatest;
        level = detail::level_of(pad, d, reference, std::max(d.force / (d.stiffness * area), 1e-290));
        report.level = reference + level;
    }
    const detail::Excess excess = detail::above(pad, d, reference, level);
    if (excess.cells == 0) {
        report.outside = d.force;
        return report;
    }
    const double scale = d.force / ((excess.sum - double(excess.cells) * level) * area);
    for (int y = 0; y < pad.height; ++y) {
        const float* depth = detail::row_of(pad, d, y);
        float* pressure = detail::row_of(pad, y);
        for (int x = 0; x < pad.width; ++x) {
            const double sunk = double(depth[x]) - reference - level;
            if (sunk > 0) detail::press(pressure[x], scale * sunk, report);
        }
    }
    report.placed = d.force;
    return report;
}

inline Report add_taxels(const Pad& pad, const Taxels& t) {
    detail::check(pad);
    detail::check(t);
    const double to_force = t.unit == Taxels::Unit::newton ? 1 : t.width * t.height;
    Report report;
    for (int j = 0; j < t.rows; ++j)
        for (int i = 0; i < t.columns; ++i) {
            const float value = t.values[detail::place_of(t, i, j)];
            if (!detail::finite(value) || value < 0)
                detail::refuse(("taxels.values[" + std::to_string(detail::place_of(t, i, j)) + "]"),
                               detail::text(double(value)), "a finite number >= 0");
            report.asked += double(value) * to_force;
        }
    if (t.unit == Taxels::Unit::newton) detail::need_float_pressure(pad, report.asked);

    // Neighbours have the same border, to the last digit.
    const auto interval = [&](double start, double size, int i, int count) {
        return detail::interval((start + i * size) / pad.spacing, (start + (i + 1) * size) / pad.spacing, count);
    };
    for (int j = 0; j < t.rows; ++j) {
        const detail::Interval rows = interval(t.y, t.height, j, pad.height);
        for (int i = 0; i < t.columns; ++i) {
            const double force = double(t.values[detail::place_of(t, i, j)]) * to_force;
            if (force == 0) continue;
            const detail::Interval columns = interval(t.x, t.width, i, pad.width);
            const double part = detail::press_area(pad, columns, rows, force / (t.width * t.height), report);
            report.beside += part == 0;
            report.placed += part * force;
            report.outside += (1 - part) * force;
        }
    }
    return report;
}

} // namespace dermis::contact
