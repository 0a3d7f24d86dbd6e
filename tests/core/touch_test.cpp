// SPDX-License-Identifier: MIT
// labels: device
// Contacts of a whole batch in one call, and skins pressed by them.
#include "dermis/touch.hpp"
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"
#include "tests/allocations.hpp"
#include "tests/contacts.hpp"
#include "tests/embedding_host.hpp"
#include "tests/expected.hpp"

#include <cstring>
#include <utility>

using namespace test;
using dermis::contact::Contacts, dermis::contact::Poses, dermis::contact::Touch;
using test::contacts::Random, test::contacts::difference;

namespace {

constexpr int pads = 9, side = 24;
constexpr double cell = 5e-4, radius = 8e-3; // m

contact::Pad tip() {
    contact::Pad shape;
    shape.width = side, shape.height = side, shape.spacing = cell;
    shape.radius_x = radius, shape.radius_y = radius;
    return shape;
}

// Contacts on some of the pads, in a table as a simulator has it: pad by pad, or in any order.
struct Table {
    std::vector<double> middles, axes;
    std::vector<int32_t> pad;
    std::vector<double> rows; // position, force, radius, each in seven numbers

    Table() {
        Random random;
        for (int i = 0; i < pads; ++i) {
            const double angle = 0.7 * i, c = std::cos(angle), s = std::sin(angle);
            middles.insert(middles.end(), {0.1 * i, -0.2, 0.05 * i});
            axes.insert(axes.end(), {c, -s, 0, s, c, 0, 0, 0, 1});
        }
    }
    // Adds a force of so many newtons at an angle to the surface, x and y metres from the middle of a pad.
    void add(int number, double x, double y, double force, double slip = 0.1, double r = 2 * cell) {
        const double z = std::sqrt(radius * radius - x * x - y * y);
        const double own[2][3] = {{x, y, z - radius},
                                  {force * (slip - x / radius), force * (-y / radius), force * (-z / radius)}};
        const double* a = &axes[size_t(9 * number)];
        for (int v = 0; v < 2; ++v)
            for (size_t k = 0; k < 3; ++k)
                rows.push_back(a[3 * k] * own[v][0] + a[3 * k + 1] * own[v][1] + a[3 * k + 2] * own[v][2] +
                               (v == 0 ? middles[size_t(3 * number) + k] : 0));
        rows.push_back(r);
        pad.push_back(number);
    }
    Poses poses() const { return {middles.data(), axes.data()}; }
    Contacts contacts() const {
        Contacts c;
        c.count = pad.size();
        c.pad = pad.data();
        c.position = rows.data(), c.force = rows.data() + 3, c.radius = rows.data() + 6;
        c.position_step = c.force_step = c.radius_step = 7;
        return c;
    }
};

Table table_of(int n) {
    Table t;
    Random random;
    random.bits.seed(uint64_t(n) + 7);
    for (int i = 0; i < n % 4 * 3; ++i)
        t.add(int(random.bits() % pads), random.within(-4e-3, 4e-3), random.within(-4e-3, 4e-3), random.within(0, 0.4),
              random.within(-0.3, 0.3), random.within(1, 5) * cell);
    return t;
}

// What a pad of a touch is pressed with.
std::vector<float> pressure_of(const Touch& touch, int pad) {
    const float* first = touch.pressure() + size_t(pad) * side * side;
    return {first, first + side * side};
}

} // namespace

