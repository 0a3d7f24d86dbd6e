// SPDX-License-Identifier: MIT
// Pads that bodies press by their shapes: forces, centres and profiles against closed forms of an elastic foundation.
#include "dermis/touch.hpp"
#include "host/core/contact/loops.hpp"
#include "tests/allocations.hpp"
#include "tests/contacts.hpp"
#include "tests/expected.hpp"

#include <cstring>
#include <utility>

using namespace test::contacts;
using test::absolute, test::relative;

namespace {

using Vector = std::array<double, 3>;
constexpr double stiffness = 5e7; // Pa/m

// A flat pad in the world's frame whose middle is the origin, and what it is pressed by.
struct Grip {
    explicit Grip(int width, int height, double spacing, const Source& by = {stiffness}, double radius = 0,
                  bool shear = false)
        : touch({.width = width, .height = height, .spacing = spacing, .radius_x = radius, .radius_y = radius}, 1,
                radius == 0 ? 1e-3 : std::min(1e-3, 0.1 * radius), shear, by) {}

    void shape(Body::Kind kind, const Vector& size, const Vector& at, const std::array<double, 9>& turn = upright,
               int body = 0) {
        kinds.push_back(int(kind)), bodies.push_back(body), pads.push_back(0);
        sizes.insert(sizes.end(), size.begin(), size.end());
        places.insert(places.end(), at.begin(), at.end());
        turns.insert(turns.end(), turn.begin(), turn.end());
    }
    void push(const Vector& at, const Vector& force, int body = 0, const Vector& torque = {}) {
        named.push_back(body), on.push_back(0);
        torques.insert(torques.end(), torque.begin(), torque.end());
        points.insert(points.end(), at.begin(), at.end());
        forces.insert(forces.end(), force.begin(), force.end());
    }
    Contacts contacts() const {
        return {.count = on.size(),
                .pad = on.data(),
                .position = points.data(),
                .force = forces.data(),
                .body = named.data(),
                .torque = torques.data()};
    }
    Shapes shapes() const {
        return {.count = kinds.size(),
                .pad = pads.data(),
                .body = bodies.data(),
                .kind = kinds.data(),
                .size = sizes.data(),
                .position = places.data(),
                .rotation = turns.data(),
                .faces = faces.data(),
                .face_count = faces.size() / 4};
    }
    const ContactReport& press() { return touch.add({origin.data(), upright.data()}, contacts(), shapes()); }
    double of(int x, int y) const { return touch.pressure()[y * touch.shape().width + x]; }
    double greatest() const { return *std::max_element(touch.pressure(), touch.pressure() + cells()); }
    int cells() const { return touch.shape().width * touch.shape().height; }
    // The centre of pressure, m from the pad's middle, and the force, N.
    Vector centre() const {
        const Pad& p = touch.shape();
        double sum = 0, x = 0, y = 0;
        for (int i = 0; i < cells(); ++i) {
            const double force = touch.pressure()[i];
            sum += force, x += force * (i % p.width + 0.5 - 0.5 * p.width);
            y += force * (i / p.width + 0.5 - 0.5 * p.height);
        }
        return {x / sum * p.spacing, y / sum * p.spacing, sum * p.spacing * p.spacing};
    }

    static constexpr std::array<double, 9> upright = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                           along_y = {1, 0, 0, 0, 0, 1, 0, -1, 0};
    static constexpr Vector origin = {0, 0, 0};
    Touch touch;
    std::vector<int32_t> kinds, bodies, pads, named, on;
    std::vector<double> sizes, places, turns, points, forces, torques, faces;
};

} // namespace

TEST_CASE(
    "A ball presses the patch of an elastic foundation, wherever in a cell it is: F = pi*k*R*d^2, peak 2F/(pi*a^2)") {
    Random random;
    const double radius = 8e-3;
    for (const int n : {3, 6}) // cells of the patch's radius
        for (int turn = 0; turn < 40; ++turn) {
            Grip s(64, 64, quarter);
            const double a = n * quarter, depth = a * a / (2 * radius), force = pi * stiffness * radius * depth * depth;
            const double x = random.within(-0.5, 0.5) * quarter, y = random.within(-0.5, 0.5) * quarter;
            s.shape(Body::Kind::sphere, {radius}, {x, y, radius});
            s.push({x, y, 0}, {0, 0, -force});
            const ContactReport& r = s.press();
            CHECK(r.placed == relative(force, 1e-6));
            CHECK(r.by_body == 1);
            // The cells' centres are up to 0.71 of a cell from the middle.
            CHECK(s.greatest() == relative(2 * force / (pi * a * a), 1.05 * 0.5 / (n * n)));
            CHECK(std::hypot(s.centre()[0] - x, s.centre()[1] - y) <= 0.03 * quarter);
        }
}

TEST_CASE(
    "A cylinder presses a strip, on a pad of 64 rows as of one: half width b^3 = 3*R*F/(2*k*L), peak 3*F/(4*L*b)") {
    for (const auto& [n, rows] : {std::pair{3, 64}, {6, 64}, {12, 64}, {3, 4}, {3, 3}, {6, 2}, {3, 1}})
        for (int turn = -5; turn <= 5; ++turn) {
            Grip s(64, rows, quarter);
            const double b = n * quarter, radius = 15e-3, length = rows * quarter;
            const double force = 2 * stiffness * length * b * b * b / (3 * radius), x = 0.1 * turn * quarter;
            CAPTURE(rows);
            s.shape(Body::Kind::cylinder, {radius, 0.04}, {x, 0, radius}, Grip::along_y);
            s.push({x, -0.5 * length, 0}, {0, 0, -0.5 * force});
            s.push({x, 0.5 * length, 0}, {0, 0, -0.5 * force}); // where MuJoCo has them: on the pad's border
            CHECK(s.press().placed == relative(force, 1e-6));
            CHECK(s.greatest() == relative(3 * force / (4 * length * b), n == 3 ? 0.04 : 0.01));
        }
}

