// SPDX-License-Identifier: MIT
// Contacts, depths and taxels become pressure: the force is kept, and shapes are those of closed forms.
#include "tests/allocations.hpp"
#include "tests/contacts.hpp"
#include "tests/expected.hpp"

#include <cfenv>
#include <limits>

using namespace dermis::contact;
using namespace test::contacts;
using test::absolute;
using test::relative;

namespace {

// Contacts whose patches are on the pad, from below one cell to a fifth of it.
std::vector<Contact> contacts_inside(Random& random, const Pad& pad, int count) {
    std::vector<Contact> contacts;
    const double width = pad.width * pad.spacing, height = pad.height * pad.spacing;
    for (int i = 0; i < count; ++i) {
        const double radius = random.unit() * std::min(width, height) / 5;
        contacts.push_back(at(random.within(radius, width - radius), random.within(radius, height - radius),
                              random.decades(-4, 1), radius));
    }
    return contacts;
}

// A rotation by any angle about any axis.
Pose any_pose(Random& random) {
    double position[3], quaternion[4];
    for (double& p : position) p = random.within(-2, 2);
    for (double& q : quaternion) q = random.within(-1, 1);
    return Pose::from_quaternion(position, quaternion);
}

std::array<double, 3> to_world(const Pose& pose, double x, double y, double z, bool direction = false) {
    std::array<double, 3> p = {0, 0, 0};
    for (size_t k = 0; k < 3; ++k)
        p[k] = (direction ? 0 : pose.position[k]) + pose.rotation[3 * k] * x + pose.rotation[3 * k + 1] * y +
               pose.rotation[3 * k + 2] * z;
    return p;
}

// A ball that sinks into the middle, with gaps around it.
std::vector<float> ball(const Pad& pad, double radius, double depth) {
    std::vector<float> depths;
    for (int y = 0; y < pad.height; ++y)
        for (int x = 0; x < pad.width; ++x) {
            const double dx = (x + 0.5 - pad.width / 2.0) * pad.spacing,
                         dy = (y + 0.5 - pad.height / 2.0) * pad.spacing;
            depths.push_back(float(depth - (dx * dx + dy * dy) / (2 * radius)));
        }
    return depths;
}

// The message of a refusal, before which nothing was written.
template <class Call> std::string refusal(const Buffer& b, Call&& call) {
    const std::vector<float> before = b.pressure;
    try {
        call();
    } catch (const dermis::Error& e) {
        CHECK(b.pressure == before);
        return e.what();
    }
    FAIL_CHECK("accepted");
    return "";
}

} // namespace

TEST_CASE("contacts on a pad keep their force to 1e-6, at any size of pad, patch and force") {
    Random random;
    for (int trial = 0; trial < 300; ++trial) {
        CAPTURE(trial);
        Buffer b(1 + int(random.unit() * 90), 1 + int(random.unit() * 90), random.decades(-5, -2));
        const std::vector<Contact> contacts = contacts_inside(random, b.pad, 1 + trial % 10);
        double asked = 0;
        for (const Contact& c : contacts) asked += c.force;
        const ContactReport r = add_contacts(b.pad, contacts);
        CHECK(r.asked == relative(asked, 1e-12));
        CHECK(r.placed == relative(b.force(), 1e-12));
        CHECK(std::abs(r.outside) < 1e-12 * asked);
        CHECK(r.sideways == 0);
        CHECK(b.force() == relative(asked, 1e-6));
        CHECK(r.cells == b.pressed());
        CHECK(r.greatest == *std::max_element(b.pressure.begin(), b.pressure.end()));
    }
}

TEST_CASE("a patch has Hertz's profile at the centres of cells, and his peak where it is many cells wide") {
    Buffer b(120, 100);
    const double x = 0.0149, y = 0.0123, radius = 0.01, force = 2;
    add_contacts(b.pad, {at(x, y, force, radius)});
    const double peak = 1.5 * force / (pi * radius * radius); // of the integral of the profile
    double sum = 0;
    for (int j = 0; j < 100; ++j)
        for (int i = 0; i < 120; ++i) {
            const double r = std::hypot((i + 0.5) * quarter - x, (j + 0.5) * quarter - y) / radius;
            sum += r < 1 ? std::sqrt(1 - r * r) : 0;
        }
    const double normalized = force / (sum * quarter * quarter);
    CHECK(normalized == relative(peak, 1e-3));
    for (int j = 0; j < 100; ++j)
        for (int i = 0; i < 120; ++i) {
            const double r = std::hypot((i + 0.5) * quarter - x, (j + 0.5) * quarter - y) / radius;
            const double expected = r < 1 ? normalized * std::sqrt(1 - r * r) : 0;
            REQUIRE(std::abs(b.of(i, j) - expected) < 1e-6 * peak);
        }
}