TEST_CASE("Contacts of a batch press each pad with the bits of a batch that has this pad alone, in any order of pads") {
    Table all;
    all.add(3, 1e-3, 2e-3, 0.2), all.add(0, 0, 0, 0.1), all.add(3, 1.2e-3, 1e-3, 0.3), all.add(7, -3e-3, 1e-3, 1);
    Touch touch(tip(), pads, 1e-3);
    const contact::ContactReport whole = touch.add(all.poses(), all.contacts());
    double asked = 0, placed = 0, shear = 0;
    for (int i = 0; i < pads; ++i) {
        CAPTURE(i);
        Touch alone(tip(), 1, 1e-3);
        Contacts c = all.contacts();
        std::vector<double> rows;
        for (size_t k = 0; k < all.pad.size(); ++k)
            if (all.pad[k] == i) rows.insert(rows.end(), &all.rows[7 * k], &all.rows[7 * k] + 7);
        const std::vector<int32_t> zeros(rows.size() / 7, 0);
        c.count = zeros.size(), c.pad = zeros.data();
        c.position = rows.data(), c.force = rows.data() + 3, c.radius = rows.data() + 6;
        const Poses pose{&all.middles[size_t(3 * i)], &all.axes[size_t(9 * i)]};
        const contact::ContactReport own = alone.add(pose, c);
        CHECK(pressure_of(touch, i) == pressure_of(alone, 0));
        CHECK(touch.report(i).placed == own.placed);
        CHECK((own.placed > 0) == (i == 0 || i == 3 || i == 7));
        asked += own.asked, placed += own.placed, shear += own.shear[0];
    }
    CHECK(whole.asked == relative(asked, 1e-12));
    CHECK(whole.placed == relative(placed, 1e-12));
    // Of a force F with a slip s the component against the normal at x is F*(1 - s*x/radius).
    CHECK(whole.placed == relative(1.6 - 0.1 * (0.2 * 1 + 0.3 * 1.2 - 1 * 3) / 8, 1e-6));
    CHECK(whole.shear[0] == relative(shear, 1e-12));
}

TEST_CASE("A Touch takes floats as it takes the same numbers in double, and both beside each other") {
    const Table all = table_of(7);
    const auto single = [](const std::vector<double>& numbers) {
        return std::vector<float>(numbers.begin(), numbers.end());
    };
    const auto in_double = [](const std::vector<float>& numbers) {
        return std::vector<double>(numbers.begin(), numbers.end());
    };
    const std::vector<float> middles = single(all.middles), axes = single(all.axes), rows = single(all.rows);
    Table same = all;
    same.middles = in_double(middles), same.axes = in_double(axes), same.rows = in_double(rows);
    Touch touch(tip(), pads, 1e-3), other(tip(), pads, 1e-3);
    CHECK(touch.add(same.poses(), same.contacts()).placed > 0.1);
    Contacts c = same.contacts();
    c.position = rows.data(), c.force = rows.data() + 3;
    other.add({middles.data(), axes.data()}, c);
    for (int i = 0; i < pads; ++i) CHECK(pressure_of(touch, i) == pressure_of(other, i));
}

TEST_CASE("Each call takes away what the one before pressed, and allocates nothing") {
    Touch touch(tip(), pads, 1e-3);
    const Table many = table_of(3), none;
    touch.add(many.poses(), many.contacts());
    for (int n = 0; n < 12; ++n) {
        const Table t = table_of(n);
        Touch fresh(tip(), pads, 1e-3);
        fresh.add(t.poses(), t.contacts());
        const size_t before = allocations();
        touch.add(t.poses(), t.contacts());
        CHECK(allocations() == before);
        CHECK(std::memcmp(touch.pressure(), fresh.pressure(), size_t(pads) * side * side * sizeof(float)) == 0);
    }
    CHECK(touch.add(none.poses(), none.contacts()).asked == 0);
    for (int i = 0; i < pads * side * side; ++i) REQUIRE(touch.pressure()[i] == 0);
    CHECK(touch.report(3).asked == 0);
    // A patch that overhangs the border, one below a cell, and one beside the pad leave nothing behind either.
    Table odd;
    odd.add(1, 5.4e-3, 0, 0.1, 0, 4 * cell), odd.add(2, 1e-3, 1e-3, 0.1, 0, 0), odd.add(3, 7.9e-3, 0, 0.1, 0, cell);
    CHECK(touch.add(odd.poses(), odd.contacts()).below_cell == 1);
    touch.add(none.poses(), none.contacts());
    for (int i = 0; i < pads * side * side; ++i) REQUIRE(touch.pressure()[i] == 0);
}