TEST_CASE(
    "A face whose force is off its middle has a linear pressure up to a sixth of its side, and less shift beyond") {
    const int n = 16;
    const double spacing = 1.5e-3, side = n * spacing, force = 6;
    for (const int draw : {0, 1, 2, 3, 4, 5, 6, 7}) {
        // On a row of cells the force may be off it by a rounding.
        const double s = std::array{0.0, 0.05, 0.1, 1.0 / 6}[size_t(draw % 4)], off = draw < 4 ? 0 : 1e-14;
        const int rows = draw < 4 ? n : 1;
        Grip scene(n, rows, spacing);
        scene.shape(Body::Kind::box, {0.03, 0.03, 0.01}, {0, 0, 0.01});
        scene.push({s * side, off, 0}, {0, 0, -force * rows / n});
        CHECK(scene.press().tilted == 0);
        const double even = force / (side * side);
        double worst = 0;
        for (int x = 0; x < n; ++x) {
            const double place = (x + 0.5 - 0.5 * n) * spacing;
            const double linear = even * (1 + 12 * s * side * place / (side * side - spacing * spacing));
            for (int y = 0; y < rows; ++y) worst = std::max(worst, std::abs(scene.of(x, y) - linear) / even);
        }
        CHECK(worst <= 1e-6);
    }
    for (const auto& [s, centre, peak] : {std::array{0.2, 0.175, 1.99}, std::array{0.5, 0.198, 2.13}}) {
        Grip scene(n, n, spacing);
        scene.shape(Body::Kind::box, {0.03, 0.03, 0.01}, {0, 0, 0.01});
        scene.push({s * side, 0, 0}, {0, 0, -force});
        const ContactReport& r = scene.press();
        CHECK(r.tilted == 1);
        CHECK(r.centre_off == relative((s - centre) * side, 0.02));
        CHECK(scene.centre()[0] / side == absolute(centre, 0.002));
        CHECK(scene.greatest() * side * side / force == absolute(peak, 0.02));
    }
}

TEST_CASE("A ball whose force is off its middle moves its patch by as much, and at the patch's border by about half") {
    const double radius = 15e-3, a = 3e-3, depth = a * a / (2 * radius),
                 force = pi * stiffness * radius * depth * depth;
    for (const auto& [s, got] : {std::array{0.1, 0.1}, std::array{0.3, 0.3}, std::array{1.0, 0.57}}) {
        Grip grip(64, 64, quarter);
        grip.shape(Body::Kind::sphere, {radius}, {0, 0, radius});
        grip.push({s * a, 0, 0}, {0, 0, -force});
        CHECK(grip.press().tilted == (s == 1));
        CHECK(grip.centre()[0] / a == absolute(got, 0.006));
        CHECK(std::abs(grip.centre()[1]) <= 1e-6 * a);
        CHECK(grip.greatest() == relative(2 * force / (pi * a * a), 0.01));
    }
}

TEST_CASE("The image of a wedge presses a strip, however few its rows: width^2 = 2*F/(k*L*tan(angle))") {
    const int n = 64;
    for (const int rows : {n, 3, 2, 1}) {
        const double spacing = 3.75e-4, slope = std::tan(pi / 90), force = 2.0 * rows / n, length = rows * spacing;
        std::vector<float> depth(size_t(n * rows));
        for (int i = 0; i < n * rows; ++i) depth[size_t(i)] = float(i % n * spacing * slope);
        Touch touch({.width = n, .height = rows, .spacing = spacing}, 1, 1e-3, false, {stiffness});
        const Vector push = {0, 0, -force};
        touch.add({.depth = depth.data(), .force = push.data(), .gaps = true});
        int pressed = 0;
        for (int x = 0; x < n; ++x) pressed += touch.pressure()[x] > 0;
        CHECK(std::abs(pressed * spacing - std::sqrt(2 * force / (stiffness * length * slope))) <= spacing);
        CHECK(touch.report(0).placed == relative(force, 1e-6));
    }
}

TEST_CASE("An image without gaps is clipped if its cells above 0 cannot carry the force, however few they are") {
    const double spacing = 1.5e-3, deep = 1e-3;
    for (const int side : {1, 2, 3, 5})
        for (const double part : {0.01, 0.5, 0.99, 1.01, 2.0}) { // of the force that presses them to a depth of 0
            std::vector<float> depth(16 * 16);
            for (int i = 0; i < side * side; ++i) depth[size_t((5 + i / side) * 16 + 5 + i % side)] = float(deep);
            const Vector push = {0, 0, -part * side * side * deep * stiffness * spacing * spacing};
            Touch touch({.width = 16, .height = 16, .spacing = spacing}, 1, 1e-3, false, {stiffness});
            CHECK(touch.add({.depth = depth.data(), .force = push.data()}).clipped == (part > 1));
        }
}

TEST_CASE("An image whose force is almost along the pad leaves finite tractions") {
    Touch touch({.width = 16, .height = 16, .spacing = 1.5e-3}, 1, 1e-3, true, {stiffness});
    std::vector<float> depth(16 * 16);
    for (size_t i = 0; i < 100; ++i) depth[i] = 1e-3f;
    for (const Vector& push : {Vector{0.1, 0, -1e-45}, Vector{0.1, 1, -1}}) {
        touch.add({.depth = depth.data(), .force = push.data()});
        for (int i = 0; i < 512; ++i) REQUIRE(std::isfinite(touch.traction()[i]));
    }
}

