// SPDX-License-Identifier: MIT
// The ends of lines in bodies. Lines come in rows, and each loop has no branch, so that several are computed at once.
#include "host/core/contact/bodies.hpp"

#include "host/core/base/float_environment.hpp"

#include <cfloat>

namespace dermis::contact {
namespace {

// The places point + t*direction of a line that are in a body: near <= t <= far; none if near > far.
struct Stretch {
    double near, far;
};
inline Stretch chosen(bool first, const Stretch& a, const Stretch& b) {
    return {first ? a.near : b.near, first ? a.far : b.far};
}
inline Stretch common(const Stretch& a, const Stretch& b) {
    return {std::max(a.near, b.near), std::min(a.far, b.far)};
}
constexpr Stretch nowhere{DBL_MAX, -DBL_MAX}, everywhere{-DBL_MAX, DBL_MAX};
constexpr double parallel = 1e-12; // the sine of an angle below which a line runs along a face

// Where a*t^2 + 2*b*t + c <= 0, of a > 0.
inline Stretch within_quadric(double a, double b, double c) {
    const double under = b * b - a * c, half = std::sqrt(under < 0 ? 0 : under), scale = 1 / a;
    return chosen(under >= 0, {(-b - half) * scale, (-b + half) * scale}, nowhere);
}

// Between two faces across an axis, `half` from the body's middle.
inline Stretch within_slab(double from, double along, double half) {
    const bool runs = std::abs(along) < parallel;
    const double scale = 1 / (runs ? 1 : along), one = (-half - from) * scale, other = (half - from) * scale;
    return chosen(runs, chosen(std::abs(from) <= half, everywhere, nowhere),
                  {std::min(one, other), std::max(one, other)});
}

// In a ball of this radius around a place at the distance `from` of the line's point. The direction has length 1.
inline Stretch within_ball(const Vector& from, const Vector& along, double radius) {
    return within_quadric(1, dot(from, along), dot(from, from) - radius * radius);
}

// In a cylinder along z without ends.
inline Stretch within_tube(const Vector& from, const Vector& along, double radius) {
    const double a = along[0] * along[0] + along[1] * along[1],
                 c = from[0] * from[0] + from[1] * from[1] - radius * radius;
    const bool runs = a < parallel;
    return chosen(runs, chosen(c <= 0, everywhere, nowhere),
                  within_quadric(runs ? 1 : a, from[0] * along[0] + from[1] * along[1], c));
}

// On the inner side of a face: where normal*place <= offset. The normal has length 1.
inline Stretch within_face(const Vector& from, const Vector& along, const Vector& normal, double offset) {
    const double speed = dot(normal, along), rest = offset - dot(normal, from), t = rest / (speed == 0 ? 1 : speed);
    return chosen(std::abs(speed) < parallel, chosen(rest >= 0, everywhere, nowhere),
                  {speed < 0 ? t : -DBL_MAX, speed > 0 ? t : DBL_MAX});
}

// Functions that return where a line is in a body of each kind; both in the body's frame.
inline Stretch in_sphere(const Body& body, const Vector& from, const Vector& along) {
    return within_ball(from, along, body.size[0]);
}

// The far ends alone count: where the line leaves a ball or the side of the cylinder between them, the last of them.
inline Stretch in_capsule(const Body& body, const Vector& from, const Vector& along) {
    Stretch side = within_tube(from, along, body.size[0]);
    const bool beside = !(std::abs(from[2] + side.far * along[2]) <= body.size[1]) || side.far == DBL_MAX;
    Stretch found = chosen(beside, nowhere, side);
    for (const double end : {-body.size[1], body.size[1]}) {
        const Stretch ball = within_ball({from[0], from[1], from[2] - end}, along, body.size[0]);
        found = {std::min(found.near, ball.near), std::max(found.far, ball.far)};
    }
    return found;
}

inline Stretch in_box(const Body& body, const Vector& from, const Vector& along) {
    const Stretch x = within_slab(from[0], along[0], body.size[0]), y = within_slab(from[1], along[1], body.size[1]);
    return common(common(x, y), within_slab(from[2], along[2], body.size[2]));
}

// A line along the plane, or out of it, is in no part of it that has an end.
inline Stretch in_plane(const Body&, const Vector& from, const Vector& along) {
    const bool ends = along[2] > parallel;
    return chosen(ends, {-DBL_MAX, -from[2] / (ends ? along[2] : 1)}, nowhere);
}

inline Stretch in_cylinder(const Body& body, const Vector& from, const Vector& along) {
    return common(within_tube(from, along, body.size[0]), within_slab(from[2], along[2], body.size[1]));
}

inline Stretch in_ellipsoid(const Body& body, const Vector& from, const Vector& along) {
    Vector p, d;
    for (size_t k = 0; k < 3; ++k) p[k] = from[k] / body.size[k], d[k] = along[k] / body.size[k];
    return within_quadric(dot(d, d), dot(p, d), dot(p, p) - 1);
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

    // Prepares a row of places. Places are in cells, from the centre of cell (0, 0).
    void row(double y) {
        arc_y_ = (y + 0.5 - 0.5 * pad_.height) * pad_.spacing;
        const double angle = arc_y_ * bend_y_;
        const Angle about(angle * angle);
        sine_y_ = angle * about.sine_over_angle, cosine_y_ = about.cosine;
    }
    // The place and the normal at x of the row.
    void at(double x, Vector& place, Vector& normal) const {
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

} // namespace

void check(const Body& body, const std::string& name) {
    check(body.pose);
    need_within((name + ".kind").c_str(), double(body.kind), 0, 5, "sphere, capsule, box, plane, cylinder, ellipsoid");
    constexpr size_t used[] = {1, 2, 3, 0, 2, 3}; // sizes of each kind
    for (size_t k = 0; k < 3; ++k) {
        const double size = body.size[k];
        const bool asked = k < used[size_t(body.kind)];
        if (asked ? !(size > 0 && size <= greatest_length) : size != 0)
            scene::refuse(name + ".size[" + std::to_string(k) + "]", shortest(size),
                          asked ? "above 0, at most 1e6" : "0");
    }
}

Lines::Lines(const Pad& pad, const Pose& from, const Pose& to) : pad_(pad), deepest_(greatest_length) {
    Vector between;
    for (size_t i = 0; i < 3; ++i) {
        between[i] = from.position[i] - to.position[i];
        for (size_t j = 0; j < 3; ++j)
            for (size_t k = 0; k < 3; ++k) rows_[i][j] += to.rotation[3 * k + i] * from.rotation[3 * k + j];
    }
    const Vector own = turned(to, between);
    const Vector middle = vector({0.5 * pad.width * pad.spacing, 0.5 * pad.height * pad.spacing, 0});
    for (size_t i = 0; i < 3; ++i) offset_[i] = middle[i] + own[i];
    for (double radius : {pad.radius_x, pad.radius_y})
        if (radius != 0) deepest_ = std::min(deepest_, radius);
}

void Lines::fill(const Places& places) {
    if (pad_.radius_x == 0 && pad_.radius_y == 0) {
        const double corner_x = 0.5 - 0.5 * pad_.width, corner_y = 0.5 - 0.5 * pad_.height;
        for (size_t k = 0; k < 3; ++k)
            for (int i = 0; i < places.count; ++i) {
                from_[k][i] = offset_[k] + (rows_[k][0] * ((places.x[i] + corner_x) * pad_.spacing) +
                                            rows_[k][1] * ((places.y[i] + corner_y) * pad_.spacing));
                along_[k][i] = -rows_[k][2];
            }
        return;
    }
    PadSurface surface(pad_);
    for (int i = 0; i < places.count; ++i) {
        if (i == 0 || places.y[i] != places.y[i - 1]) surface.row(places.y[i]);
        Vector place, normal;
        surface.at(places.x[i], place, normal);
        const Vector own = vector(place), out = vector(normal);
        for (size_t k = 0; k < 3; ++k) from_[k][i] = offset_[k] + own[k], along_[k][i] = -out[k];
    }
}

void Lines::deepen(const Body& body, const Places& places, double* depth) {
    fill(places);
    const auto by = [&]<Stretch (*in)(const Body&, const Vector&, const Vector&)>() {
        for (int i = 0; i < places.count; ++i) {
            const Stretch s =
                in(body, {from_[0][i], from_[1][i], from_[2][i]}, {along_[0][i], along_[1][i], along_[2][i]});
            depth[i] = std::max(depth[i], s.near > s.far || s.far > deepest_ ? not_below : s.far);
        }
    };
    switch (body.kind) {
    case Body::Kind::sphere: return by.template operator()<in_sphere>();
    case Body::Kind::capsule: return by.template operator()<in_capsule>();
    case Body::Kind::box: return by.template operator()<in_box>();
    case Body::Kind::plane: return by.template operator()<in_plane>();
    case Body::Kind::cylinder: return by.template operator()<in_cylinder>();
    case Body::Kind::ellipsoid: return by.template operator()<in_ellipsoid>();
    }
}

void fill_depths(const Pad& pad, const Pose& pose, const Body& body, float* depth, size_t pitch) {
    const DefaultFloats guard;
    check(pad);
    check(pose);
    check(body, "body");
    need_memory("depth", depth != nullptr);
    need_pitch("pitch", pitch, pad.width);
    Lines lines(pad, pose, body.pose);
    for (int y = 0; y < pad.height; ++y)
        each_piece(0, y, pad.width, [&](const Places& places, int first) {
            double deep[Places::most];
            std::fill_n(deep, places.count, not_below);
            lines.deepen(body, places, deep);
            std::copy_n(deep, places.count, depth + size_t(y) * (pitch ? pitch : size_t(pad.width)) + size_t(first));
        });
}

} // namespace dermis::contact