TEST_CASE(
    "from two cells on a patch has its middle to 0.02 cell and its second moment to 3 %, wherever in a cell it is") {
    for (double radius : {2.0, 2.5, 3.0, 5.0, 7.9, 8.0, 12.0})
        for (int trial = 0; trial < 12 * 12; ++trial) {
            const double x = 20 + trial % 12 / 12.0, y = 20 + trial / 12 / 12.0;
            Buffer b(40, 40);
            add_contacts(b.pad, {at(x * quarter, y * quarter, 1, radius * quarter)});
            double sum = 0, along_x = 0, along_y = 0, square = 0;
            for (int j = 0; j < 40; ++j)
                for (int i = 0; i < 40; ++i) {
                    const double dx = i + 0.5 - x, dy = j + 0.5 - y, p = b.of(i, j);
                    sum += p, along_x += p * dx, along_y += p * dy, square += p * (dx * dx + dy * dy);
                }
            CAPTURE(radius);
            CAPTURE(trial);
            CHECK(std::hypot(along_x, along_y) / sum < 0.02);
            CHECK(square / sum == relative(0.4 * radius * radius, 0.03)); // of Hertz's profile
        }
}

TEST_CASE("an area is a radius, and Hertz's radius of a ball gives Hertz's peak") {
    Buffer by_radius(60, 60), by_area(60, 60);
    Contact c = at(0.0071, 0.0069, 0.3, 0.004);
    add_contacts(by_radius.pad, {c});
    c.area = pi * 0.004 * 0.004, c.radius = 0;
    add_contacts(by_area.pad, {c});
    CHECK(difference(by_area.pressure, by_radius.pressure) < 1e-6);

    // p0 = (6 F E*^2/(pi^3 R^2))^(1/3)
    const double force = 0.5, radius = 0.008, modulus = 1e5,
                 peak = std::cbrt(6 * force * modulus * modulus / (pi * pi * pi * radius * radius));
    Buffer b(200, 200, 1e-4);
    const ContactReport r = add_contacts(b.pad, {at(0.01005, 0.01005, force, hertz_radius(force, radius, modulus))});
    CHECK(r.greatest == relative(peak, 2e-3));
}

TEST_CASE("a patch that covers no cell's centre presses the nearest cell, and is reported") {
    for (double radius : {0.0, 1e-6, 0.3 * quarter}) {
        Buffer b(10, 8);
        const ContactReport r = add_contacts(b.pad, {at(7.2 * quarter, 2.9 * quarter, 1, radius)});
        CHECK(b.of(7, 2) == relative(1 / (quarter * quarter), 1e-6));
        CHECK(b.pressed() == 1);
        CHECK(r.below_cell == 1);
        CHECK_FALSE(r.plausible());
        CHECK(r.doubts().find("1 patch presses one cell alone") != std::string::npos);
        CHECK(r.doubts().find("1.6e+07 Pa, above 1e+06 Pa") != std::string::npos);
    }
    Buffer b(10, 8);
    CHECK(add_contacts(b.pad, {at(7.5 * quarter, 2.5 * quarter, 1e-6, 5e-324)}).placed == relative(1e-6, 1e-6));
    // One centre is covered, and carries all; then several, at a plausible pressure.
    CHECK(add_contacts(b.pad, {at(7.5 * quarter, 2.5 * quarter, 1e-3, 0.9 * quarter)}).below_cell == 1);
    const ContactReport wide = add_contacts(b.pad, {at(5 * quarter, 4 * quarter, 1e-3, 3 * quarter)});
    CHECK((wide.plausible() && wide.doubts() == ""));
    // The last cell is the last one; what is at the far border belongs to the next pad.
    CHECK(add_contacts(b.pad, {at(9.99 * quarter, 7.99 * quarter, 1, 0)}).placed == relative(1, 1e-6));
    CHECK(add_contacts(b.pad, {at(10 * quarter, 4 * quarter, 1, 0)}).beside == 1);
    CHECK(add_contacts(b.pad, {at(-1e-9, 4 * quarter, 1, 0)}).beside == 1);
    CHECK(add_contacts(b.pad, {at(1e6, -1e6, 1, 1)}).outside == 1);
}