TEST_CASE("A level at which a cell is just about to be pressed is found, whichever way it is rounded to a float") {
    const Pad pair{.width = 2, .height = 1, .spacing = 1e-3};
    Touch touch(pair, 1, 1e-3, false, {stiffness});
    for (const float below : {1e-7f, 1.1e-5f, 3e-4f, 2e-3f})
        for (int step = -30; step <= 30; ++step) {
            const std::vector<float> depth = {0, -below};
            const double asked = double(below) + 0.1 * step * double(std::nextafter(below, 1.0f) - below);
            const Vector push = {0, 0, -asked * stiffness * pair.spacing * pair.spacing};
            touch.add({.depth = depth.data(), .force = push.data(), .gaps = true});
            CHECK(touch.report(0).placed == relative(-push[2], 1e-6));
        }
}

TEST_CASE("A world that is turned by a quarter, pad and body, has the same bits") {
    const std::array<double, 9> quarter_turn = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    Grip here(16, 12, 1e-3), there(16, 12, 1e-3);
    const Vector at = {2.3e-3, -1.1e-3, 4e-3}, place = {1.7e-3, 0.4e-3, 0}, force = {0.2, -0.1, -1.5},
                 torque = {3e-4, 1e-3, -2e-4};
    const auto turned = [](const Vector& v) { return Vector{-v[1], v[0], v[2]}; };
    here.shape(Body::Kind::box, {3e-3, 5e-3, 4e-3}, at);
    here.push(place, force, 0, torque);
    there.shape(Body::Kind::box, {3e-3, 5e-3, 4e-3}, turned(at), quarter_turn);
    there.push(turned(place), turned(force), 0, turned(torque));
    here.press();
    there.touch.add({Grip::origin.data(), quarter_turn.data()}, there.contacts(), there.shapes());
    CHECK(std::memcmp(here.touch.pressure(), there.touch.pressure(), sizeof(float) * size_t(here.cells())) == 0);
}

TEST_CASE("A body and its force, mirrored at the pad's diagonal, press the mirrored pad, also if the tilt is bounded") {
    for (const double off : {0.0, 1e-3, 4e-3}) // m, from the middle of a narrow box, along it
        for (const double across : {0.0, 3e-4}) {
            Grip here(20, 9, 1e-3), there(9, 20, 1e-3);
            here.shape(Body::Kind::box, {7e-3, 7e-4, 4e-3}, {2e-4, 4e-4, 4e-3});
            there.shape(Body::Kind::box, {7e-4, 7e-3, 4e-3}, {4e-4, 2e-4, 4e-3});
            here.push({2e-4 + off, 4e-4 + across, 0}, {0, 0, -1});
            there.push({4e-4 + across, 2e-4 + off, 0}, {0, 0, -1});
            CHECK(here.press().placed == relative(there.press().placed, 1e-6));
            for (int x = 0; x < 20; ++x)
                for (int y = 0; y < 9; ++y) REQUIRE(here.of(x, y) == absolute(there.of(y, x), 1e-5 * here.greatest()));
        }
}

TEST_CASE("A finger that goes on beyond its pad carries its share of the force there") {
    const double spacing = 1.5e-3, more = 4 * spacing;
    const auto share = [&](Body::Kind kind, const Vector& size, const Vector& at, const std::array<double, 9>& turn,
                           const Vector& point) {
        Grip s(8, 8, spacing, {stiffness, {more, more, more, more}});
        s.shape(kind, size, at, turn);
        s.push(point, {0, 0, -2});
        const ContactReport& r = s.press();
        CHECK(r.asked == absolute(2, 1e-9));
        CHECK(r.placed + r.outside == relative(2, 1e-6));
        return r.placed / 2;
    };
    CHECK(share(Body::Kind::box, {0.04, 0.04, 0.01}, {0, 0, 0.01}, Grip::upright, {0, 0, 0}) == absolute(0.25, 1e-3));
    CHECK(share(Body::Kind::cylinder, {0.015, 0.04}, {0, 0, 0.015}, Grip::along_y, {0, 0, 0}) == absolute(0.5, 1e-3));
    CHECK(share(Body::Kind::sphere, {0.015}, {0.006, 0, 0.015}, Grip::upright, {0.006, 0, 0}) == absolute(0.5, 1e-3));
}

TEST_CASE("Force, shear and torsion are those of the contacts") {
    const double spacing = 1.5e-3;
    Grip s(16, 16, spacing, {stiffness}, 0, true);
    s.shape(Body::Kind::ellipsoid, {0.03, 0.02, 0.01}, {1e-3, 2e-3, 0.01});
    s.push({2e-3, 1e-3, 0}, {0.3, -0.2, -1});
    s.push({-1e-3, 2e-3, 0}, {-0.1, 0.4, -2});
    const ContactReport& r = s.press();
    CHECK(r.placed == relative(3, 1e-6));
    CHECK(r.shear[0] == relative(0.2, 1e-6));
    CHECK(r.shear[1] == relative(0.2, 1e-6));
    double sums[2] = {}, torsion = 0;
    const float* x = s.touch.traction();
    for (int i = 0; i < s.cells(); ++i) {
        const double tx = x[i], ty = x[s.cells() + i];
        const double px = (i % 16 + 0.5 - 8) * spacing, py = (i / 16 + 0.5 - 8) * spacing;
        sums[0] += tx, sums[1] += ty, torsion += px * ty - py * tx;
    }
    const double area = spacing * spacing;
    CHECK(sums[0] * area == absolute(0.2, 3e-6));
    CHECK(sums[1] * area == absolute(0.2, 3e-6));
    const double asked = (2e-3 * -0.2 - 1e-3 * 0.3) + (-1e-3 * 0.4 - 2e-3 * -0.1);
    CHECK(torsion * area == absolute(asked, 3e-6 * spacing));
    CHECK(std::hypot(s.centre()[0] - 0, s.centre()[1] - (1e-3 + 2 * 2e-3) / 3) <= 1e-5 * spacing);
}

