// SPDX-License-Identifier: MIT
// How deep bodies reach into flat and round pads, against their geometry and Hertz.
#include "tests/contacts.hpp"
#include "tests/expected.hpp"

using namespace test::contacts;
using test::absolute;
using test::relative;

namespace {

using Vector = std::array<double, 3>;

constexpr int columns = 90, rows = 48; // more columns than a LineRow has lines
constexpr double tip = 8e-3;           // m

// A turn about an axis through the middle, by an angle.
Pose turned(const Vector& position, Vector axis, double angle) {
    const double length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    for (double& a : axis) a *= std::sin(angle / 2) / length;
    const double quaternion[4] = {std::cos(angle / 2), axis[0], axis[1], axis[2]};
    return Pose::from_quaternion(position.data(), quaternion);
}

Vector to_world(const Pose& pose, const Vector& v) {
    Vector w = pose.position;
    for (size_t i = 0; i < 3; ++i)
        for (size_t k = 0; k < 3; ++k) w[i] += pose.rotation[3 * i + k] * v[k];
    return w;
}

// Whether a place of the world is in a body.
bool is_in(const Body& b, const Vector& place) {
    Vector p{};
    for (size_t i = 0; i < 3; ++i)
        for (size_t k = 0; k < 3; ++k) p[i] += b.pose.rotation[3 * k + i] * (place[k] - b.pose.position[k]);
    if (b.kind == Body::Kind::plane) return p[2] <= 0;
    if (b.kind == Body::Kind::box)
        return std::abs(p[0]) <= b.size[0] && std::abs(p[1]) <= b.size[1] && std::abs(p[2]) <= b.size[2];
    const double half = b.kind == Body::Kind::capsule ? b.size[1] : 0;
    p[2] -= std::clamp(p[2], -half, half);
    return std::hypot(p[0], p[1], p[2]) <= b.size[0];
}

// A place of a pad's surface and the normal there, by sines and cosines of the arcs.
struct Spot {
    Vector place, normal;
};
Spot spot_of(const Pad& pad, int x, int y) {
    const double ax = (x + 0.5 - 0.5 * pad.width) * pad.spacing, ay = (y + 0.5 - 0.5 * pad.height) * pad.spacing;
    const double rx = pad.radius_x, ry = pad.radius_y;
    if (rx == 0 && ry == 0) return {{ax, ay, 0}, {0, 0, 1}};
    if (rx == ry) {
        const double off = std::hypot(ax, ay) / rx, u = ax / std::hypot(ax, ay), v = ay / std::hypot(ax, ay);
        const Vector n = {std::sin(off) * u, std::sin(off) * v, std::cos(off)};
        return {{rx * n[0], rx * n[1], rx * n[2] - rx}, n};
    }
    const double a = rx == 0 ? 0 : ax / rx, b = ry == 0 ? 0 : ay / ry;
    const Vector n = {std::sin(a), std::cos(a) * std::sin(b), std::cos(a) * std::cos(b)};
    const double up = rx == 0 ? 0 : rx * (std::cos(a) - 1);
    return {{rx == 0 ? ax : rx * std::sin(a), ry == 0 ? ay : (ry + up) * std::sin(b),
             ry == 0 ? up : (ry + up) * std::cos(b) - ry},
            n};
}

std::vector<Pad> pads(Buffer& b) {
    std::vector<Pad> all(5, b.pad);
    all[1].radius_x = all[1].radius_y = tip;
    all[2].radius_x = tip, all[2].radius_y = 1.5 * tip;
    all[3].radius_x = tip;
    all[4].radius_y = tip;
    return all;
}

} // namespace

TEST_CASE(
    "A depth ends where the body ends: just above it a point of the normal is in the body, just below it is not") {
    Buffer b(columns, rows);
    const Vector axis = {1, -2, 0.7};
    std::vector<Body> bodies(4);
    bodies[0] = {Body::Kind::sphere, {5e-3, 0, 0}, turned({1e-3, -2e-3, 4.6e-3}, axis, 1)};
    bodies[1] = {Body::Kind::capsule, {2e-3, 4e-3, 0}, turned({0, 1e-3, 1.2e-3}, {1, 0.2, 0}, 1.4)};
    bodies[2] = {Body::Kind::box, {3e-3, 2e-3, 1e-3}, turned({-1e-3, 0, 0.7e-3}, axis, 0.3)};
    bodies[3] = {Body::Kind::plane, {0, 0, 0}, turned({0, 0, -3e-4}, {1, 0.1, 0}, 3.05)};
    const Pose middle = turned({0.3, -0.2, 0.1}, {0.3, 0.9, -0.4}, 2);
    for (const Pad& pad : pads(b))
        for (Body body : bodies) {
            CAPTURE(pad.radius_x);
            CAPTURE(pad.radius_y);
            CAPTURE(int(body.kind));
            Pose pose = body.pose; // the same scene, moved in the world
            pose.position = to_world(middle, body.pose.position);
            for (size_t i = 0; i < 3; ++i)
                for (size_t j = 0; j < 3; ++j) {
                    pose.rotation[3 * i + j] = 0;
                    for (size_t k = 0; k < 3; ++k)
                        pose.rotation[3 * i + j] += middle.rotation[3 * i + k] * body.pose.rotation[3 * k + j];
                }
            body.pose = pose;
            std::vector<float> depth(size_t(columns) * rows);
            fill_depths(pad, middle.from_middle(pad), body, depth.data());
            int in = 0, beside = 0;
            for (int y = 0; y < rows; ++y)
                for (int x = 0; x < columns; ++x) {
                    const Spot s = spot_of(pad, x, y);
                    const double d = depth[size_t(y) * columns + size_t(x)];
                    const auto at = [&](double t) {
                        return is_in(body, to_world(middle, {s.place[0] - t * s.normal[0], s.place[1] - t * s.normal[1],
                                                             s.place[2] - t * s.normal[2]}));
                    };
                    if (d == -1e6) {
                        ++beside;
                        for (double t = -8e-3; t < 7e-3; t += 5e-4) REQUIRE(!at(t));
                        continue;
                    }
                    REQUIRE(at(d - 2e-8));
                    REQUIRE(!at(d + 2e-8));
                    in += d > 0;
                }
            CHECK(in > 10);
            CHECK((beside > 10 || body.kind == Body::Kind::plane));
        }
}