TEST_CASE("two pads side by side share a patch as one pad carries it; each reports the rest as outside") {
    Random random;
    for (double cells : {0.4, 1.5, 7.0, 30.0, 200.0}) {
        CAPTURE(cells);
        const double x = random.within(38, 42) * quarter, y = 25.3 * quarter;
        Buffer whole(80, 50), left(40, 50), right(40, 50);
        const ContactReport all = add_contacts(whole.pad, {at(x, y, 2, cells * quarter)});
        const ContactReport l = add_contacts(left.pad, {at(x, y, 2, cells * quarter)});
        const ContactReport r = add_contacts(right.pad, {at(x - 40 * quarter, y, 2, cells * quarter)});
        std::vector<float> joined;
        for (int row = 0; row < 50; ++row)
            for (const Buffer* part : {&left, &right})
                joined.insert(joined.end(), part->pad.pressure + row * 40, part->pad.pressure + row * 40 + 40);
        CHECK(difference(joined, whole.pressure) < 1e-6);
        CHECK(l.placed + r.placed == relative(all.placed, 1e-6));
        for (const auto& [report, buffer] : {std::pair{l, &left}, {r, &right}}) {
            CHECK(report.placed + report.outside == relative(2, 1e-6));
            CHECK(std::abs(buffer->force() - report.placed) < 2e-6);
        }
    }
    // Half of a patch in the middle of an edge, from the sum up to 128 cells, from the integral beyond: as many cells.
    for (double cells : {100.0, 127.9, 128.1, 300.0}) {
        Buffer b(400, 700);
        const ContactReport r = add_contacts(b.pad, {at(0, 350.2 * quarter, 1, cells * quarter)});
        CHECK(r.placed == relative(0.5, 1e-4));
        CHECK(b.force() == relative(r.placed, 1e-6));
    }
}

TEST_CASE("contacts in the world press as they do in the pad's frame, however both are moved") {
    Random random;
    for (int trial = 0; trial < 50; ++trial) {
        CAPTURE(trial);
        Buffer local(64, 48), world(64, 48);
        const std::vector<Contact> contacts = contacts_inside(random, local.pad, 6);
        const Pose pose = any_pose(random);
        std::vector<WorldContact> moved;
        for (const Contact& c : contacts) {
            WorldContact w;
            w.position = to_world(pose, c.x, c.y, random.within(-1e-3, 1e-3));
            w.force = c.force, w.radius = c.radius;
            if (trial % 2) w.direction = to_world(pose, 0, 0, -random.decades(-3, 3), true);
            moved.push_back(w);
        }
        const ContactReport l = add_contacts(local.pad, contacts), w = add_contacts(world.pad, pose, 1.001e-3, moved);
        CHECK(difference(world.pressure, local.pressure) < 1e-6);
        CHECK(w.placed == relative(l.placed, 1e-6));
        CHECK(std::abs(w.sideways) < 1e-9 * w.asked);
        CHECK(w.too_far + w.turned_away + w.beside == 0);
    }
}

TEST_CASE(
    "contacts too far, turned away or beside the pad are counted; an oblique force presses with its part inward") {
    Random random;
    Buffer b(40, 40);
    const Pose pose = any_pose(random);
    const auto world = [&](double x, double y, double z, std::array<double, 3> direction) {
        WorldContact w;
        w.position = to_world(pose, x, y, z);
        w.force = 1, w.radius = 1e-3;
        w.direction = to_world(pose, direction[0], direction[1], direction[2], true);
        return w;
    };
    const ContactReport r = add_contacts(b.pad, pose, 2e-3,
                                         {world(0.005, 0.005, 0.0021, {0, 0, -1}), // too far
                                          world(0.005, 0.005, -0.0021, {0, 0, 1}), // too far, and away
                                          world(0.005, 0.005, 0, {0, 0, 1}), world(0, 0.005, 0, {1, 0, 1e-12}), // away
                                          world(0.5, 0.005, 0, {0, 0, -1}), // beside
                                          world(0.005, 0.005, 0, {0.6, 0, -0.8})});
    CHECK(r.too_far == 2);
    CHECK(r.turned_away == 2);
    CHECK(r.beside == 1);
    CHECK(r.asked == 6);
    CHECK(r.outside == relative(5, 1e-9));
    CHECK(r.placed == relative(0.8, 1e-6));
    CHECK(r.sideways == relative(0.2, 1e-9));
    CHECK(b.force() == relative(0.8, 1e-6));
}

