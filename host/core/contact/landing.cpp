// SPDX-License-Identifier: MIT
#include "host/core/contact/landing.hpp"

#include <cfloat>
#include <numbers>

namespace dermis::contact {

using std::numbers::pi;

void need_memory(const char* name, bool given) {
    if (!given) scene::refuse(name, "null", "an address");
}

void need_pitch(const char* name, size_t pitch, int width) {
    if (pitch != 0 && (pitch < size_t(width) || pitch > size_t(1) << 40))
        scene::refuse(name, std::to_string(pitch), "0, or the pad's width = " + std::to_string(width) + " .. 2^40");
}

void need_apart(const char* name, const Pad& pad, const void* first, const void* end) {
    const size_t all = row_at(pad, pad.height - 1) + size_t(pad.width);
    const std::less<const void*> before;
    for (const float* map : {pad.pressure, pad.shear_x, pad.shear_y})
        if (map && before(first, map + all) && before(map, end))
            scene::refuse(name, "memory of the pad", "memory beside the pad's pressure, shear_x and shear_y");
}

void check(const Pad& pad) {
    need_within("pad.width", pad.width, 1, greatest_count, "1..16384");
    need_within("pad.height", pad.height, 1, greatest_count, "1..16384");
    need_within("pad.spacing", pad.spacing, 1e-9, greatest_length, "1e-9..1e6");
    need_memory("pad.pressure", pad.pressure != nullptr);
    need_pitch("pad.pitch", pad.pitch, pad.width);
    if (pad.keep && pad.tiled)
        scene::refuse("pad.keep", "true", "false beside pad.tiled: the neighbours carry the rest");
    const auto need_radius = [&](const char* name, double radius, int cells) {
        const double least = cells * pad.spacing / (2 * pi);
        if (radius != 0 && !(radius >= least && radius <= greatest_length))
            scene::refuse(name, shortest(radius), "0, or " + shortest(least) + "..1e6");
    };
    need_radius("pad.radius_x", pad.radius_x, pad.width);
    need_radius("pad.radius_y", pad.radius_y, pad.height);
}

std::string member_of(const char* list, const char* member, int number) {
    return list + ("." + (number < 0 ? std::string(member) : member + ("[" + std::to_string(number) + "]")));
}

void check(const Pose& pose, const char* list, int number) {
    const auto refuse = [&](const char* member, const std::string& value, const char* allowed) {
        scene::refuse(member_of(list, member, number), value, allowed);
    };
    for (double p : pose.position)
        if (!(std::abs(p) <= greatest_length)) refuse("position", shortest(p), "-1e6..1e6");
    const std::array<double, 9>& r = pose.rotation;
    for (double v : r)
        if (!(std::abs(v) <= 1.001)) refuse("rotation", shortest(v), "-1.001..1.001");
    double worst = 0;
    const Vector columns[] = {{r[0], r[3], r[6]}, {r[1], r[4], r[7]}, {r[2], r[5], r[8]}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) worst = std::max(worst, std::abs(dot(columns[i], columns[j]) - (i == j)));
    if (worst > 1e-3)
        refuse("rotation", "a matrix whose columns' products are off by " + shortest(worst), "up to 1e-3");
    const double determinant =
        r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) + r[2] * (r[3] * r[7] - r[4] * r[6]);
    if (determinant < 0)
        refuse("rotation", "a matrix of determinant " + shortest(determinant), "a rotation: determinant 1");
}

void check_reach(const Pad& pad, double reach) {
    scene::need_not_negative("reach", reach);
    for (double radius : {pad.radius_x, pad.radius_y})
        if (radius != 0 && reach >= radius)
            scene::refuse("reach", shortest(reach), "below the pad's radius of " + shortest(radius));
}

void need_float_pressure(const Pad& pad, double force) {
    const double pressure = force / (pad.spacing * pad.spacing);
    scene::need(pressure <= double(FLT_MAX), "force/spacing^2", pressure, "at most 3.4e38 Pa, the greatest float");
}

Foot foot_of(const Pad& pad, const Vector& p) {
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

// The profile at the centres of cells alone makes the middle and the width of a small patch jump while the patch moves
// within a cell. The mean over several places in each cell does not, but it widens the patch: it adds 1/6 to the mean
// square radius, which is 0.4*radius^2. The radius is made smaller by as much.
Disc disc_of(const Pad& pad, const Contact& patch) {
    const double x = patch.x / pad.spacing - 0.5, y = patch.y / pad.spacing - 0.5;
    const double radius = (patch.area > 0 ? std::sqrt(patch.area / pi) : patch.radius) / pad.spacing;
    if (radius < 1.5 || radius >= 8) return {x, y, radius, radius, 1};
    constexpr double corner = 0.54; // from the centre of a cell to the farthest of its places, and more
    const double own = std::sqrt(radius * radius - 1.0 / 6 / 0.4);
    return {x, y, own, own + corner, radius < 4 ? 4 : 2};
}

std::optional<Landing> landing_of(const Pad& pad, const Pose& pose, double reach, const WorldContact& c,
                                  ContactReport& report, double facing) {
    if (!(c.force > 0)) return {};
    Vector place;
    for (size_t k = 0; k < 3; ++k) place[k] = c.position[k] - pose.position[k];
    const Foot foot = foot_of(pad, turned(pose, place));
    const double length = std::hypot(c.direction[0], c.direction[1], c.direction[2]);
    const Vector d = turned(pose, c.direction);
    const bool straight = length < 1e-250; // of a shorter one the quotient below may be infinite
    const double inward = straight ? 1 : std::min(1.0, -dot(d, foot.normal) / length);
    const bool distant = std::abs(foot.above) > reach, away = inward <= facing;
    if (distant || away) {
        report.too_far += distant;
        report.turned_away += !distant && away;
        report.asked += c.force;
        report.outside += c.force;
        return {};
    }
    const double size = straight ? 0 : c.force / length;
    return Landing{{foot.x, foot.y, c.force * inward, c.radius, c.area},
                   c.force,
                   size * dot(d, foot.along_x),
                   size * dot(d, foot.along_y),
                   foot};
}

void add(const Pad& pad, const Landing& l, const Tile& tile, const CellPress& press, ContactReport& report) {
    const double force = l.patch.force;
    const double share = spread(pad, disc_of(pad, l.patch), force / (pad.spacing * pad.spacing), tile,
                                press.dragging(drag_of(l.along_x / force), drag_of(l.along_y / force)), report);
    const double own = pad.tiled ? share : 1; // the rest is asked of the neighbours
    report.asked += own * l.whole;
    report.outside += (own - share) * force;
    report.sideways += own * (l.whole - force);
    report.shear[0] += share * l.along_x;
    report.shear[1] += share * l.along_y;
}

} // namespace dermis::contact
