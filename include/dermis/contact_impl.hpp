// SPDX-License-Identifier: MIT
// How contacts, depths and taxels become pressure: what is refused, and where forces go. What users need to know stands
// in contact.hpp, which includes this header.
#pragma once

#include <dermis/contact_cells.hpp>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <functional>
#include <stdexcept>

namespace dermis::contact {

namespace detail {

inline constexpr double greatest_length = 1e6;

// Both test the bits of the exponent, so that a compiler flag such as -ffast-math does not change the result.
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
    const auto need_radius = [&](const char* name, double radius, int cells) {
        const double least = cells * pad.spacing / (2 * pi);
        if (radius != 0 && !(finite(radius) && radius >= least && radius <= greatest_length))
            refuse(name, text(radius), "0, or " + text(least) + "..1e6");
    };
    need_radius("pad.radius_x", pad.radius_x, pad.width);
    need_radius("pad.radius_y", pad.radius_y, pad.height);
}

// Refuses a force which would, all on one cell, be more than a float can hold.
inline void need_float_pressure(const Pad& pad, double force) {
    const double pressure = force / (pad.spacing * pad.spacing);
    if (!(pressure <= double(FLT_MAX)))
        refuse("force/spacing^2", text(pressure), "at most 3.4e38 Pa, the greatest float");
}

// The name of a member of contacts[i] for a message. It is made only for a message, because it allocates.
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

// Where a contact meets a pad: its patch, whose force is the component into the pad; and the force's components along x
// and y of the pad, N, 0 of a contact that is no contact in the world.
struct Landing {
    Contact patch;
    double along_x = 0, along_y = 0;
};

// The patch of a contact, in units of cells.
inline Disc disc_of(const Pad& pad, const Contact& c) {
    const double radius = c.area > 0 ? std::sqrt(c.area / pi) : c.radius;
    return disc_of(c.x / pad.spacing - 0.5, c.y / pad.spacing - 0.5, radius / pad.spacing);
}

// Adds a contact with a force > 0. whole: the whole force, N.
template <class Press>
void add(const Pad& pad, const Landing& l, double whole, const Tile& tile, const Press& press, Report& report) {
    const Contact& c = l.patch;
    // A component into the pad may be too small for a double.
    const auto of_pressure = [&](double along) { return c.force > 0 ? along / c.force : 0; };
    const double share = spread(pad, disc_of(pad, c), c.force / (pad.spacing * pad.spacing), tile,
                                press.dragging(of_pressure(l.along_x), of_pressure(l.along_y)), report);
    const double own = pad.tiled ? share : 1; // the rest is asked of the neighbours
    report.asked += own * whole;
    report.outside += (own - share) * c.force;
    report.sideways += own * (whole - c.force);
    report.shear[0] += share * l.along_x;
    report.shear[1] += share * l.along_y;
}

// Checks all contacts, then adds them. The pad has been checked. contact_at(i) returns contact i.
template <class ContactAt> Report add_each(const Pad& pad, std::size_t count, const ContactAt& contact_at) {
    double asked = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Contact& c = contact_at(i);
        check_patch(c, i);
        check_length(".x", c.x, i);
        check_length(".y", c.y, i);
        asked += c.force;
    }
    need_float_pressure(pad, asked);
    return press_cells(pad, double(count), [&](const Tile& tile, const auto& press, Report& report) {
        for (std::size_t i = 0; i < count; ++i) {
            const Contact& c = contact_at(i);
            if (c.force > 0) add(pad, Landing{c}, c.force, tile, press, report);
        }
    });
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

// The place of a pad's surface that is nearest to a point, as x and y of a Contact; how far the point is above it; and
// the surface's axes there: along x and y of the pad, and outwards.
struct Foot {
    double x, y, above;
    std::array<double, 3> along_x, along_y, normal;
};

// p: the point in the pad's frame.
inline Foot foot_of(const Pad& pad, const std::array<double, 3>& p) {
    const double rx = pad.radius_x, ry = pad.radius_y;
    if (rx == 0 && ry == 0) return {p[0], p[1], p[2], {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double middle_x = 0.5 * pad.width * pad.spacing, middle_y = 0.5 * pad.height * pad.spacing;
    const double x = p[0] - middle_x, y = p[1] - middle_y;
    if (rx == ry) { // a ball
        const double z = p[2] + rx, off = std::hypot(x, y), far = std::hypot(off, z);
        const double arc = rx * std::atan2(off, z);
        const double u = off == 0 ? 1 : x / off, v = off == 0 ? 0 : y / off; // the opposite pole lies along x
        const double cosine = z / far, sine = off / far;
        const double bent = cosine - 1; // an axis leans by it towards the bearing (u, v)
        return {middle_x + arc * u,
                middle_y + arc * v,
                far - rx,
                {1 + u * u * bent, u * v * bent, -u * sine},
                {u * v * bent, 1 + v * v * bent, -v * sine},
                {u * sine, v * sine, cosine}};
    }
    // First about the axis along x, then along the arc.
    const double about = ry == 0 ? 0 : std::atan2(y, p[2] + ry);
    const double up = ry == 0 ? p[2] : std::hypot(y, p[2] + ry) - ry;
    const double along = rx == 0 ? 0 : std::atan2(x, up + rx);
    const double sa = std::sin(along), ca = std::cos(along), sb = std::sin(about), cb = std::cos(about);
    return {middle_x + (rx == 0 ? x : rx * along),
            middle_y + (ry == 0 ? y : ry * about),
            rx == 0 ? up : std::hypot(x, up + rx) - rx,
            {ca, -sa * sb, -sa * cb},
            {0, cb, -sb},
            {sa, ca * sb, ca * cb}};
}

inline double dot(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Finds where a contact in the world with a force > 0 lands. Returns false, and counts its force as outside, where it
// is too far from the pad or pushes away from it.
inline bool land(const Pad& pad, const Pose& pose, double reach, const WorldContact& c, Landing& to, Report& report) {
    std::array<double, 3> place;
    for (std::size_t k = 0; k < 3; ++k) place[k] = c.position[k] - pose.position[k];
    const Foot foot = foot_of(pad, turned(pose, place));
    const double length = std::hypot(c.direction[0], c.direction[1], c.direction[2]);
    const std::array<double, 3> d = turned(pose, c.direction);
    const double inward = length == 0 ? 1 : std::min(1.0, -dot(d, foot.normal) / length);
    const bool distant = std::abs(foot.above) > reach, away = inward <= 0;
    if (distant || away) {
        report.too_far += distant;
        report.turned_away += !distant && away;
        report.asked += c.force;
        report.outside += c.force;
        return false;
    }
    to.patch.x = foot.x, to.patch.y = foot.y;
    to.patch.force = c.force * inward;
    to.patch.radius = c.radius, to.patch.area = c.area;
    const double size = length == 0 ? 0 : c.force / length;
    to.along_x = size * dot(d, foot.along_x), to.along_y = size * dot(d, foot.along_y);
    return true;
}

inline void check_reach(const Pad& pad, double reach) {
    need_at_least_0("reach", reach);
    for (double radius : {pad.radius_x, pad.radius_y})
        if (radius != 0 && reach >= radius) refuse("reach", text(reach), "below the pad's radius of " + text(radius));
}

// The same for contacts in the world.
template <class ContactAt>
Report add_each(const Pad& pad, const Pose& pose, double reach, std::size_t count, const ContactAt& contact_at) {
    check(pose);
    check_reach(pad, reach);
    double asked = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const WorldContact& c = contact_at(i);
        check(c, i);
        asked += c.force;
    }
    need_float_pressure(pad, asked);
    return press_cells(pad, double(count), [&](const Tile& tile, const auto& press, Report& report) {
        for (std::size_t i = 0; i < count; ++i) {
            const WorldContact& c = contact_at(i);
            Landing landing;
            if (c.force > 0 && land(pad, pose, reach, c, landing, report))
                add(pad, landing, c.force, tile, press, report);
        }
    });
}

// Refuses floats that stand in the pad's memory, because they are read while that is written. count: floats from the
// first to the last one that is read.
inline void need_apart(const char* parameter, const Pad& pad, const float* first, std::size_t count) {
    const std::size_t all = row_at(pad, pad.height - 1) + std::size_t(pad.width);
    const std::less<const float*> before;
    for (const float* map : {pad.pressure, pad.shear_x, pad.shear_y})
        if (map && before(first, map + all) && before(map, first + count))
            refuse(parameter, "memory of the pad", "memory beside the pad's pressure, shear_x and shear_y");
}

// The depths above a level. Depths are relative to a reference.
struct Excess {
    double sum = 0;         // m: of these depths
    std::int64_t cells = 0; // number of these depths
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

// Returns the greatest depth. Refuses a depth that is not finite. The first loop has no early exit, so that it is fast.
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

// Returns the level, relative to a reference, above which the depths sum up to `target`, by Newton's method. This sum
// is a convex and piecewise linear function of the level. Each step assumes that all cells above the last level count,
// and so never goes too high, whichever level it starts from; from the second step on cells only drop out, until none
// does.
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

// An interval in units of cells, and the cells that it overlaps. An overlap that rounding makes at a common border does
// not count.
struct Interval {
    double low, high;
    CellSpan cells;
    double size() const { return high - low; }
    double overlap(double from, double to) const { return std::max(0.0, std::min(high, to) - std::max(low, from)); }
};

inline Interval interval(double low, double high, int count) {
    const double least = 1e-9 * std::min(1.0, high - low);
    return {low, high, within(std::floor(low + least), std::ceil(high - least) - 1, {0, count - 1})};
}

// Returns the taxels of a row or column that a tile needs. The first tile needs all, because it counts them; others
// need the taxels around their cells.
inline CellSpan taxels_of(const Tile& tile, CellSpan cells, double spacing, double start, double size, int count) {
    const CellSpan all{0, count - 1};
    if (tile.first) return all;
    return within((cells.first * spacing - start) / size - 2, ((cells.last + 1) * spacing - start) / size + 2, all);
}

// Presses the cells of a tile that a taxel overlaps, and returns the share of the taxel's area that is on the pad.
// pressure: force/spacing^2, Pa.
template <class Press>
double press_area(const Pad& pad, const Interval& columns, const Interval& rows, double pressure, const Tile& tile,
                  const Press& press) {
    const CellSpan on_x = common(columns.cells, tile.columns), on_y = common(rows.cells, tile.rows);
    const double even = pressure / (columns.size() * rows.size());
    for (int y = on_y.first; y <= on_y.last; ++y) {
        const double of_row = even * rows.overlap(y, y + 1);
        for (int x = on_x.first; x <= on_x.last; ++x) press(x, y, of_row * columns.overlap(x, x + 1));
    }
    return columns.overlap(0, pad.width) / columns.size() * (rows.overlap(0, pad.height) / rows.size());
}

// Returns a sentence that says where the force went, in shares of what was asked.
inline std::string whereabouts(const Report& r) {
    const auto share = [&](double force) {
        char digits[32];
        std::snprintf(digits, sizeof digits, "%.2f", force / r.asked);
        return std::string(digits);
    };
    const double rounded = r.asked - r.placed - r.outside - r.sideways;
    std::string sentence = share(r.placed) + " of the force presses the pad";
    if (r.sideways > 0) sentence += ", " + share(r.sideways) + " is sideways (a round body?)";
    if (std::abs(rounded) > 1e-3 * r.asked) sentence += ", " + share(std::abs(rounded)) + " is lost to rounding";
    if (r.outside > 0) {
        std::string causes;
        const auto count = [&](int patches, const char* cause) {
            if (patches > 0) causes += ", " + std::to_string(patches) + cause;
        };
        count(r.beside, " beside");
        count(r.too_far, " too far");
        count(r.turned_away, " turned away");
        if (r.placed > 0) causes += causes.empty() ? ", over the border" : ", else over the border";
        if (causes.empty()) causes = ", nowhere deeper than 0";
        sentence += ", " + share(r.outside) + " is outside: " + causes.substr(2);
    }
    return sentence + ". ";
}

} // namespace detail

inline bool Report::keeps_force() const {
    const double rounded = asked - placed - outside - sideways;
    return outside <= 0.1 * asked && placed >= 0.5 * asked && std::abs(rounded) <= 1e-3 * asked;
}

inline std::string Report::doubts() const {
    std::string sentences;
    if (!keeps_force()) sentences += detail::whereabouts(*this);
    if (below_cell > 0)
        sentences += std::to_string(below_cell) + (below_cell == 1 ? " patch presses" : " patches press") +
                     " one cell alone: the pressure is force/spacing^2. ";
    if (greatest > doubtful_pressure)
        sentences += "The greatest pressure is " + detail::text(greatest) + " Pa, above " +
                     detail::text(doubtful_pressure) + " Pa; touch presses with 1e3 to 1e5 Pa. ";
    if (!sentences.empty()) sentences += "Are lengths in m, forces in N?";
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

inline double foundation_stiffness(double force, double ball, double modulus) {
    detail::need_positive("force", force);
    return 16 * modulus / (3 * detail::pi * hertz_radius(force, ball, modulus));
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
    detail::need_apart("depths.depth", pad, d.depth,
                       std::size_t(detail::row_of(pad, d, pad.height - 1) - d.depth) + std::size_t(pad.width));
    detail::need_at_least_0("depths.force", d.force);
    if (d.stiffness != 0) detail::need_within("depths.stiffness", d.stiffness, 1e-6, 1e30);
    detail::need_float_pressure(pad, d.force);
    const double greatest = detail::checked_depths(pad, d);

    Report report;
    report.asked = d.force;
    if (d.force == 0) return report;
    // Where a level is looked for, depths are relative to the greatest one, so that little is lost to rounding.
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
    detail::finish(pad, report);
    return report;
}

inline Report add_taxels(const Pad& pad, const Taxels& t) {
    detail::check(pad);
    detail::check(t);
    detail::need_apart("taxels.values", pad, t.values, detail::place_of(t, t.columns - 1, t.rows - 1) + 1);
    const double to_force = t.unit == Taxels::Unit::newton ? 1 : t.width * t.height;
    double asked = 0;
    for (int j = 0; j < t.rows; ++j)
        for (int i = 0; i < t.columns; ++i) {
            const float value = t.values[detail::place_of(t, i, j)];
            if (!detail::finite(value) || value < 0)
                detail::refuse(("taxels.values[" + std::to_string(detail::place_of(t, i, j)) + "]"),
                               detail::text(double(value)), "a finite number >= 0");
            asked += double(value) * to_force;
        }
    if (t.unit == Taxels::Unit::newton) detail::need_float_pressure(pad, asked);

    // Neighbouring taxels have exactly the same border.
    const auto interval = [&](double start, double size, int i, int count) {
        return detail::interval((start + i * size) / pad.spacing, (start + (i + 1) * size) / pad.spacing, count);
    };
    const double most = (std::ceil(pad.spacing / t.width) + 1) * (std::ceil(pad.spacing / t.height) + 1);
    const double to_pressure = to_force / (pad.spacing * pad.spacing);
    return detail::press_cells(pad, most, [&](const detail::Tile& tile, const auto& press, Report& report) {
        const detail::CellSpan along_x = detail::taxels_of(tile, tile.columns, pad.spacing, t.x, t.width, t.columns);
        const detail::CellSpan along_y = detail::taxels_of(tile, tile.rows, pad.spacing, t.y, t.height, t.rows);
        for (int j = along_y.first; j <= along_y.last; ++j) {
            const detail::Interval rows = interval(t.y, t.height, j, pad.height);
            for (int i = along_x.first; i <= along_x.last; ++i) {
                const double value = double(t.values[detail::place_of(t, i, j)]);
                if (!(value > 0 && value * to_force <= asked)) continue; // the caller's memory may change
                const detail::Interval columns = interval(t.x, t.width, i, pad.width);
                const double part = detail::press_area(pad, columns, rows, value * to_pressure, tile, press);
                const double own = pad.tiled ? part : 1; // the rest is the neighbours', as in add()
                report.beside += own > 0 && part == 0;
                report.asked += own * (value * to_force);
                report.outside += (own - part) * (value * to_force);
            }
        }
    });
}

} // namespace dermis::contact

#include <dermis/contact_body.hpp>