TEST_CASE("a direction as short as doubles can be, or almost along the pad, leaves finite tractions") {
    Buffer b(16, 16);
    std::vector<float> x(256), y(256);
    b.pad.shear_x = x.data(), b.pad.shear_y = y.data();
    for (const std::array<double, 3>& direction :
         {std::array{1e-310, 0.0, -1e-310}, std::array{5e-324, 0.0, 0.0}, std::array{1.0, 0.0, -1e-310}}) {
        const WorldContact c{.position = {2e-3, 2e-3, 0}, .force = 1, .radius = 1e-3, .direction = direction};
        const ContactReport r = add_contacts(b.pad, Pose(), 1e-3, {c});
        CHECK(std::isfinite(r.shear[0]));
        for (size_t i = 0; i < 256; ++i) REQUIRE(std::isfinite(x[i] + y[i] + b.pressure[i]));
    }
}

TEST_CASE("in each cell the traction is the pressure times the slope of the force, of few patches and of many, "
          "whatever their size") {
    for (const int count : {1, 40})
        for (const double radius : {0.0, 0.3 * quarter, 2.5 * quarter, 9 * quarter}) {
            Buffer b(32, 30);
            std::vector<float> x(b.pressure.size()), y(b.pressure.size());
            b.pad.shear_x = x.data(), b.pad.shear_y = y.data();
            const WorldContact c{
                .position = {4.1e-3, 3.8e-3, 0}, .force = 1, .radius = radius, .direction = {2, -1, -4}};
            const ContactReport r = add_contacts(b.pad, Pose(), 1e-3, std::vector<WorldContact>(size_t(count), c));
            CHECK(b.force() == relative(r.placed, 1e-5));
            for (size_t i = 0; i < x.size(); ++i) {
                REQUIRE(double(x[i]) == relative(0.5 * double(b.pressure[i]), 3e-6));
                REQUIRE(double(y[i]) == relative(-0.25 * double(b.pressure[i]), 3e-6));
            }
        }
}

TEST_CASE("a pose is the same from a matrix, a quaternion, and the middle of a pad") {
    // A quarter turn about z: the pad's x axis is the world's y axis.
    const double position[] = {1, 2, 3}, matrix[] = {0, -1, 0, 1, 0, 0, 0, 0, 1}, quaternion[] = {3, 0, 0, 3};
    const Pose a = Pose::from_matrix(position, matrix), b = Pose::from_quaternion(position, quaternion);
    for (size_t k = 0; k < 9; ++k) CHECK(a.rotation[k] == absolute(b.rotation[k], 1e-15));
    Buffer pad(40, 20);
    const Pose corner = a.from_middle(pad.pad);
    CHECK(corner.position[0] == relative(1 + 10 * quarter, 1e-12));
    CHECK(corner.position[1] == relative(2 - 20 * quarter, 1e-12));
    CHECK(corner.position[2] == 3);
    WorldContact middle;
    middle.position = {1, 2, 3}, middle.force = 1, middle.radius = 4.2 * quarter;
    add_contacts(pad.pad, corner, 0, {middle});
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 40; ++x) REQUIRE(pad.of(x, y) == relative(pad.of(39 - x, 19 - y), 1e-6));
}

TEST_CASE("depths press in proportion, and with the force that is given") {
    Buffer b(64, 80);
    const std::vector<float> depth = ball(b.pad, 0.01, 1e-3);
    const ContactReport r = add_depths(b.pad, depths_of(depth, 1.5));
    CHECK(b.force() == relative(1.5, 1e-6));
    CHECK(r.placed == relative(1.5, 1e-6));
    CHECK(r.level == 0);
    CHECK(r.cells == b.pressed());
    // A paraboloid of depth d and radius R has the volume pi R d^2.
    CHECK(r.greatest == relative(1.5 * 1e-3 / (pi * 0.01 * 1e-6), 1e-2));
    const double scale = b.of(32, 40) / double(depth[40 * 64 + 32]);
    for (size_t i = 0; i < depth.size(); ++i)
        REQUIRE(b.pressure[i] == relative(scale * std::max(0.0, double(depth[i])), 1e-6));

    const std::vector<float> gaps(64 * 80, -1.0f);
    CHECK(add_depths(b.pad, depths_of(gaps, 2)).outside == 2);
}

