// SPDX-License-Identifier: MIT
// No part of a force is lost in silence: not in sums of many contacts and taxels, and not beside, above or across a
// pad.
#include "tests/contacts.hpp"
#include "tests/expected.hpp"

using namespace dermis::contact;
using namespace test::contacts;
using test::relative;

namespace {

// Whether the doubts about a report name a cause.
bool doubted(const ContactReport& r, const char* cause) {
    CAPTURE(r.doubts());
    CHECK_FALSE(r.plausible());
    return r.doubts().find(cause) != std::string::npos;
}

std::vector<float> random_values(size_t count) {
    Random random;
    std::vector<float> values(count);
    for (float& v : values) v = float(random.unit());
    return values;
}

WorldContact in_world(std::array<double, 3> position, double force, double radius) {
    WorldContact c;
    c.position = position, c.force = force, c.radius = radius;
    return c;
}

// A ball of 8 mm that touches a plane while it is rolled by an angle, with friction along the plane; a flat pad faces
// the plane where the angle is 0. The normal force is 1 N.
struct RolledBall {
    double angle, friction, radius; // rad; 1; m, of the patch

    WorldContact contact(bool with_direction) const {
        const double ball = 8e-3, s = std::sin(angle), c = std::cos(angle);
        WorldContact w = in_world({ball * s, 0, ball * (c - 1)}, 1, radius);
        if (!with_direction) return w;
        w.force = std::hypot(1, friction);
        w.direction = {-s + friction * c, 0, -c - friction * s};
        return w;
    }
};

struct Frames {
    int all = 0, doubted = 0;
    void count(bool doubt) { ++all, doubted += doubt; }
};

} // namespace

TEST_CASE("up to a million contacts on the same cells are placed to 1e-6, and as one contact presses them") {
    for (const auto& [count, radius] : {std::pair{17, 3e-3}, {1000, 3e-3}, {100000, 1e-3}, {1000000, 4e-4}}) {
        CAPTURE(count);
        Buffer many(64, 64), one(64, 64);
        const ContactReport r =
            add_contacts(many.pad, std::vector<Contact>(count, at(0.0081, 0.0079, 1.0 / count, radius)));
        CHECK(many.force() == relative(1, 1e-6));
        CHECK(r.placed == relative(many.force(), 1e-6));
        CHECK(r.cells == many.pressed());
        add_contacts(one.pad, {at(0.0081, 0.0079, 1, radius)});
        CHECK(difference(many.pressure, one.pressure) < 1e-6);
    }
    Buffer b(64, 64);
    const std::vector<WorldContact> world(100000, in_world({0.008, 0.008, 0}, 1e-5, 1e-3));
    CHECK(add_contacts(b.pad, Pose(), 1e-3, world).placed == relative(1, 1e-6));
    CHECK(b.force() == relative(1, 1e-6));
}

TEST_CASE("many contacts anywhere on a pad press and are reported as one at a time") {
    Random random;
    Buffer together(300, 150), apart(300, 150);
    std::vector<Contact> contacts;
    for (int i = 0; i < 200; ++i)
        contacts.push_back(at(random.within(-10, 310) * quarter, random.within(-10, 160) * quarter,
                              random.decades(-4, 0), random.unit() * 40 * quarter));
    contacts[3].radius = contacts[4].radius = 0;
    contacts[5].x = 1;
    const ContactReport r = add_contacts(together.pad, contacts);
    ContactReport sum;
    for (const Contact& c : contacts) {
        const ContactReport one = add_contacts(apart.pad, {c});
        sum.asked += one.asked, sum.outside += one.outside;
        sum.below_cell += one.below_cell, sum.beside += one.beside, sum.cells += one.cells;
    }
    CHECK(difference(together.pressure, apart.pressure) < 1e-5);
    CHECK(r.placed == relative(together.force(), 1e-9));
    CHECK(r.asked == relative(sum.asked, 1e-12));
    CHECK(r.outside == relative(sum.outside, 1e-12));
    CHECK(r.placed + r.outside == relative(r.asked, 1e-6));
    CHECK(r.below_cell == sum.below_cell);
    CHECK(r.beside == sum.beside);
    CHECK(r.cells == sum.cells);
}

TEST_CASE("taxels far finer than cells keep their force, millions on one cell too") {
    for (const auto& [count, cells] : {std::pair{1000, 1}, {2000, 4}, {2000, 1}}) {
        CAPTURE(count);
        Buffer b(cells, cells);
        const std::vector<float> values(size_t(count) * count, 1e-3f);
        const ContactReport r =
            add_taxels(b.pad, taxels_of(values, count, count, cells * quarter / count, cells * quarter / count));
        CHECK(b.force() == relative(double(1e-3f) * count * count, 1e-6));
        CHECK(r.placed == relative(b.force(), 1e-6));
        CHECK(r.outside < 1e-6 * r.asked);
    }
    // Six by six on each cell of a pad that is wider than a tile, moved by a row of cells.
    Buffer b(200, 100);
    const std::vector<float> values = random_values(1200 * 600);
    TaxelReadings t = taxels_of(values, 1200, 600, quarter / 6, quarter / 6);
    t.y = quarter;
    const ContactReport r = add_taxels(b.pad, t);
    CHECK(r.placed + r.outside == relative(r.asked, 1e-6));
    CHECK(r.placed == relative(b.force(), 1e-9));
    for (int y = 0; y < 99; ++y)
        for (int x = 0; x < 200; ++x) {
            double force = 0;
            for (int j = 0; j < 6; ++j)
                for (int i = 0; i < 6; ++i) force += double(values[size_t(6 * y + j) * 1200 + size_t(6 * x + i)]);
            REQUIRE(b.of(x, y + 1) * quarter * quarter == relative(force, 1e-6));
        }
}