TEST_CASE("A contact with a moment presses and drags as two contacts that have the same force and moment") {
    Random random;
    for (int draw = 0; draw < 40; ++draw) {
        Grip one(16, 16, 1e-3, {stiffness}, 0, true), two(16, 16, 1e-3, {stiffness}, 0, true);
        const auto drawn = [&](double most) { return random.within(-most, most); };
        const Vector middle = {drawn(1e-3), drawn(1e-3), 0}, arm = {drawn(1e-3), drawn(1e-3), 0},
                     force = {drawn(0.2), drawn(0.2), -1}, more = {drawn(0.2), drawn(0.2), drawn(0.5)};
        for (Grip* s : {&one, &two}) s->shape(Body::Kind::sphere, {30e-3}, {0, 0, 30e-3});
        for (const double side : {-1, 1})
            two.push({middle[0] + side * arm[0], middle[1] + side * arm[1], 0},
                     {force[0] + side * more[0], force[1] + side * more[1], force[2] + side * more[2]});
        one.push(middle, {2 * force[0], 2 * force[1], 2 * force[2]}, 0,
                 {2 * arm[1] * more[2], -2 * arm[0] * more[2], 2 * (arm[0] * more[1] - arm[1] * more[0])});
        one.press(), two.press();
        const auto list = [&](const float* first, int count) { return std::vector<float>(first, first + count); };
        CHECK(difference(list(one.touch.pressure(), 256), list(two.touch.pressure(), 256)) <= 1e-5);
        CHECK(difference(list(one.touch.traction(), 512), list(two.touch.traction(), 512)) <= 1e-5);
    }
}

TEST_CASE("A light press is two cells wide, so that its centre does not jump from cell to cell") {
    const double spacing = 1.5e-3;
    for (const double force : {0.005, 0.02, 0.1, 0.5})
        for (int step = 0; step < 60; ++step) {
            Grip s(16, 16, spacing);
            const double x = -1.5e-3 + 5e-5 * step, y = 2e-4;
            s.shape(Body::Kind::sphere, {4e-3}, {x, y, 4e-3});
            s.push({x, y, 0}, {0, 0, -force});
            s.press();
            CHECK(std::hypot(s.centre()[0] - x, s.centre()[1] - y) <= 0.06 * spacing);
        }
}

TEST_CASE("Forces and sizes of any order keep the force, and no pressure is infinite or not a number") {
    Random random;
    for (int draw = 0; draw < 2000; ++draw) {
        const double spacing = random.decades(-6, -1), radius = draw % 2 ? random.decades(1, 3) * 12 * spacing : 0;
        Grip s(12, 9, spacing, {random.decades(-6, 30), {}}, radius, true);
        const auto kind = Body::Kind(draw % 6);
        const int used[] = {1, 2, 3, 0, 2, 3};
        Vector size{}, at = {random.within(-8, 8) * spacing, random.within(-8, 8) * spacing, 0};
        for (int k = 0; k < used[draw % 6]; ++k) size[size_t(k)] = random.decades(-2, 4) * spacing;
        at[2] = (kind == Body::Kind::plane ? 0 : size[0]) + random.within(-1, 1) * 0.1 * spacing;
        const double quaternion[4] = {1, random.within(-1, 1), random.within(-1, 1), random.within(-1, 1)};
        Pose turn;
        if (draw % 3 == 0) turn = Pose::from_quaternion(at.data(), quaternion);
        if (kind == Body::Kind::plane) turn.rotation = {1, 0, 0, 0, -1, 0, 0, 0, -1};
        s.shape(kind, size, at, turn.rotation);
        const double force = std::min(random.decades(-30, 9), 1e36 * spacing * spacing);
        const double moment = draw % 5 < 2 ? std::min(random.decades(-6, 9) * force * spacing, 1e12) : 0;
        s.push({at[0], at[1], 0}, {0, 0, -force}, 0, {moment, random.within(-1, 1) * moment, moment});
        const ContactReport& r = s.press();
        const auto finite = [](float x) { return std::isfinite(x); };
        CHECK(std::all_of(s.touch.pressure(), s.touch.pressure() + s.cells(), finite));
        CHECK(std::all_of(s.touch.traction(), s.touch.traction() + 2 * s.cells(), finite));
        CHECK(r.asked == relative(r.placed + r.outside + r.sideways, 1e-5));
        CHECK(r.centre_off >= 0);
    }
}

// The tractions' sums along x and y, N.
std::array<double, 2> dragged(const Grip& s) {
    const float* x = s.touch.traction();
    const double area = s.touch.shape().spacing * s.touch.shape().spacing;
    return {std::accumulate(x, x + s.cells(), 0.0) * area,
            std::accumulate(x + s.cells(), x + 2 * s.cells(), 0.0) * area};
}