TEST_CASE("with a stiffness depths press at the level where the elastic foundation carries the force") {
    Random random;
    const double radius = 0.01, stiffness = 1e8;
    for (double force : {1e-9, 1e-3, 0.1, 1.0, 3.0, 30.0}) {
        CAPTURE(force);
        Buffer b(200, 200, 1e-4);
        const std::vector<float> depth = ball(b.pad, radius, 1e-3);
        const ContactReport r = add_depths(b.pad, depths_of(depth, force, stiffness));
        CHECK(b.force() == relative(force, 1e-6));
        for (size_t i = 0; i < depth.size(); ++i)
            REQUIRE(std::abs(b.pressure[i] - stiffness * std::max(0.0, double(depth[i]) - r.level)) <
                    1e-6 * r.greatest + 1e-9 * stiffness * 1e-3);
        // A ball that sinks to d needs pi K R d^2.
        if (force >= 0.1 && force <= 3)
            CHECK(1e-3 - r.level == relative(std::sqrt(force / (pi * stiffness * radius)), 1e-2));
    }
    // Depths of any kind, gaps of a metre among them, and forces from next to nothing up.
    for (int trial = 0; trial < 200; ++trial) {
        CAPTURE(trial);
        Buffer b(1 + int(random.unit() * 40), 1 + int(random.unit() * 40));
        std::vector<float> depth;
        for (size_t i = 0; i < b.pressure.size(); ++i)
            depth.push_back(random.unit() < 0.3 ? -1.0f : float(random.within(-1, 1) * random.decades(-6, -2)));
        const double force = random.decades(-12, 3);
        const ContactReport r = add_depths(b.pad, depths_of(depth, force, random.decades(-6, 12)));
        REQUIRE(b.force() == relative(force, 1e-6));
        REQUIRE(r.placed == relative(b.force(), 1e-12));
        REQUIRE(std::isfinite(r.level));
    }
}

TEST_CASE("the level of depths in steps is found at every force, also where a step is just about to be pressed") {
    Random random;
    for (int draw = 0; draw < 4000; ++draw) {
        Buffer b(8, 1, 1e-3);
        const double step = random.decades(-6, -2), stiffness = 1e6;
        std::vector<double> depth;
        for (int i = 0; i < 8; ++i) depth.push_back(i * step);
        double force = 0; // at which the deepest cells are pressed to the depth of the next one
        for (int i = 0, to = 1 + draw % 7; i < to; ++i) force += (to - i) * step * stiffness * 1e-6;
        for (int away = draw % 5 - 2; away != 0; away += away > 0 ? -1 : 1)
            force = std::nextafter(force, away > 0 ? 1.0 : 0.0);
        const ContactReport r = add_depths(b.pad, {.depth = depth.data(), .force = force, .stiffness = stiffness});
        REQUIRE(r.placed == relative(force, 1e-6));
    }
}

TEST_CASE("taxels keep their force, whichever of taxel and cell is finer") {
    Random random;
    for (int trial = 0; trial < 200; ++trial) {
        CAPTURE(trial);
        Buffer b(1 + int(random.unit() * 60), 1 + int(random.unit() * 60));
        const int columns = 1 + int(random.unit() * 20), rows = 1 + int(random.unit() * 20);
        std::vector<float> values;
        for (int i = 0; i < columns * rows; ++i) values.push_back(float(random.unit()));
        // On the pad, of which they cover all or a half.
        const double share = trial % 2 ? 1 : 0.5;
        TaxelReadings t = taxels_of(values, columns, rows, share * b.pad.width * quarter / columns,
                                    share * b.pad.height * quarter / rows);
        t.x = (1 - share) * random.unit() * b.pad.width * quarter;
        t.y = (1 - share) * random.unit() * b.pad.height * quarter;
        double force = std::accumulate(values.begin(), values.end(), 0.0);
        if (trial % 3 == 0) {
            t.unit = TaxelReadings::Unit::pascal;
            force *= t.width * t.height;
        }
        const ContactReport r = add_taxels(b.pad, t);
        CHECK(r.asked == relative(force, 1e-12));
        CHECK(r.placed == relative(b.force(), 1e-12));
        CHECK(b.force() == relative(force, 1e-6));
        if (share == 1 && force > 0) CHECK(r.cells == int(b.pressure.size()));
    }
}

