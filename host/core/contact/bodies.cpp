// SPDX-License-Identifier: MIT
// The lines along which depths of bodies are measured.
#include "host/core/contact/bodies.hpp"

#include "host/core/base/float_environment.hpp"

#include <numbers>

namespace dermis::contact {
namespace {

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

void check(const Body& body, const char* list, int number) {
    check(body.pose);
    const auto name = [&](const std::string& member) {
        return list + (number < 0 ? "." + member : "." + member + "[" + std::to_string(number) + "]");
    };
    if (int(body.kind) < 0 || int(body.kind) > 5)
        scene::refuse(name("kind"), std::to_string(int(body.kind)),
                      "sphere, capsule, box, plane, cylinder, ellipsoid (0..5)");
    constexpr size_t used[] = {1, 2, 3, 0, 2, 3}; // sizes of each kind
    for (size_t k = 0; k < 3; ++k) {
        const double size = body.size[k];
        const bool asked = k < used[size_t(body.kind)];
        if (asked ? !(size > 0 && size <= greatest_length) : size != 0)
            scene::refuse(name("size") + "[" + std::to_string(k) + "]", shortest(size),
                          asked ? "above 0, at most 1e6" : "0");
    }
}

Lines::Lines(const Pad& pad, const Pose& from, const Pose& to) : pad_(pad) {
    Vector between;
    for (size_t i = 0; i < 3; ++i) {
        between[i] = from.position[i] - to.position[i];
        for (size_t j = 0; j < 3; ++j)
            for (size_t k = 0; k < 3; ++k) rows_[i][j] += to.rotation[3 * k + i] * from.rotation[3 * k + j];
    }
    const Vector own = turned(to, between);
    const Vector middle = vector({0.5 * pad.width * pad.spacing, 0.5 * pad.height * pad.spacing, 0});
    lines_.flat = pad.radius_x == 0 && pad.radius_y == 0;
    lines_.deepest = greatest_length;
    for (double radius : {pad.radius_x, pad.radius_y})
        if (radius != 0) lines_.deepest = std::min(lines_.deepest, radius);
    const double corner_x = (0.5 - 0.5 * pad.width) * pad.spacing, corner_y = (0.5 - 0.5 * pad.height) * pad.spacing;
    for (size_t k = 0; k < 3; ++k) {
        offset_[k] = middle[k] + own[k];
        lines_.origin[k] = offset_[k] + (rows_[k][0] * corner_x + rows_[k][1] * corner_y);
        lines_.step_x[k] = rows_[k][0] * pad.spacing, lines_.step_y[k] = rows_[k][1] * pad.spacing;
        lines_.down[k] = -rows_[k][2];
    }
}

Vector Lines::half_cell() const {
    Vector half;
    for (size_t k = 0; k < 3; ++k)
        half[k] =
            0.5 * pad_.spacing * (lines_.flat ? std::abs(rows_[k][0]) + std::abs(rows_[k][1]) : std::numbers::sqrt2);
    return half;
}

void Lines::fill(const Places& places) {
    PadSurface surface(pad_);
    for (int i = 0; i < places.count; ++i) {
        if (i == 0 || places.y[i] != places.y[i - 1]) surface.row(places.y[i]);
        Vector place, normal;
        surface.at(places.x[i], place, normal);
        const Vector own = vector(place), out = vector(normal);
        for (size_t k = 0; k < 3; ++k) lines_.from[k][i] = offset_[k] + own[k], lines_.along[k][i] = -out[k];
    }
}

void Lines::deepen(const Body& body, const Places& places, double* depth) {
    if (!lines_.flat) fill(places);
    loops().deepen(int(body.kind), body.size.data(), lines_, places, depth);
}

void Lines::deepen(const Body& body, const CellBlock& b, double* depth) {
    if (lines_.flat) return loops().deepen_block(int(body.kind), body.size.data(), lines_, b, depth);
    Places places;
    for (int j = 0; j < b.rows; ++j)
        for (int first = 0; first < b.columns; first += Places::most) {
            places.count = std::min(Places::most, b.columns - first);
            for (int i = 0; i < places.count; ++i) places.x[i] = b.x + first + i, places.y[i] = b.y + j;
            deepen(body, places, depth + size_t(j) * b.pitch + size_t(first));
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
    std::vector<double> row(size_t(pad.width));
    for (int y = 0; y < pad.height; ++y) {
        std::ranges::fill(row, not_below);
        lines.deepen(body, CellBlock{0, y, pad.width, 1, 0}, row.data());
        std::ranges::copy(row, depth + size_t(y) * (pitch ? pitch : size_t(pad.width)));
    }
}

} // namespace dermis::contact