TEST_CASE("A tilted plane that meets a pad at its corner or border presses and drags it with the contact's force") {
    for (const double k : {stiffness, 1e9})
        for (double force = 1e-8; force < 20; force *= std::sqrt(10))
            for (double tilt = 0.05; tilt < 1.04; tilt += 0.05)
                for (const double turn : {0.0, 0.3, 0.785}) {
                    CAPTURE(k);
                    CAPTURE(force);
                    CAPTURE(tilt);
                    CAPTURE(turn);
                    const double c = std::cos(tilt), s = std::sin(tilt), cx = std::cos(turn), cy = std::sin(turn);
                    const Vector normal = {-s * cx, -s * cy, -c};
                    Grip grip(24, 24, 5e-4, {k}, 0, true);
                    const Vector at = {6e-3, turn > 0 ? 6e-3 : 0, -1e-5};
                    grip.shape(Body::Kind::plane, {}, at,
                               {c * cx, cy, normal[0], c * cy, -cx, normal[1], -s, 0, normal[2]});
                    grip.push({at[0], at[1], 0}, {force * normal[0], force * normal[1], force * normal[2]});
                    const ContactReport& r = grip.press();
                    REQUIRE(r.placed == relative(force * c, 1e-5));
                    for (size_t axis = 0; axis < 2; ++axis) {
                        REQUIRE(dragged(grip)[axis] == absolute(force * normal[axis], 1e-3 * force));
                        REQUIRE(r.shear[axis] == absolute(force * normal[axis], 1e-3 * force));
                    }
                }
}

TEST_CASE("A body that is below no cell, and one without shapes, press by a patch of two cells") {
    Grip s(16, 16, 1.5e-3);
    s.shape(Body::Kind::sphere, {1e-3}, {0.2, 0, 1e-3});
    s.push({0, 0, 0}, {0, 0, -1});
    const ContactReport& r = s.press();
    CHECK(r.by_patch == 1);
    CHECK(r.by_body == 0);
    CHECK(r.placed == relative(1, 1e-6));
    Grip without(16, 16, 1.5e-3, {});
    without.push({0, 0, 0}, {0, 0, -1}, 3);
    CHECK(without.press().placed == relative(1, 1e-6));
    CHECK(std::memcmp(without.touch.pressure(), s.touch.pressure(), sizeof(float) * 256) == 0);
}

TEST_CASE("A box that moves along the cells presses without steps, and one thinner than a cell wherever it stands") {
    const double spacing = 1.5e-3;
    const auto pressed_at = [&](double half, double x, const auto& check) {
        Grip s(16, 16, spacing);
        s.shape(Body::Kind::box, {half, 4.5e-3, 0.01}, {x, 0.3 * spacing, 0.01});
        s.push({x, 0.3 * spacing, 0}, {0, 0, -2});
        const ContactReport& r = s.press();
        CHECK(r.by_body == 1);
        CHECK(r.placed == relative(2, 1e-6));
        check(s);
    };
    std::vector<float> before;
    for (int step = 0; step <= 40; ++step) {
        const double x = 0.05 * step * spacing;
        pressed_at(2e-4, x, [&](const Grip& s) { CHECK(std::abs(s.centre()[0] - x) <= 0.5 * spacing); });
        pressed_at(4.5e-3, x, [&](const Grip& s) {
            CHECK(std::abs(s.centre()[0] - x) <= 0.03 * spacing);
            const std::vector<float> now(s.touch.pressure(), s.touch.pressure() + s.cells());
            if (!before.empty()) CHECK(difference(now, before) <= 0.07);
            before = now;
        });
    }
}

TEST_CASE("A coin on its edge presses a strip that grows shorter, without a jump, as the coin grows thicker") {
    double before = 0;
    for (double thick = 1; thick <= 6; thick += 0.05) { // cells
        Grip s(40, 12, 1e-3);
        s.shape(Body::Kind::cylinder, {12e-3, 0.5e-3 * thick}, {0, 0, 12e-3}, Grip::along_y);
        s.push({}, {0, 0, -0.5});
        s.press();
        double mean = 0, square = 0;
        for (int i = 0; i < s.cells(); ++i)
            mean += s.touch.pressure()[i], square += s.touch.pressure()[i] * std::pow(i % 40 - 19.5, 2);
        const double length = std::sqrt(square / mean);
        CAPTURE(thick);
        if (before > 0) CHECK((length < 1.001 * before && length > 0.93 * before));
        before = length;
    }
}

TEST_CASE("Two boxes of one body press as one box of both") {
    const auto pressed = [](bool two) {
        Grip s(16, 16, 1.5e-3);
        if (two) {
            s.shape(Body::Kind::box, {4e-3, 8e-3, 0.01}, {-4e-3, 0, 0.01});
            s.shape(Body::Kind::box, {4e-3, 8e-3, 0.01}, {4e-3, 0, 0.01});
        } else s.shape(Body::Kind::box, {8e-3, 8e-3, 0.01}, {0, 0, 0.01});
        s.push({1e-3, 0.5e-3, 0}, {0, 0, -3});
        s.press();
        return std::vector<float>(s.touch.pressure(), s.touch.pressure() + s.cells());
    };
    CHECK(difference(pressed(true), pressed(false)) <= 1e-6);
}

TEST_CASE("A ball that moves by a millionth of a cell changes its pressures by at most 1e-5 of the peak") {
    Random random;
    const double spacing = 1.5e-3;
    for (int draw = 0; draw < 20; ++draw) {
        const double x = random.within(-6, 6) * spacing, y = random.within(-6, 6) * spacing,
                     force = random.decades(-3, 1);
        const auto pressed = [&](double by) {
            Grip s(16, 16, spacing);
            s.shape(Body::Kind::sphere, {15e-3}, {x + by, y, 15e-3});
            s.push({x + by + spacing, y, 0}, {0, 0, -force});
            s.press();
            return std::vector<float>(s.touch.pressure(), s.touch.pressure() + s.cells());
        };
        CAPTURE(force);
        CAPTURE(x);
        CAPTURE(y);
        CHECK(difference(pressed(1e-6 * spacing), pressed(0)) <= 1e-5);
    }
}

