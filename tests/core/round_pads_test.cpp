// SPDX-License-Identifier: MIT
// Contacts in the world on pads of round bodies: where they press, and with how much of their force.
#include "host/core/contact/landing.hpp"
#include "tests/contacts.hpp"
#include "tests/expected.hpp"

#include <limits>

using namespace test::contacts;
using test::absolute;
using test::relative;

namespace {

constexpr double radius = 8e-3; // m, of a fingertip
constexpr int side = 96;
constexpr double middle = side * quarter / 2;

Pad round(Pad pad, double x, double y) {
    pad.radius_x = x, pad.radius_y = y;
    return pad;
}

// 1 N into the surface of a ball, at angles from the pad's middle.
WorldContact on_ball(double x, double y) {
    const double tilt = std::hypot(x, y), of_x = tilt == 0 ? 1 : x / tilt, of_y = tilt == 0 ? 0 : y / tilt;
    const std::array<double, 3> normal = {std::sin(tilt) * of_x, std::sin(tilt) * of_y, std::cos(tilt)};
    WorldContact c;
    c.position = {middle + radius * normal[0], middle + radius * normal[1], radius * (normal[2] - 1)};
    c.direction = {-normal[0], -normal[1], -normal[2]};
    c.force = 1, c.radius = 4 * quarter;
    return c;
}

// The centre of the pressures along x, m from the pad's middle.
double centre(const Buffer& b) {
    double sum = 0;
    for (int y = 0; y < b.pad.height; ++y)
        for (int x = 0; x < b.pad.width; ++x) sum += b.of(x, y) * (x + 0.5);
    return sum * b.pad.spacing * b.pad.spacing * b.pad.spacing / b.force() - middle;
}

} // namespace

TEST_CASE("1 N rolled over a ball from -70 to 70 degrees presses with 1 N at the arc of its angle, along x and y") {
    for (int degrees = -70; degrees <= 70; ++degrees) {
        CAPTURE(degrees);
        const double angle = degrees * pi / 180;
        Buffer along_x(side, side), along_y(side, side);
        const ContactReport r = add_contacts(round(along_x.pad, radius, radius), Pose(), 1e-3, {on_ball(angle, 0)});
        add_contacts(round(along_y.pad, radius, radius), Pose(), 1e-3, {on_ball(0, angle)});
        CHECK(r.placed == relative(1, 1e-6));
        CHECK(r.plausible());
        CHECK(centre(along_x) == absolute(radius * angle, 0.1 * quarter));
        std::vector<float> turned;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) turned.push_back(along_y.pressure[size_t(x) * side + size_t(y)]);
        CHECK(difference(turned, along_x.pressure) < 1e-5);
        Buffer flat(side, side);
        const ContactReport f = add_contacts(flat.pad, Pose(), radius, {on_ball(angle, 0)});
        CHECK(f.sideways == absolute(1 - std::cos(angle), 1e-9)); // what the ball's own normal places
    }
}

TEST_CASE("a point above a surface of any radii is found again, with its height and normal") {
    Random random;
    Buffer b(side, side / 2);
    const double middle_y = middle / 2;
    for (int trial = 0; trial < 4000; ++trial) {
        const double rx = trial % 4 == 1 ? 0 : random.within(0.004, 0.02),
                     ry = trial % 4 == 2 ? 0 : random.within(0.004, 0.02);
        const Pad pad = round(b.pad, rx, ry);
        const double x = random.within(-1, 1) * middle * 0.9, y = random.within(-1, 1) * middle_y * 0.9,
                     above = random.within(-1e-3, 1e-3);
        // The arc of rx in the plane of x and z, then turned about the axis along x at depth ry.
        const double a = rx == 0 ? 0 : x / rx, beta = ry == 0 ? 0 : y / ry;
        const double out_x = rx == 0 ? x : (rx + above) * std::sin(a),
                     up = rx == 0 ? above : (rx + above) * std::cos(a) - rx;
        if (ry != 0 && ry + up < 2e-3) continue; // on the axis, or beyond it
        const std::array<double, 3> place = {middle + out_x, middle_y + (ry == 0 ? y : (ry + up) * std::sin(beta)),
                                             ry == 0 ? up : (ry + up) * std::cos(beta) - ry};
        const Foot foot = foot_of(pad, place);
        CAPTURE(trial);
        CHECK(foot.x == absolute(middle + x, 1e-12));
        CHECK(foot.y == absolute(middle_y + y, 1e-12));
        CHECK(foot.above == absolute(above, 1e-12));
        const std::array<double, 3> normal = {std::sin(a), std::cos(a) * std::sin(beta), std::cos(a) * std::cos(beta)};
        for (size_t k = 0; k < 3; ++k) CHECK(foot.normal[k] == absolute(normal[k], 1e-9));
    }
}