TEST_CASE("taxels far smaller than their distance from the origin keep their force") {
    Buffer b(10001, 1, 100); // m
    const std::vector<float> values = random_values(1000);
    TaxelReadings t = taxels_of(values, 1000, 1, 1e-9, 50);
    t.x = 1e6 - 1e-6;
    const ContactReport r = add_taxels(b.pad, t);
    CHECK(b.force() == relative(std::accumulate(values.begin(), values.end(), 0.0), 1e-6));
    CHECK(r.placed == relative(b.force(), 1e-9));
}

TEST_CASE("call after call on the same cells, what is placed adds up to what the floats hold") {
    Buffer b(64, 64);
    double placed = 0, asked = 0;
    for (int i = 0; i < 100000; ++i) {
        const ContactReport r = add_contacts(b.pad, {at(0.008, 0.008, 1e-5, 5e-4)});
        placed += r.placed, asked += r.asked;
    }
    CHECK(placed == relative(b.force(), 1e-9));
    CHECK(asked == relative(1, 1e-9));
}

TEST_CASE("a force that vanishes beside what the buffer holds is not placed, and doubted") {
    Buffer b(64, 64);
    const std::vector<float> depth(64 * 64, 1e-3f), values(16, 1e-9f);
    std::fill(b.pressure.begin(), b.pressure.end(), 1e5f);
    for (const ContactReport& r :
         {add_contacts(b.pad, {at(0.008, 0.008, 1e-8, 3e-3)}), add_depths(b.pad, depths_of(depth, 1e-8)),
          add_taxels(b.pad, taxels_of(values, 4, 4, 4e-3, 4e-3))}) {
        CHECK(r.placed == 0);
        CHECK(doubted(r, "0.00 of the force presses the pad, 1.00 is lost to rounding"));
    }
    const ContactReport kept = add_contacts(b.pad, {at(0.008, 0.008, 1, 3e-3)});
    CHECK(kept.plausible());
    CHECK(kept.placed == relative(1, 1e-3));
}

TEST_CASE(
    "a contact that is rolled to 45 degrees on a flat pad is doubted, and the sentence says where its force went") {
    Buffer b(48, 48);
    const Pose corner = Pose().from_middle(b.pad);
    const RolledBall rolled{pi / 4, 0, 2e-3};
    const ContactReport r = add_contacts(b.pad, corner, 6e-3, {rolled.contact(true)});
    CHECK(r.sideways == relative(1 - std::sqrt(0.5), 1e-9));
    CHECK(r.asked == relative(r.placed + r.outside + r.sideways, 1e-6));
    CHECK(r.outside > 0.2);
    CHECK(doubted(r, " of the force presses the pad, 0.29 is sideways (a round body?), 0."));
    CHECK(doubted(r, " is outside: over the border. Are lengths in m"));
    // In its middle the same ball is not doubted.
    const ContactReport middle = add_contacts(b.pad, corner, 6e-3, {RolledBall{0, 0, 2e-3}.contact(true)});
    CHECK((middle.plausible() && middle.doubts() == ""));
}

TEST_CASE(
    "of frames of a rolling ball, 95 in 100 are doubted where less than half of the normal force is placed, and 1 "
    "in 100 where 0.9 is") {
    Frames low, high;
    for (int cells : {48, 80})
        for (bool with_direction : {false, true})
            for (int degree = -80; degree <= 80; ++degree)
                for (double friction : {-0.5, -0.2, 0.0, 0.2, 0.5})
                    for (double radius : {1e-3, 2e-3, 3e-3}) {
                        Buffer b(cells, cells);
                        const RolledBall ball{degree * pi / 180, friction, radius};
                        const Pose corner = Pose().from_middle(b.pad);
                        const ContactReport r = add_contacts(b.pad, corner, 8e-3, {ball.contact(with_direction)});
                        if (b.force() < 0.5) low.count(!r.plausible());
                        if (b.force() >= 0.9) high.count(!r.plausible());
                    }
    CHECK(low.all > 1000);
    CHECK(high.all > 1000);
    CHECK(low.doubted >= 0.95 * low.all);
    CHECK(high.doubted <= 0.01 * high.all);
}