TEST_CASE(
    "A ball on a foundation of its own stiffness presses a patch with the radius of Hertz's to 2 %, flat or round") {
    const double ball = 8e-3, modulus = 1e5, force = 0.5;
    Buffer flat(96, 96, 1e-4);
    std::vector<float> depth(96 * 96);
    const Body body{Body::Kind::sphere, {ball, 0, 0}, {{0, 0, ball - 1e-5}}};
    fill_depths(flat.pad, Pose().from_middle(flat.pad), body, depth.data());
    const ContactReport r = add_depths(flat.pad, depths_of(depth, force, foundation_stiffness(force, ball, modulus)));
    CHECK(r.placed == relative(force, 1e-6));
    const double hertz = hertz_radius(force, ball, modulus);
    CHECK(std::sqrt(r.cells * 1e-8 / pi) == relative(hertz, 0.02));

    // A ball of R1 on a fingertip of R2 presses as a ball of 1/(1/R1 + 1/R2) on a plane, where the patch is small
    // beside both.
    Buffer tips(96, 96, 5e-5);
    Pad pad = tips.pad;
    pad.radius_x = pad.radius_y = tip;
    fill_depths(pad, Pose().from_middle(pad), body, depth.data());
    const double both = 1 / (1 / ball + 1 / tip), gentle = 0.05;
    const DepthMap depths = depths_of(depth, gentle, foundation_stiffness(gentle, both, modulus));
    CHECK(std::sqrt(add_depths(pad, depths).cells * 2.5e-9 / pi) ==
          relative(hertz_radius(gentle, both, modulus), 0.02));
}

TEST_CASE("A flat box places its force evenly on the cells below it, and a plane on all cells") {
    Buffer b(columns, rows), all(columns, rows);
    std::vector<float> depth(size_t(columns) * rows);
    const Body box{Body::Kind::box, {4e-3, 3e-3, 1e-3}, {{0, 0, 9e-4}}};
    fill_depths(b.pad, Pose().from_middle(b.pad), box, depth.data());
    CHECK(add_depths(b.pad, depths_of(depth, 0.5)).cells == 32 * 24);
    for (float p : b.pressure)
        if (p != 0) CHECK(p == relative(0.5 / (8e-3 * 6e-3), 1e-5));
    const Body plane{Body::Kind::plane, {0, 0, 0}, turned({0, 0, -1e-4}, {1, 0, 0}, pi)};
    fill_depths(all.pad, Pose().from_middle(all.pad), plane, depth.data());
    CHECK(add_depths(all.pad, depths_of(depth, 0.5)).cells == columns * rows);
    // From the other side it is nowhere above the pad.
    fill_depths(all.pad, Pose().from_middle(all.pad), {Body::Kind::plane, {0, 0, 0}, {{0, 0, 1e-4}}}, depth.data());
    CHECK(depth[0] == -1e6f);
}

TEST_CASE("A body on the other side of a round pad presses nothing, and rows of a pitch keep what is between them") {
    Buffer b(columns, rows);
    Pad pad = b.pad;
    pad.radius_x = pad.radius_y = tip;
    std::vector<float> depth(size_t(rows) * (columns + 3), 7.0f);
    fill_depths(pad, Pose().from_middle(pad), {Body::Kind::sphere, {3e-3, 0, 0}, {{0, 0, -2 * tip - 2e-3}}},
                depth.data(), columns + 3);
    for (size_t y = 0; y < rows; ++y)
        for (size_t x = 0; x < columns + 3; ++x) REQUIRE(depth[y * (columns + 3) + x] == (x < columns ? -1e6f : 7.0f));
}

TEST_CASE("A body that is none is refused by its number, before a depth is written") {
    Buffer b(4, 3);
    std::vector<float> depth(12, 5.0f);
    const auto refused = [&](const Body& body, float* to, size_t pitch) -> std::string {
        try {
            fill_depths(b.pad, Pose(), body, to, pitch);
        } catch (const dermis::Error& e) {
            for (float d : depth) CHECK(d == 5);
            return e.what();
        }
        return "";
    };
    CHECK(refused({Body::Kind::sphere, {0, 0, 0}, {}}, depth.data(), 0) ==
          "body.size[0] = 0; allowed: above 0, at most 1e6");
    CHECK(refused({Body::Kind::sphere, {1, 1, 0}, {}}, depth.data(), 0) == "body.size[1] = 1; allowed: 0");
    CHECK(refused({Body::Kind::box, {1, 1, NAN}, {}}, depth.data(), 0).find("body.size[2] = ") == 0);
    CHECK(refused({Body::Kind::plane, {0, 0, 0}, {{0, 2e6, 0}}}, depth.data(), 0).find("body.position = ") == 0);
    CHECK(refused({Body::Kind::sphere, {1, 0, 0}, {}}, nullptr, 0) == "depth = null; allowed: an address");
    CHECK(refused({Body::Kind::sphere, {1, 0, 0}, {}}, depth.data(), 3).find("pitch = 3") == 0);
    CHECK_THROWS_WITH(foundation_stiffness(0, 8e-3, 1e5), "force = 0; allowed: a finite number > 0");
}