TEST_CASE("A hull of the faces of a box has the box's depths, and a prism of 48 sides nearly those of a cylinder") {
    const double a = 3e-3, b = 5e-3, c = 2e-3;
    const double faces[] = {1, 0, 0, a, -1, 0, 0, a, 0, 1, 0, b, 0, -1, 0, b, 0, 0, 1, c, 0, 0, -1, c};
    Buffer on(24, 16);
    const double quaternion[] = {0.9, 0.1, -0.05, 0.2}, place[] = {1e-3, 0, 1.5e-3};
    const Pose pose = Pose::from_quaternion(place, quaternion), at = Pose().from_middle(on.pad);
    std::vector<float> box(24 * 16), hull(24 * 16);
    fill_depths(on.pad, at, {Body::Kind::box, {a, b, c}, pose}, box.data());
    fill_depths(on.pad, at, {Body::Kind::hull, {}, pose, faces, 6}, hull.data());
    for (size_t i = 0; i < box.size(); ++i) CHECK(std::abs(box[i] - hull[i]) <= 1e-9);

    const double radius = 15e-3;
    std::vector<double> prism = {0, 0, 1, 0.04, 0, 0, -1, 0.04};
    for (int i = 0; i < 48; ++i)
        prism.insert(prism.end(), {std::cos(2 * pi * i / 48), std::sin(2 * pi * i / 48), 0, radius});
    Pose lying;
    lying.position = {0, 0, radius}, lying.rotation = {1, 0, 0, 0, 0, 1, 0, -1, 0};
    std::vector<float> round(24 * 16), sided(24 * 16);
    fill_depths(on.pad, at, {Body::Kind::cylinder, {radius, 0.04}, lying}, round.data());
    fill_depths(on.pad, at, {Body::Kind::hull, {}, lying, prism.data(), 50}, sided.data());
    for (size_t i = 0; i < round.size(); ++i) CHECK(std::abs(round[i] - sided[i]) <= 0.0022 * radius);
    CHECK_THROWS_WITH_AS(fill_depths(on.pad, at, {Body::Kind::hull, {}, lying, prism.data(), 3}, sided.data()),
                         "body.face_count = 3; allowed: 4..65536", dermis::Error);
    prism[1] = 0.5;
    CHECK_THROWS_AS(fill_depths(on.pad, at, {Body::Kind::hull, {}, lying, prism.data(), 50}, sided.data()),
                    dermis::Error);
}

TEST_CASE("A box presses as the hull of its faces does, thin as a blade or thick, wherever the hull's frame is in it") {
    Random random;
    for (int draw = 0; draw < 200; ++draw) {
        const double spacing = 5e-4, turn = random.within(0, 3), x = random.within(-1, 1) * spacing, z = 2e-3;
        const Vector half = {random.decades(-1.3, 1) * spacing, 4e-3, 2e-3}, at = {x, 0, z};
        const std::array<double, 9> axes = {
            std::cos(turn), -std::sin(turn), 0, std::sin(turn), std::cos(turn), 0, 0, 0, 1};
        const double off = draw % 2 ? random.within(-3, 3) * half[2] : 0; // of the hull's frame along its z
        Grip box(24, 24, spacing), hull(24, 24, spacing);
        box.shape(Body::Kind::box, half, at, axes);
        hull.shape(Body::Kind::hull, {6, 0, 0}, {x, 0, z - off}, axes);
        for (int k = 0; k < 3; ++k)
            for (const double side : {-1.0, 1.0}) {
                std::array<double, 4> face = {0, 0, 0, half[size_t(k)] + (k == 2 ? side * off : 0)};
                face[size_t(k)] = side;
                hull.faces.insert(hull.faces.end(), face.begin(), face.end());
            }
        for (Grip* s : {&box, &hull}) s->push({x, 0, 0}, {0, 0, -1});
        REQUIRE(box.press().by_body == 1);
        REQUIRE(hull.press().by_body == 1);
        const auto list = [](const Grip& s) {
            return std::vector<float>(s.touch.pressure(), s.touch.pressure() + 576);
        };
        REQUIRE(difference(list(hull), list(box)) <= 1e-4);
    }
}