TEST_CASE("a taxel presses the cells below it evenly, at its pressure; what overhangs is reported") {
    Buffer b(12, 8);
    std::vector<float> values = {100, 200, 300, 400, 500, 600};
    TaxelReadings t = taxels_of(values, 3, 2, 1e-3, 1e-3); // of 4 x 4 cells, without a cell between two of them
    t.unit = TaxelReadings::Unit::pascal;
    add_taxels(b.pad, t);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 12; ++x) REQUIRE(b.of(x, y) == 100 * (1 + x / 4 + 3 * (y / 4)));

    // Column by column in memory.
    Buffer turned(12, 8);
    std::vector<float> by_column = {100, 400, 200, 500, 300, 600};
    t.values = by_column.data(), t.column_step = 2, t.row_step = 1;
    add_taxels(turned.pad, t);
    CHECK(turned.pressure == b.pressure);

    // Half of the first column and all of the last are beside the pad.
    Buffer moved(10, 8);
    t.x = -0.5e-3, t.width = 1.5e-3;
    const ContactReport r = add_taxels(moved.pad, t);
    CHECK(moved.of(0, 0) == 100);
    CHECK(moved.of(3, 7) == 400);
    CHECK(moved.of(9, 7) == 500);
    CHECK(r.beside == 2);
    CHECK(r.outside == relative((100 + 400) * 0.5e-6 + (300 + 600) * 1.5e-6, 1e-9));
    CHECK(moved.force() == relative(r.placed, 1e-6));
}

TEST_CASE("a taxel that ends on the pad's border is beside the pad, however its place is rounded") {
    Random random;
    for (int draw = 0; draw < 2000; ++draw) {
        const double spacing = random.decades(-5, -2), width = random.decades(-1, 1) * spacing;
        Buffer b(12, 8, spacing);
        const std::vector<float> values(6, 1.0f);
        TaxelReadings t = taxels_of(values, 3, 2, width, width);
        t.x = draw % 2 ? -3 * width : 12 * spacing, t.y = spacing;
        const ContactReport r = add_taxels(b.pad, t);
        CHECK(r.beside == 6);
        CHECK(r.outside == 6);
    }
}

TEST_CASE("rows of a buffer may lie farther apart, and what lies between them is not touched") {
    Random random;
    Buffer dense(31, 17), wide(40, 17);
    Pad pad = dense.pad;
    pad.pressure = wide.pressure.data(), pad.pitch = 40;
    const std::vector<Contact> contacts = contacts_inside(random, pad, 5);
    const std::vector<float> depth = ball(wide.pad, 0.01, 1e-3), values(6, 1.0f);
    std::vector<float> copied;
    for (int y = 0; y < 17; ++y) copied.insert(copied.end(), &depth[y * 40], &depth[y * 40 + 31]);
    DepthMap strided = depths_of(depth, 1, 1e8);
    strided.pitch = 40;
    add_contacts(dense.pad, contacts), add_contacts(pad, contacts);
    add_depths(dense.pad, depths_of(copied, 1, 1e8)), add_depths(pad, strided);
    add_taxels(dense.pad, taxels_of(values, 3, 2, 1e-3, 1e-3)), add_taxels(pad, taxels_of(values, 3, 2, 1e-3, 1e-3));
    for (int y = 0; y < 17; ++y)
        for (int x = 0; x < 40; ++x) REQUIRE(wide.of(x, y) == (x < 31 ? dense.of(x, y) : 0));
}

