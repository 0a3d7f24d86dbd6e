// SPDX-License-Identifier: MIT
// How deep bodies reach below the cells of a pad.
#pragma once

#include "host/core/contact/landing.hpp"
#include "host/core/contact/loops.hpp"

namespace dermis::contact {

// Throws Error::bad_input. number: of a list named `name`; -1: there is no list.
void check(const Body&, const char* name, int number = -1);

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
    const Pad pad_;
    const bool ball_;
    const double bend_x_, bend_y_; // 1/m
    double arc_y_ = 0, sine_y_ = 0, cosine_y_ = 1;
};

// The lines from places of a pad's surface along its inward normals, in the frame of a body.
class Lines {
  public:
    Lines(const Pad&, const Pose& pad, const Pose& body);
    // Writes to the depth of each place the greater of what it holds and how deep the body is there, m.
    void deepen(const Body&, const Block&, double* depth);
    // The same of up to LineRow::most places anywhere.
    void deepen(const Body&, const double* x, const double* y, int count, double* depth);

  private:
    Vector vector(const Vector& v) const { return {dot(rows_[0], v), dot(rows_[1], v), dot(rows_[2], v)}; }

    PadSurface surface_;
    Vector rows_[3] = {}, offset_ = {}; // turn the frame of the pad's middle into the body's
    LineRow lines_;
};

} // namespace dermis::contact