TEST_CASE("a very large ball presses as a plane does, and the far side of a ball lies beside the pad") {
    Buffer flat(side, side), large(side, side), ball(side, side);
    WorldContact c;
    c.position = {0.4 * middle, 1.3 * middle, 2e-4};
    c.force = 1, c.radius = 1e-3;
    add_contacts(flat.pad, Pose(), 1e-3, {c});
    add_contacts(round(large.pad, 1e6, 1e6), Pose(), 1e-3, {c});
    CHECK(difference(large.pressure, flat.pressure) < 1e-4);
    c.position = {middle, middle, -2 * radius};
    const ContactReport r = add_contacts(round(ball.pad, radius, radius), Pose(), 1e-3, {c});
    CHECK(r.beside == 1);
    CHECK(r.placed == 0);
}

TEST_CASE(
    "radii that a pad cannot have, and a reach to the middle of its body, are refused before anything is written") {
    Buffer b(side, side);
    const auto refused = [&](double x, double y, double reach) -> std::string {
        try {
            add_contacts(round(b.pad, x, y), Pose(), reach, {on_ball(0, 0)});
        } catch (const dermis::Error& e) {
            CHECK(b.pressed() == 0);
            return e.what();
        }
        return "accepted";
    };
    CHECK(refused(3e-3, radius, 1e-3) == "pad.radius_x = 0.003; allowed: 0, or 0.003819718634205488..1e6");
    CHECK(refused(radius, -radius, 1e-3) == "pad.radius_y = -0.008; allowed: 0, or 0.003819718634205488..1e6");
    CHECK(refused(std::numeric_limits<double>::quiet_NaN(), 0, 1e-3) ==
          "pad.radius_x = nan; allowed: 0, or 0.003819718634205488..1e6");
    CHECK(refused(0, 2e6, 1e-3) == "pad.radius_y = 2e+06; allowed: 0, or 0.003819718634205488..1e6");
    CHECK(refused(radius, 0, radius) == "reach = 0.008; allowed: below the pad's radius of 0.008");
    CHECK(refused(radius, radius, 0.999 * radius) == "accepted");
}

TEST_CASE(
    "The force along the surface presses as tractions on the same patch, in the directions of the pad's own axes") {
    for (int degrees = -70; degrees <= 70; degrees += 10) {
        CAPTURE(degrees);
        const double angle = degrees * pi / 180;
        // 1 N into the ball, and 0.3 N uphill and 0.2 N across, where the ball is tilted about y.
        WorldContact c = on_ball(angle, 0);
        const double uphill[3] = {std::cos(angle), 0, -std::sin(angle)};
        for (size_t k = 0; k < 3; ++k) c.direction[k] += 0.3 * uphill[k];
        c.direction[1] += 0.2;
        c.force = std::sqrt(1 + 0.09 + 0.04);
        Buffer b(side, side), along_x(side, side), along_y(side, side);
        Pad pad = round(b.pad, radius, radius);
        pad.shear_x = along_x.pressure.data(), pad.shear_y = along_y.pressure.data();
        const ContactReport r = add_contacts(pad, Pose(), 1e-3, {c});
        CHECK(r.placed == relative(1, 1e-6));
        CHECK(r.shear[0] == relative(0.3, 1e-9));
        CHECK(r.shear[1] == relative(0.2, 1e-9));
        CHECK(r.sideways == relative(c.force - 1, 1e-9));
        CHECK(along_x.force() == relative(0.3, 1e-6));
        CHECK(along_y.force() == relative(0.2, 1e-6));
        CHECK(difference(along_x.pressure, b.pressure) == absolute(0.7, 1e-6)); // 0.3 of it everywhere
    }
}