TEST_CASE("a contact in millimetres is found out, whichever of its lengths is one") {
    Buffer b(80, 64);
    Contact wide = at(0.01, 0.008, 1, 0);
    wide.area = pi * 9;
    for (const Contact& c : {at(10, 8, 1, 3), at(10, 8, 1, 3e-3), at(0.5, 0.5, 1, 3), at(0.01, 0.008, 1, 3), wide}) {
        const ContactReport r = add_contacts(b.pad, {c});
        CHECK(r.placed < 1e-3);
        CHECK(doubted(r, "0.00 of the force presses the pad, 1.00 is outside: "));
        CHECK(doubted(r, "Are lengths in m"));
    }
    for (const WorldContact& c : {in_world({10, 8, 0}, 1, 3e-3), in_world({10, 8, 5}, 1, 3)})
        CHECK(doubted(add_contacts(b.pad, Pose(), 2e-3, {c}), c.position[2] > 0 ? ": 1 too far. " : ": 1 beside. "));
    const std::vector<float> values(12, 1.0f);
    CHECK(doubted(add_taxels(b.pad, taxels_of(values, 4, 3, 5, 5)), "11 beside, else over the border"));
}

TEST_CASE("a sentence counts what was beside, too far and turned away") {
    Buffer b(40, 40);
    std::vector<WorldContact> contacts(4, in_world({0.005, 0.005, 0}, 1, 1e-3));
    contacts[1].position = {0.005, 0.005, 1};
    contacts[2].position = {1, 0.005, 0};
    contacts[3].direction = {0, 0, 1};
    const ContactReport r = add_contacts(b.pad, Pose(), 2e-3, contacts);
    CHECK(doubted(r,
                  "0.25 of the force presses the pad, 0.75 is outside: 1 beside, 1 too far, 1 turned away, else over "
                  "the border. "));
    const std::vector<float> gaps(1600, -1.0f);
    CHECK(doubted(add_depths(b.pad, depths_of(gaps, 2)), "1.00 is outside: nowhere deeper than 0"));
    // A tenth may be outside, and half sideways; nothing asked is nothing lost.
    contacts = {in_world({0.005, 0.005, 0}, 0.91, 3e-3), in_world({1, 0, 0}, 0.09, 3e-3)};
    CHECK(add_contacts(b.pad, Pose(), 0, contacts).doubts() == "");
    contacts[1].force = 0.11;
    CHECK_FALSE(add_contacts(b.pad, Pose(), 0, contacts).plausible());
    contacts[0].direction = {std::sin(1.04), 0, -std::cos(1.04)}, contacts[1].force = 0; // 59.6 degrees
    CHECK(add_contacts(b.pad, Pose(), 0, contacts).plausible());
    contacts[0].direction = {std::sin(1.05), 0, -std::cos(1.05)};
    CHECK_FALSE(add_contacts(b.pad, Pose(), 0, contacts).plausible());
    CHECK(add_contacts(b.pad, Pose(), 0, std::vector<WorldContact>(3)).plausible());
}

TEST_CASE("tiled pads share a patch without doubt, and each is asked for its part alone") {
    const std::vector<float> values(16, 0.1f);
    const TaxelReadings taxels = taxels_of(values, 4, 4, 4e-3, 2e-3);
    for (double middle : {36.0, 40.0, 44.0, 60.0}) {
        CAPTURE(middle);
        Buffer left(40, 40), right(40, 40);
        const auto both = [&](auto add) { return std::pair{add(left.pad, 0.0), add(right.pad, 40 * quarter)}; };
        const auto contact = [&](const Pad& pad, double from) {
            return add_contacts(pad, {at(middle * quarter - from, 5e-3, 0.5, 2e-3)});
        };
        const auto oblique = [&](const Pad& pad, double from) {
            WorldContact c = in_world({middle * quarter - from, 5e-3, 0}, 0.5, 2e-3);
            c.direction = {0.6, 0, -0.8};
            return add_contacts(pad, Pose(), 0, {c});
        };
        const auto array = [&](const Pad& pad, double from) {
            TaxelReadings t = taxels;
            t.x = middle * quarter - 8e-3 - from;
            return add_taxels(pad, t);
        };
        const auto check_tiled = [&](double force, const auto& add) {
            left.pad.tiled = right.pad.tiled = true;
            const auto [l, r] = both(add);
            CHECK(l.asked + r.asked == relative(force, 1e-7));
            CHECK(l.placed + r.placed + l.sideways + r.sideways == relative(force, 1e-6));
            for (const ContactReport& report : {l, r}) {
                CHECK(std::abs(report.outside) < 1e-9);
                CHECK(report.beside == 0);
                CHECK(report.doubts() == "");
            }
            left.pad.tiled = right.pad.tiled = false;
            const auto [own, other] = both(add);
            CHECK(own.asked == relative(force, 1e-7));
            CHECK_FALSE((own.plausible() && other.plausible()));
        };
        check_tiled(0.5, contact);
        check_tiled(0.5, oblique);
        if (middle < 50) check_tiled(16 * double(0.1f), array);
    }
    // What is too far or turned away is nobody's.
    Buffer b(40, 40);
    b.pad.tiled = true;
    CHECK(doubted(add_contacts(b.pad, Pose(), 1e-3, {in_world({5e-3, 5e-3, 1}, 1, 1e-3)}), "1 too far"));
}