TEST_CASE("Pads of a batch have the pressures of single pads, and contacts split in two those of one") {
    Random random;
    Grip many(13, 11, 1e-3, {stiffness, {2e-3, 0, 0, 1e-3}}, 0, true);
    const auto filled = [&](Grip& s, uint64_t seed, bool split) {
        random.bits.seed(seed);
        const double x = random.within(-6e-3, 6e-3), y = random.within(-5e-3, 5e-3), force = random.decades(-2, 1);
        s.shape(Body::Kind(seed % 3 == 0   ? 2
                           : seed % 3 == 1 ? 4
                                           : 5),
                {3e-3, 5e-3, seed % 3 == 1 ? 0 : 4e-3}, {x, y, seed % 3 == 0 ? 4e-3 : 5e-3});
        for (int part = 0; part < (split ? 2 : 1); ++part)
            s.push({x, y, 0}, {0.1 * force / (split ? 2 : 1), 0, -force / (split ? 2 : 1)});
    };
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        Grip one(13, 11, 1e-3, {stiffness, {2e-3, 0, 0, 1e-3}}, 0, true),
            two(13, 11, 1e-3, {stiffness, {2e-3, 0, 0, 1e-3}}, 0, true);
        filled(one, seed, false), filled(two, seed, true);
        one.press(), two.press();
        const auto of = [](const Grip& s) {
            return std::vector<float>(s.touch.pressure(), s.touch.pressure() + s.cells());
        };
        CHECK(difference(of(two), of(one)) <= 1e-5);
        // The same pad as the second of three, whose neighbours are pressed by other things.
        Touch batch({.width = 13, .height = 11, .spacing = 1e-3}, 3, 1e-3, true, {stiffness, {2e-3, 0, 0, 1e-3}});
        Grip other(13, 11, 1e-3);
        filled(other, seed + 1, false);
        Grip all = std::move(other);
        all.pads[0] = all.on[0] = 2;
        filled(all, seed, false);
        all.pads[1] = all.on[1] = 1;
        const std::vector<double> middles(9), axes = [] {
            std::vector<double> a;
            for (int i = 0; i < 3; ++i) a.insert(a.end(), Grip::upright.begin(), Grip::upright.end());
            return a;
        }();
        batch.add({middles.data(), axes.data()}, all.contacts(), all.shapes());
        CHECK(std::memcmp(batch.pressure() + one.cells(), one.touch.pressure(), sizeof(float) * size_t(one.cells())) ==
              0);
        for (int axis = 0; axis < 2; ++axis)
            CHECK(std::memcmp(batch.traction() + (3 * axis + 1) * one.cells(),
                              one.touch.traction() + axis * one.cells(), sizeof(float) * size_t(one.cells())) == 0);
    }
}

TEST_CASE("Shapes, images and borders that a Touch cannot take are refused by their own name and number") {
    const auto refused = [](const auto& call) -> std::string {
        try {
            call();
        } catch (const dermis::Error& e) {
            return e.what();
        }
        return "";
    };
    const auto of_shape = [&](const auto& change) {
        Grip s(8, 8, 1e-3);
        s.shape(Body::Kind::hull, {6, 0, 0}, {0, 0, 1e-3}), s.push({0, 0, 0}, {0, 0, -1});
        s.faces = {1, 0, 0, 1, -1, 0, 0, 1, 0, 1, 0, 1, 0, -1, 0, 1, 0, 0, 1, 1, 0, 0, -1, 1};
        change(s);
        return refused([&] { s.press(); });
    };
    CHECK(of_shape([](Grip&) {}) == "");
    CHECK(of_shape([](Grip& s) { s.turns[4] = 2; }) == "shapes.rotation[0] = 2; allowed: -1.001..1.001");
    CHECK(of_shape([](Grip& s) { s.places[2] = 1e7; }) == "shapes.position[0] = 1e+07; allowed: -1e6..1e6");
    CHECK(of_shape([](Grip& s) { s.sizes[0] = 3; }).find("shapes.size[0] = 3, 0, 0; allowed: of a hull") == 0);
    // Both neighbours would carry the whole force.
    CHECK(of_shape([](Grip& s) {
              s.touch = Touch({.width = 8, .height = 8, .spacing = 1e-3, .tiled = true}, 1, 1e-3, false, {stiffness});
          }).find("shapes.count = 1; allowed: 0 on tiled pads") == 0);

    Touch two({.width = 4, .height = 2, .spacing = 1e-3}, 2, 1e-3, false, {stiffness});
    std::vector<double> depth(1008), force = {0, 0, -1, 0, 0, -1};
    const auto of_images = [&](double& changed, double to) {
        const double before = std::exchange(changed, to);
        const std::string words =
            refused([&] { two.add({.depth = depth.data(), .force = force.data(), .depth_step = 1000}); });
        changed = before;
        return words;
    };
    CHECK(of_images(depth[8], NAN) == ""); // between two images
    CHECK(of_images(depth[1002], NAN) == "images.depth[1002] = nan; allowed: -1e6..1e6");
    CHECK(of_images(force[4], 1e13) == "images.force[1] = 0, 1e+13, -1; allowed: -1e12..1e12");
    CHECK(refused([] {
              Grip(24, 24, 5e-4, {stiffness, {0, 8, 0, 0}});
          }) == "source.around[1] = 8; allowed: -0.012..0.512 m: less the pad, 1024 cells or the pad once more");
    const double quarter_turn = 0.5 * (pi * 0.01 - 24 * 5e-4); // the pad's arc is in its middle
    Grip(24, 24, 5e-4, {stiffness, {0, 0.999 * quarter_turn, 0, 0}}, 0.01);
    CHECK(refused([&] {
              Grip(24, 24, 5e-4, {stiffness, {0, 1.001 * quarter_turn, 0, 0}}, 0.01);
          }).ends_with("a quarter turn"));
}