TEST_CASE("On a ball the axes of a pad turn with the shortest way from its middle, and on an arc with the arc") {
    const auto shear_of = [](double rx, double ry, double x, double y, const std::array<double, 3>& along) {
        Buffer b(side, side);
        WorldContact c = on_ball(x, y);
        for (size_t k = 0; k < 3; ++k) c.direction[k] += along[k];
        c.force = std::sqrt(c.direction[0] * c.direction[0] + c.direction[1] * c.direction[1] +
                            c.direction[2] * c.direction[2]);
        return add_contacts(round(b.pad, rx, ry), Pose(), 2e-3, {c}).shear;
    };
    // Across the way to the place: the axis across it is the world's.
    for (double bearing : {0.3, 1.1, 2.5, -2.0}) {
        CAPTURE(bearing);
        const double u = std::cos(bearing), v = std::sin(bearing);
        const auto across = shear_of(radius, radius, 0.9 * u, 0.9 * v, {-v, u, 0});
        CHECK(across[0] == absolute(-v, 1e-9));
        CHECK(across[1] == absolute(u, 1e-9));
        const auto on =
            shear_of(radius, radius, 0.9 * u, 0.9 * v, {std::cos(0.9) * u, std::cos(0.9) * v, -std::sin(0.9)});
        CHECK(on[0] == absolute(u, 1e-9));
        CHECK(on[1] == absolute(v, 1e-9));
    }
    // A cylinder along y, and one along x: the axis along it stays the world's.
    CHECK(shear_of(radius, 0, 0.5, 0, {0, 1, 0})[1] == relative(1, 1e-9));
    CHECK(shear_of(radius, 0, 0.5, 0, {std::cos(0.5), 0, -std::sin(0.5)})[0] == relative(1, 1e-9));
    CHECK(shear_of(0, radius, 0, 0.5, {1, 0, 0})[0] == relative(1, 1e-9));
    CHECK(shear_of(0, radius, 0, 0.5, {0, std::cos(0.5), -std::sin(0.5)})[1] == relative(1, 1e-9));
}

TEST_CASE("Many contacts in one place keep their tractions, and a force straight into the pad has none") {
    Buffer b(side, side), along_x(side, side);
    Pad pad = b.pad;
    pad.shear_x = along_x.pressure.data();
    std::vector<WorldContact> many(4000);
    for (size_t i = 0; i < many.size(); ++i) {
        WorldContact& c = many[i];
        c.position = {middle, middle, 0}, c.direction = {i % 2 ? 1.0 : -0.999, 0, -1}, c.force = 1e-3, c.radius = 3e-3;
    }
    const ContactReport r = add_contacts(pad, Pose(), 1e-3, many);
    double whole = 0;
    for (float t : along_x.pressure) whole += std::abs(double(t));
    CHECK(r.shear[0] == relative(2 * (std::sqrt(0.5) - 0.999 / std::hypot(0.999, 1)), 1e-9));
    CHECK(along_x.force() == relative(r.shear[0], 1e-4)); // what is left of 2,800 times as much, to 1e-6 of that
    CHECK(whole * quarter * quarter == relative(r.shear[0], 1e-4));
    Buffer straight(side, side), none(side, side);
    pad = straight.pad, pad.shear_x = none.pressure.data();
    WorldContact c = many[0];
    c.direction = {0, 0, 0};
    CHECK(add_contacts(pad, Pose(), 1e-3, {c}).shear[0] == 0);
    CHECK(none.pressed() == 0);
}