TEST_CASE("depths and taxels in double press with the bits of the same numbers in float, and are checked alike") {
    Buffer b(31, 17), other(31, 17);
    const std::vector<float> depth = ball(b.pad, 0.02, 1e-3), values = {1, 0.2f, 3, 0.4f, 5, 6};
    std::vector<double> of_depth(depth.begin(), depth.end()), of_values(values.begin(), values.end());
    DepthMap map = depths_of(depth, 1, 1e8);
    TaxelReadings taxels = taxels_of(values, 3, 2, 1e-3, 1e-3);
    add_depths(b.pad, map), add_taxels(b.pad, taxels);
    map.depth = of_depth.data(), taxels.values = of_values.data();
    add_depths(other.pad, map), add_taxels(other.pad, taxels);
    CHECK(b.pressure == other.pressure);
    of_depth[33] = std::numeric_limits<double>::infinity(), of_values[4] = -1e-300;
    CHECK(refusal(b, [&] { add_depths(b.pad, map); }) == "depths.depth[2, 1] = inf; allowed: -1e6..1e6");
    CHECK(refusal(b, [&] { add_taxels(b.pad, taxels); }) ==
          "taxels.values[4] = -1e-300; allowed: a finite number >= 0");
    of_depth.assign(of_depth.size(), 0), of_depth[5] = 1e-308, of_values[4] = 1e39; // pressures beyond float
    taxels.unit = TaxelReadings::Unit::pascal, map.stiffness = 0;
    CHECK(refusal(b, [&] { add_depths(b.pad, map); }) ==
          "depths.depth = 1e-308; allowed: depths that add up to more than 1e-290 m");
    CHECK(refusal(b, [&] { add_taxels(b.pad, taxels); }) == "taxels.values[4] = 1e+39; allowed: 0..3.4e38");
}

TEST_CASE("a rounding mode of the caller changes no pressure and no depth") {
    const auto pressed = [](int mode) {
        Random random;
        Buffer b(64, 80);
        const std::vector<float> depth = ball(b.pad, 0.01, 1e-3), values = {0.7f};
        std::vector<float> of_body(depth.size());
        const std::vector<Contact> contacts = contacts_inside(random, b.pad, 30);
        const Pose pose = any_pose(random);
        const WorldContact in_world{to_world(pose, 3e-3, 4e-3, 1e-4), 0.3, 1e-3, 0, {0.1, 0.2, -1}};
        const Body body{Body::Kind::capsule, {1e-2, 2e-2, 0}, pose};
        const double place[] = {0.1, 0.2, 0.3}, quaternion[] = {0.5, 0.1, 0.7, 0.3};
        std::fesetround(mode);
        const Pose made = Pose::from_quaternion(place, quaternion).from_middle(b.pad);
        add_contacts(b.pad, contacts);
        add_contacts(b.pad, pose, 0.1, {in_world});
        add_depths(b.pad, depths_of(depth, 1, foundation_stiffness(1, 0.01, 1e5)));
        add_taxels(b.pad, taxels_of(values, 1, 1, hertz_radius(1, 0.01, 1e5), 1e-3));
        fill_depths(b.pad, pose.from_middle(b.pad), body, of_body.data());
        std::fesetround(FE_TONEAREST);
        b.pressure.insert(b.pressure.end(), of_body.begin(), of_body.end());
        return std::pair(b.pressure, std::pair(made.position, made.rotation));
    };
    const auto nearest = pressed(FE_TONEAREST);
    for (int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) CHECK(pressed(mode) == nearest);
}

TEST_CASE("adding allocates nothing") {
    Random random;
    Buffer b(64, 80);
    const std::vector<Contact> contacts = contacts_inside(random, b.pad, 10);
    const std::vector<WorldContact> world(3);
    const std::vector<float> depth = ball(b.pad, 0.01, 1e-3), values(6, 1.0f);
    const size_t before = test::allocations();
    add_contacts(b.pad, contacts);
    add_contacts(b.pad, Pose(), 1e-3, world);
    add_depths(b.pad, depths_of(depth, 1, 1e8));
    add_taxels(b.pad, taxels_of(values, 3, 2, 1e-3, 1e-3));
    CHECK(test::allocations() == before);
}