TEST_CASE(
    "Recorded into a command buffer, a Touch presses with the bits of its pressures, and in the bytes of its blocks") {
    const Validated vulkan;
    Context& context = *vulkan::context_of(*vulkan.device().impl().backend);
    SkinDescription d = ridged(side, side);
    SkinOptions options{.count = pads};
    constexpr int frames = 6;
    Host host(context, d, frames, options);
    Skin skin(Device::cpu(1), d, options);
    Touch touch(tip(), pads, 1e-3);
    const auto barrier = [&](vulkan::Access from, vulkan::Access to, VkCommandBuffer commands) {
        const VkMemoryBarrier b{
            .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER, .srcAccessMask = from.access, .dstAccessMask = to.access};
        context.calls().vkCmdPipelineBarrier(commands, from.stages, to.stages, 0, 1, &b, 0, nullptr, 0, nullptr);
    };
    const vulkan::Access transfer{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT};
    vulkan::Recording recording(context);
    const VkCommandBuffer commands = recording.commands();
    size_t cells = 0;
    std::vector<std::vector<float>> expected;
    for (int i = 1; i <= frames; ++i) {
        const Table t = table_of(i);
        touch.add(t.poses(), t.contacts());
        for (const int pad : touch.touched()) cells += size_t(touch.block(pad).width) * size_t(touch.block(pad).height);
        skin.press(touch, 1e-3);
        expected.push_back(answers(skin, Quantity::fa1));
        std::memset(host.pressures[size_t(i)]->data(), 0x7f,
                    host.program.memory().pressure.bytes); // of an earlier frame
        REQUIRE(host.program.record_touch(commands, host.pressures[size_t(i)]->info, touch));
        barrier(transfer, host.program.first_access(), commands);
        REQUIRE(host.program.record_press(commands, host.bindings[size_t(i - 1)], 1e-3));
        barrier(host.program.last_access(), host.program.first_access(), commands);
        barrier(host.program.last_access(), transfer, commands);
    }
    const Table none;
    touch.add(none.poses(), none.contacts()); // what was recorded stays
    recording.submit();
    for (int i = 1; i <= frames; ++i) CHECK(host.response(i, Quantity::fa1) == expected[size_t(i - 1)]);
    CHECK(cells > 0);
    CHECK(cells < size_t(frames) * pads * side * side / 4);

    const auto refusal_of = [&](const Touch& other) {
        return std::string(host.program.record_touch(commands, host.pressures[1]->info, other).refused);
    };
    CHECK(refusal_of(Touch(tip(), 2, 1e-3)) == "touch: other pads than the program's");
    CHECK(refusal_of(Touch(tip(), pads, 1e-3, true)) == "touch: tractions; a SkinProgram has no shear");
    VkDescriptorBufferInfo small = host.pressures[1]->info;
    small.range = 16;
    CHECK(std::string(host.program.record_touch(commands, small, touch).refused) ==
          "pressure_to: fewer than memory().pressure.bytes");
}

TEST_CASE("Without radii a patch has Hertz's, and at least two cells") {
    Table t;
    t.add(0, 0, 0, 0.5, 0), t.add(1, 0, 0, 1e-6, 0);
    Contacts c = t.contacts();
    const double ball = 8e-3;
    c.radius = nullptr;
    c.ball = &ball, c.ball_step = 0;
    c.modulus = 1e5;
    Touch touch(tip(), pads, 1e-3), given(tip(), pads, 1e-3);
    touch.add(t.poses(), c);
    Table same;
    same.add(0, 0, 0, 0.5, 0, contact::hertz_radius(0.5, ball, 1e5)), same.add(1, 0, 0, 1e-6, 0, 2 * cell);
    given.add(same.poses(), same.contacts());
    for (int i = 0; i < 2; ++i) CHECK(difference(pressure_of(touch, i), pressure_of(given, i)) < 1e-6);
}

TEST_CASE("A force too small for a product of doubles leaves finite pressures and tractions") {
    Table t;
    t.add(1, 0, 0, 1e-200), t.add(2, 0, 0, 1e-310), t.add(2, 1e-3, 0, 1e-20);
    Touch touch(tip(), pads, 1e-3, true);
    touch.add(t.poses(), t.contacts());
    for (int i = 0; i < pads * side * side; ++i) {
        REQUIRE(std::isfinite(touch.pressure()[i]));
        REQUIRE(std::isfinite(touch.traction()[i]));
    }
}

