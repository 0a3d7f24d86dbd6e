// SPDX-License-Identifier: MIT
// How deep a body is below each cell of a pad.
#include "host/core/base/float_environment.hpp"
#include "host/core/contact/landing.hpp"

#include <cfloat>

namespace dermis::contact {
namespace {

// The places point + t*direction of a line that are in a body: near <= t <= far; none if near > far.
struct Stretch {
    double near, far;
    bool empty() const { return near > far; }
};
constexpr Stretch nowhere{1, -1};

// Where a*t^2 + 2*b*t + c <= 0, of a > 0.
Stretch within_quadric(double a, double b, double c) {
    const double under = b * b - a * c;
    if (!(under >= 0)) return nowhere;
    const double half = std::sqrt(under);
    return {(-b - half) / a, (-b + half) / a};
}

// In a ball of this radius around a place at the distance `from` of the line's point. The direction has length 1.
Stretch within_ball(const Vector& from, const Vector& direction, double radius) {
    return within_quadric(1, dot(from, direction), dot(from, from) - radius * radius);
}

// In a capsule along z: a cylinder between two balls.
Stretch within_capsule(const Vector& from, const Vector& direction, double radius, double half_length) {
    Stretch found = nowhere;
    const auto add = [&](const Stretch& s) {
        if (s.empty()) return;
        found = found.empty() ? s : Stretch{std::min(found.near, s.near), std::max(found.far, s.far)};
    };
    for (const double end : {-half_length, half_length})
        add(within_ball({from[0], from[1], from[2] - end}, direction, radius));
    const double a = direction[0] * direction[0] + direction[1] * direction[1];
    if (a < 1e-12) return found; // along the capsule: the balls have it all
    const Stretch around = within_quadric(a, from[0] * direction[0] + from[1] * direction[1],
                                          from[0] * from[0] + from[1] * from[1] - radius * radius);
    if (around.empty()) return found;
    for (const double t : {around.near, around.far})
        if (std::abs(from[2] + t * direction[2]) <= half_length) add({t, t});
    return found;
}

Stretch within_box(const Vector& from, const Vector& direction, const Vector& half) {
    Stretch found{-DBL_MAX, DBL_MAX};
    for (size_t k = 0; k < 3; ++k) {
        if (std::abs(direction[k]) < 1e-12) { // along a face
            if (std::abs(from[k]) > half[k]) return nowhere;
            continue;
        }
        const double one = (-half[k] - from[k]) / direction[k], other = (half[k] - from[k]) / direction[k];
        found = {std::max(found.near, std::min(one, other)), std::min(found.far, std::max(one, other))};
    }
    return found;
}

// Below the plane z = 0. A line along the plane is in no part of it that has an end.
Stretch within_plane(const Vector& from, const Vector& direction) {
    if (!(direction[2] > 1e-12)) return nowhere;
    return {-DBL_MAX, -from[2] / direction[2]};
}

// The places of a line in a body; both in the body's frame.
Stretch within(const Body& body, const Vector& from, const Vector& direction) {
    switch (body.kind) {
    case Body::Kind::sphere: return within_ball(from, direction, body.size[0]);
    case Body::Kind::capsule: return within_capsule(from, direction, body.size[0], body.size[1]);
    case Body::Kind::box: return within_box(from, direction, body.size);
    case Body::Kind::plane: break;
    }
    return within_plane(from, direction);
}

// sin(a)/a and cos(a) of an angle whose square is q.
struct Angle {
    double sine_over_angle, cosine;

    explicit Angle(double q) : sine_over_angle(1), cosine(1) {
        if (q == 0) return;
        if (q > 2) { // the sums below would be too short
            const double a = std::sqrt(q);
            sine_over_angle = std::sin(a) / a, cosine = std::cos(a);
            return;
        }
        // 1/n! of odd and of even n, with their signs: to 1e-10, of a radius of 10 mm a thousandth of a nanometre.
        constexpr double
            of_sine[] = {1.0 / 6227020800, -1.0 / 39916800, 1.0 / 362880, -1.0 / 5040, 1.0 / 120, -1.0 / 6, 1},
            of_cosine[] = {1.0 / 479001600, -1.0 / 3628800, 1.0 / 40320, -1.0 / 720, 1.0 / 24, -1.0 / 2, 1};
        double sine = of_sine[0], cos = of_cosine[0];
        for (int n = 1; n < 7; ++n) sine = of_sine[n] + q * sine, cos = of_cosine[n] + q * cos;
        sine_over_angle = sine, cosine = cos;
    }
};

// Places and outward normals of a pad's surface by cells, in the frame of its middle.
class PadSurface {
  public:
    explicit PadSurface(const Pad& pad)
        : pad_(pad), ball_(pad.radius_x != 0 && pad.radius_x == pad.radius_y),
          bend_x_(pad.radius_x == 0 ? 0 : 1 / pad.radius_x), bend_y_(pad.radius_y == 0 ? 0 : 1 / pad.radius_y) {}