TEST_CASE("If memory fails for the shapes of a call, or for images, the pressures of the call before stay; later calls "
          "need none") {
    Grip s(16, 16, 1e-3, {stiffness, {3e-3, 0, 0, 0}}, 0, true);
    s.push({0, 0, 0}, {0, 0, -1}, -1);
    s.press();
    const std::vector<float> before(s.touch.pressure(), s.touch.pressure() + s.cells()), image(256, 1e-3f);
    for (int part = 0; part < 3; ++part) {
        s.shape(Body::Kind::box, {4e-3, 6e-3, 5e-3}, {2e-3 * part, 0, 5e-3}, Grip::upright, part);
        s.push({2e-3 * part, 1e-3, 0}, {0.1, 0, -1}, part);
    }
    const Contacts contacts = s.contacts();
    const Shapes shapes = s.shapes();
    const Vector force = {0, 0, -1};
    const auto press = [&](int kind) {
        if (kind == 0) s.touch.add({Grip::origin.data(), Grip::upright.data()}, contacts, shapes);
        else s.touch.add({.depth = image.data(), .force = force.data()});
    };
    if (!test::allocations_fail()) return;
    for (const int kind : {0, 1}) {
        int failed = 0;
        for (long k = 0; k < 100; ++k) {
            bool struck = false, thrown = false;
            {
                test::FailingAllocation fails(k, false);
                try {
                    press(kind);
                } catch (const dermis::Error& e) {
                    thrown = e.code() == dermis::Error::Code::no_memory;
                }
                struck = fails.struck();
            }
            CHECK(struck == thrown);
            if (!struck) break;
            ++failed;
            CHECK(std::memcmp(before.data(), s.touch.pressure(), sizeof(float) * before.size()) == 0);
        }
        CHECK(failed > 1);
        const size_t allocated = test::allocations();
        press(kind);
        CHECK(test::allocations() == allocated);
        if (kind == 0) { // back to the first call
            Grip first(16, 16, 1e-3);
            first.push({0, 0, 0}, {0, 0, -1}, -1);
            s.touch.add({Grip::origin.data(), Grip::upright.data()}, first.contacts());
        }
    }
}

TEST_CASE("Loops over cells have the same bits with every instruction set") {
    Random random;
    for (int draw = 0; draw < 200; ++draw) {
        const int width = 1 + int(random.bits() % 40), height = 1 + int(random.bits() % 90),
                  pitch = (width + 7) / 8 * 8;
        const size_t cells = size_t(pitch) * size_t(height);
        LineRow lines{};
        const double quaternion[] = {random.within(-1, 1), random.within(-1, 1), random.within(-1, 1), 1},
                     origin[] = {0, 0, 0};
        const Pose turn = Pose::from_quaternion(origin, quaternion);
        lines.flat = draw % 2 == 0, lines.deepest = 1e6;
        for (size_t k = 0; k < 3; ++k) {
            lines.origin[k] = random.within(-0.02, 0.02);
            lines.step_x[k] = 1e-3 * turn.rotation[3 * k], lines.step_y[k] = 1e-3 * turn.rotation[3 * k + 1];
            lines.down[k] = -turn.rotation[3 * k + 2];
            for (int i = 0; i < width; ++i) { // of a surface that is round
                const double angle = 0.02 * (i - 20);
                lines.from[k][i] = lines.origin[k] + i * lines.step_x[k];
                lines.along[k][i] = std::cos(angle) * lines.down[k] + std::sin(angle) * turn.rotation[3 * k];
            }
        }
        const double faces[] = {1, 0,  0, 0.02, -1, 0, 0, 0.02, 0, 1, 0,  0.01,
                                0, -1, 0, 0.01, 0,  0, 1, 0.03, 0, 0, -1, 0.03};
        lines.faces = faces, lines.face_count = 6;
        const double size[] = {random.within(5e-3, 0.03), random.within(5e-3, 0.03), random.within(5e-3, 0.03)};
        const auto run = [&](const CellLoops& l) {
            std::vector<double> deep(cells, not_below);
            std::vector<float> depth(cells), share(cells), excess(cells), pad(size_t(width) * size_t(height)), x = pad,
                                                                                                               y = pad;
            l.deepen(draw % 7, size, lines, {0, 0, width, height, size_t(pitch)}, deep.data());
            const double deepest = l.settle(deep.data(), cells, depth.data(), share.data());
            const BedCells bed{width, height, size_t(pitch), depth.data(), share.data()};
            double n, e;
            Sums sums;
            l.level(bed, 1e-3f, 1, &n, &e);
            l.sums(bed, {1e-3, 1e-5, -2e-5}, &sums);
            const double sum = l.write(bed, {1e-3, 1e-5, -2e-5}, excess.data());
            const Gained g = l.add({width, height, size_t(width), size_t(pitch), excess.data(), 3.7f, pad.data(),
                                    x.data(), y.data(), 0.1f, 0.2f, 0.03f});
            std::string bytes;
            const auto keep = [&](const void* from, size_t count) {
                bytes.append(static_cast<const char*>(from), count);
            };
            for (const auto* v : {&depth, &share, &excess, &pad, &x, &y}) keep(v->data(), v->size() * sizeof(float));
            for (const double d : {deepest, n, e, sum, g.pressed, g.x, g.y, g.placed, double(g.greatest),
                                   double(g.cells), double(g.left), double(g.right), double(g.top), double(g.bottom)})
                keep(&d, sizeof d);
            keep(deep.data(), deep.size() * sizeof(double)), keep(&sums, sizeof sums);
            return bytes;
        };
        CHECK(run(plain_loops) == run(loops()));
    }
}

TEST_CASE("Loops name every cell that a number which is none has reached, so that it is taken away") {
    for (const CellLoops* l : {&plain_loops, &loops()}) {
        const std::vector<float> pressure = {0, 0, 0, NAN, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0};
        std::vector<float> pad(16), x(16), y(16);
        const Gained g = l->add({8, 2, 8, 8, pressure.data(), 1, pad.data(), x.data(), y.data(), INFINITY, NAN, 0});
        CHECK(g.left == 2);
        CHECK(g.right == 3);
        CHECK(g.top == 0);
        CHECK(g.bottom == 1);
        for (size_t i = 0; i < 16; ++i) CHECK(std::isfinite(x[i] + y[i]) == (pressure[i] == 0));
    }
}