TEST_CASE("What a Touch cannot take is refused by name, and changes nothing") {
    Table t;
    t.add(2, 0, 0, 0.5);
    Touch touch(tip(), pads, 1e-3);
    touch.add(t.poses(), t.contacts());
    const std::vector<float> before = pressure_of(touch, 2);
    const auto refused = [&](const char* words, auto change) {
        CAPTURE(words);
        Table own = t;
        Contacts c = own.contacts();
        Poses p = own.poses();
        change(own, c, p);
        const std::string message = refusal(Error::Code::bad_input, [&] { touch.add(p, c); });
        CHECK_MESSAGE(message.find(words) == 0, message);
        CHECK(pressure_of(touch, 2) == before);
        CHECK(touch.report(2).placed > 0.4);
    };
    refused("contacts.pad[0] = 9; allowed: 0..8", [](Table& o, Contacts&, Poses&) { o.pad[0] = 9; });
    refused("contacts.pad[0] = -1; allowed: 0..8", [](Table& o, Contacts&, Poses&) { o.pad[0] = -1; });
    refused("contacts.position[0] = 0.", [](Table& o, Contacts&, Poses&) { o.rows[1] = NAN; });
    refused("contacts.force[0] = ", [](Table& o, Contacts&, Poses&) { o.rows[5] = 1e13; });
    refused("contacts.radius[0] = -1; allowed: 0..1e6", [](Table& o, Contacts&, Poses&) { o.rows[6] = -1; });
    refused("contacts.force = null", [](Table&, Contacts& c, Poses&) { c.force = nullptr; });
    refused("contacts.ball = null", [](Table&, Contacts& c, Poses&) { c.radius = nullptr; });
    refused("contacts.ball = (given); allowed: null beside contacts.radius",
            [](Table&, Contacts& c, Poses&) { c.ball = c.radius; });
    refused("contacts.modulus = 1; allowed: 0", [](Table&, Contacts& c, Poses&) { c.modulus = 1; });
    refused("contacts.modulus = 0; allowed: a finite number > 0",
            [](Table&, Contacts& c, Poses&) { c.ball = std::exchange(c.radius, nullptr); });
    refused("contacts.pad = null", [](Table&, Contacts& c, Poses&) { c.pad = nullptr; });
    refused("contacts.position = null", [](Table&, Contacts& c, Poses&) { c.position = nullptr; });
    refused("contacts.count = 2147483648; allowed: at most 2147483647",
            [](Table&, Contacts& c, Poses&) { c.count = size_t(1) << 31; });
    refused("poses.position = null", [](Table&, Contacts&, Poses& p) { p.position = nullptr; });
    refused("poses.rotation = null", [](Table&, Contacts&, Poses& p) { p.rotation = nullptr; });
    refused("poses.rotation[2] = ", [](Table& o, Contacts&, Poses&) { o.axes[18] = 0.5; });
    refused("poses.position[2] = ", [](Table& o, Contacts&, Poses&) { o.middles[6] = 1e7; });
}

TEST_CASE("A Touch of other pads than the skin's is refused, and so is a shape with memory") {
    SkinOptions options{.count = pads};
    Skin skin(Device::cpu(1), ridged(side, side), options);
    const auto message = [](auto call) { return refusal(Error::Code::bad_input, call); };
    CHECK(message([&] { skin.press(Touch(tip(), 8, 1e-3), 1e-3); }) ==
          "touch = 8 pads of 24 x 24 cells; allowed: 9 pads of 24 x 24 cells");
    SkinDescription in_metres = dermis::fingertip();
    in_metres.grid = {side, side, 4e-4};
    Skin finer(Device::cpu(1), in_metres, options);
    CHECK(message([&] { finer.press(Touch(tip(), pads, 1e-3), 1e-3); }) ==
          "touch.spacing = 5e-04; allowed: 4e-04 m, as the skin has it");
    options.control = Control::depth;
    SkinDescription deep = in_metres;
    Skin sinks(Device::cpu(1), deep, options);
    CHECK(message([&] { sinks.press(Touch(tip(), pads, 1e-3), 1e-3); }).find("touch = pressures") == 0);
    float memory = 0;
    contact::Pad shape = tip();
    shape.pressure = &memory;
    CHECK(message([&] { Touch(shape, 1, 1e-3); }).find("shape.pressure = ") == 0);
    CHECK(message([&] { Touch(tip(), 0, 1e-3); }) == "count = 0; allowed: 1..1048576");
    CHECK(message([&] {
              Touch({.width = 16384, .height = 16384, .spacing = 1}, 9, 0);
          }).find("count*width*height = 2415919104; allowed: ") == 0);
    CHECK(message([&] { Touch({.width = 0, .height = 1, .spacing = 1}, 1, 0); }).find("pad.width = 0") == 0);
    CHECK(message([&] { Touch({.width = 1, .height = 1, .spacing = 1, .pitch = 1}, 1, 0); }).find("shape.pitch = 1") ==
          0);
    CHECK(message([&] { Touch(tip(), 1, 8e-3); }).find("reach = 0.008; allowed: below the pad's radius") == 0);
    CHECK(message([&] { Touch(tip(), 1, 1e-3).report(1); }) == "pad = 1; allowed: 0..0");
}