    // Prepares a row of cells.
    void row(int y) {
        arc_y_ = (y + 0.5 - 0.5 * pad_.height) * pad_.spacing;
        const double angle = arc_y_ * bend_y_;
        const Angle about(angle * angle);
        sine_y_ = angle * about.sine_over_angle, cosine_y_ = about.cosine;
    }
    // The place and the normal of cell x of the row.
    void at(int x, Vector& place, Vector& normal) const {
        const double arc_x = (x + 0.5 - 0.5 * pad_.width) * pad_.spacing, angle_x = arc_x * bend_x_;
        const double rx = pad_.radius_x, ry = pad_.radius_y;
        if (ball_) {
            const double angle_y = arc_y_ * bend_y_;
            const Angle off(angle_x * angle_x + angle_y * angle_y);
            normal = {off.sine_over_angle * angle_x, off.sine_over_angle * angle_y, off.cosine};
            place = {rx * normal[0], rx * normal[1], rx * (normal[2] - 1)};
            return;
        }
        const Angle along(angle_x * angle_x);
        const double sine_x = angle_x * along.sine_over_angle;
        normal = {sine_x, along.cosine * sine_y_, along.cosine * cosine_y_};
        // The arc is by so much nearer to the axis along x, which is ry below the pad's middle, than there.
        const double up = rx * (along.cosine - 1);
        place = {rx == 0 ? arc_x : rx * sine_x, ry == 0 ? arc_y_ : (ry + up) * sine_y_,
                 ry == 0 ? up : (ry + up) * cosine_y_ - ry};
    }

  private:
    const Pad& pad_;
    const bool ball_;
    const double bend_x_, bend_y_; // 1/m
    double arc_y_ = 0, sine_y_ = 0, cosine_y_ = 1;
};

// Turns places and vectors in the frame of a pad's middle into the frame of a body.
struct Turn {
    Vector rows[3] = {}, offset = {};

    Turn(const Pad& pad, const Pose& from, const Pose& to) {
        Vector between;
        for (size_t i = 0; i < 3; ++i) {
            between[i] = from.position[i] - to.position[i];
            for (size_t j = 0; j < 3; ++j)
                for (size_t k = 0; k < 3; ++k) rows[i][j] += to.rotation[3 * k + i] * from.rotation[3 * k + j];
        }
        const Vector own = turned(to, between);
        offset = place({0.5 * pad.width * pad.spacing, 0.5 * pad.height * pad.spacing, 0});
        for (size_t i = 0; i < 3; ++i) offset[i] += own[i];
    }
    Vector vector(const Vector& v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
    Vector place(const Vector& p) const {
        const Vector v = vector(p);
        return {offset[0] + v[0], offset[1] + v[1], offset[2] + v[2]};
    }
};

void check_body(const Body& body) {
    check(body.pose);
    need_within("body.kind", double(body.kind), 0, 3, "sphere, capsule, box, plane");
    constexpr size_t used[] = {1, 2, 3, 0}; // sizes of each kind
    for (size_t k = 0; k < 3; ++k) {
        const double size = body.size[k];
        const bool asked = k < used[size_t(body.kind)];
        if (asked ? !(size > 0 && size <= greatest_length) : size != 0)
            scene::refuse("body.size[" + std::to_string(k) + "]", shortest(size), asked ? "above 0, at most 1e6" : "0");
    }
}

} // namespace

void fill_depths(const Pad& pad, const Pose& pose, const Body& body, float* depth, size_t pitch) {
    const DefaultFloats guard;
    check(pad);
    check(pose);
    check_body(body);
    need_memory("depth", depth != nullptr);
    need_pitch("pitch", pitch, pad.width);
    // Lines into a round pad cross at its middle: what is deeper is on its other side.
    double deepest = greatest_length;
    for (double radius : {pad.radius_x, pad.radius_y})
        if (radius != 0) deepest = std::min(deepest, radius);
    constexpr double not_below = -1e6; // m, the depth of a cell that no body is below
    const Turn turn(pad, pose, body.pose);
    PadSurface surface(pad);
    for (int y = 0; y < pad.height; ++y) {
        surface.row(y);
        float* row = depth + size_t(y) * (pitch ? pitch : size_t(pad.width));
        for (int x = 0; x < pad.width; ++x) {
            Vector place, outwards;
            surface.at(x, place, outwards);
            const Vector normal = turn.vector(outwards), inwards = {-normal[0], -normal[1], -normal[2]};
            const Stretch in = within(body, turn.place(place), inwards);
            row[x] = float(in.empty() || in.far > deepest ? not_below : in.far);
        }
    }
}

} // namespace dermis::contact