TEST_CASE("a bad argument is refused with its name, value and range, and nothing is written") {
    Buffer b(8, 8);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const auto pad_with = [&](auto change) {
        Pad pad = b.pad;
        change(pad);
        return refusal(b, [&] { add_contacts(pad, {at(1e-3, 1e-3, 1, 1e-3)}); });
    };
    CHECK(pad_with([](Pad& p) { p.width = 0; }) == "pad.width = 0; allowed: 1..16384");
    CHECK(pad_with([](Pad& p) { p.spacing = 0; }) == "pad.spacing = 0; allowed: 1e-9..1e6");
    CHECK(pad_with([](Pad& p) { p.pressure = nullptr; }) == "pad.pressure = null; allowed: an address");
    CHECK(pad_with([](Pad& p) { p.pitch = 7; }) == "pad.pitch = 7; allowed: 0, or the pad's width = 8 .. 2^40");
    CHECK(pad_with([](Pad& p) { p.pitch = SIZE_MAX; }).find("pad.pitch = 18446744073709551615; allowed: 0, or") == 0);

    // The second contact is at fault: the first has not been added.
    const auto contact_with = [&](auto change) {
        std::vector<Contact> contacts(2, at(1e-3, 1e-3, 1, 1e-3));
        change(contacts[1]);
        return refusal(b, [&] { add_contacts(b.pad, contacts); });
    };
    CHECK(contact_with([](Contact& c) { c.radius = -1e-3; }) == "contacts[1].radius = -0.001; allowed: 0..1e6");
    CHECK(contact_with([](Contact& c) { c.area = 1e-6; }) ==
          "contacts[1].area = 1e-06; allowed: 0 beside a radius > 0");
    CHECK(contact_with([](Contact& c) { c.force = -1; }) == "contacts[1].force = -1; allowed: a finite number >= 0");
    CHECK(contact_with([&](Contact& c) { c.x = nan; }) == "contacts[1].x = nan; allowed: -1e6..1e6");
    CHECK(contact_with([](Contact& c) { c.force = 1e32; }) ==
          "force/spacing^2 = 1.6000000000000003e+39; allowed: at most 3.4e38 Pa, the greatest float");
    CHECK(refusal(b, [&] { add_contacts(b.pad, nullptr, 1); }) == "contacts = null; allowed: an address");
    CHECK(add_contacts(b.pad, nullptr, 0).asked == 0);

    const auto world_with = [&](double reach, auto change) {
        Pose pose;
        std::vector<WorldContact> contacts(1);
        change(pose, contacts[0]);
        return refusal(b, [&] { add_contacts(b.pad, pose, reach, contacts); });
    };
    CHECK(world_with(-1, [](Pose&, WorldContact&) {}) == "reach = -1; allowed: a finite number >= 0");
    CHECK(world_with(0, [](Pose&, WorldContact& c) { c.position[1] = INFINITY; }) ==
          "contacts[0].position = inf; allowed: -1e6..1e6");
    CHECK(world_with(0, [](Pose& p, WorldContact&) { p.rotation[0] = 0.9; }) ==
          "pose.rotation = a matrix whose columns' products are off by 0.18999999999999995; allowed: up to 1e-3");
    CHECK(world_with(0, [](Pose& p, WorldContact&) { p.rotation[8] = -1; }) ==
          "pose.rotation = a matrix of determinant -1; allowed: a rotation: determinant 1");
    const double zero[4] = {0, 0, 0, 0};
    CHECK(refusal(b, [&] { Pose::from_quaternion(zero, zero); }) == "|quaternion|^2 = 0; allowed: 1e-300..1e300");

    std::vector<float> depth(64, 1e-3f);
    CHECK(refusal(b, [&] { add_depths(b.pad, DepthMap()); }) == "depths.depth = null; allowed: an address");
    CHECK(refusal(b, [&] { add_depths(b.pad, depths_of(depth, -2)); }) ==
          "depths.force = -2; allowed: a finite number >= 0");
    depth[8 * 5 + 3] = nan;
    CHECK(refusal(b, [&] { add_depths(b.pad, depths_of(depth, 1)); }) ==
          "depths.depth[3, 5] = nan; allowed: -1e6..1e6");
    // The pad's memory is written while depths and taxels are read.
    const char* apart = " = memory of the pad; allowed: memory beside the pad's pressure, shear_x and shear_y";
    CHECK(refusal(b, [&] { add_depths(b.pad, {.depth = b.pad.pressure, .force = 1}); }) ==
          "depths.depth" + std::string(apart));
    CHECK(refusal(b, [&] {
              add_taxels(b.pad,
                         {.values = b.pad.pressure + 63, .columns = 1, .rows = 1, .width = 1e-3, .height = 1e-3});
          }) == "taxels.values" + std::string(apart));

    std::vector<float> values(6, 1.0f);
    const auto taxels_with = [&](auto change) {
        TaxelReadings t = taxels_of(values, 3, 2, 1e-3, 1e-3);
        change(t);
        return refusal(b, [&] { add_taxels(b.pad, t); });
    };
    CHECK(taxels_with([](TaxelReadings& t) { t.width = -1; }) == "taxels.width = -1; allowed: 1e-9..1e6");
    values[4] = -0.5f;
    CHECK(taxels_with([](TaxelReadings&) {}) == "taxels.values[4] = -0.5; allowed: a finite number >= 0");
}
