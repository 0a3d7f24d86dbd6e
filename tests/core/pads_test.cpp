// SPDX-License-Identifier: MIT
// labels: device threads
// Many pads pressed together. That each has the bits of a Skin alone is what the suite `ways` says, and `embedding` of
// pads in a host's command buffer.
#include "tests/support.hpp"

using namespace test;

namespace {

constexpr int pads = 5;

} // namespace

TEST_CASE("a press of pads that is refused names what is wrong, and nothing has happened") {
    const Validated vulkan;
    const SkinDescription d = ridged(20, 3);
    const size_t cells = 60;
    for (const Device& device : {Device::cpu(1), Device::cpu(3), vulkan.device()}) {
        CAPTURE(device.info().name);
        SkinOptions five{.count = pads};
        Skin batch(device, d, five);
        batch.press(std::vector<float>(pads * cells, 3.0f), 0.01);
        const Bytes before = saved(batch);
        std::vector<float> some(3 * cells, 1.0f);
        refuses([&] { batch.press(some, 0.01, std::vector<int>{0, 1, 5}); }, "5 at position 2");
        refuses([&] { batch.press(some, 0.01, std::vector<int>{0, -1, 4}); }, "-1 at position 1");
        refuses([&] { batch.press(some, 0.01, std::vector<int>{0, 3, 3}); }, "3 at position 2");
        refuses([&] { batch.press(some, 0.01, std::vector<int>{0, 3}); }, "180 cells");
        refuses([&] { batch.press(some, 0.01); }, "5 pads");
        refuses([&] { batch.press(some, {0.01, 0.1}, std::vector<int>{0, 1, 2}); }, "2 steps");
        refuses([&] { batch.press(some, {0.01, NAN, 0.1}, std::vector<int>{0, 1, 2}); }, "dt");
        refuses([&] { batch.press(some, {0.01, 1e39, 0.1}, std::vector<int>{0, 1, 2}); }, "1e+39");
        some[2 * cells + 21] = INFINITY;
        refuses([&] { batch.press(some, 0.01, std::vector<int>{0, 1, 4}); }, "cell [1, 1] of pad 4");
        refuses([&] { batch.reset(std::vector<int>{5}); }, "5 at position 0");
        refuses([&] { (void)batch.state_bytes(std::vector<int>{2, 2}); }, "2 at position 1");
        refuses([&] { (void)batch.report(5); }, "0..4");
        Material other = d.material;
        refuses([&] { batch.set_material(other, std::vector<int>{0}); }, "no materials of their own");
        other.modulus = -1;
        refuses([&] { batch.set_material(other); }, "material.modulus");
        CHECK(saved(batch) == before);
    }
    SkinOptions options;
    const auto made = [&] { Skin(Device::cpu(), d, options); };
    for (int count : {0, -1, 1048577}) {
        options.count = count;
        refuses(made, "1..1048576");
    }
    options.count = 3;
    options.materials = {d.material, d.material};
    refuses(made, "2 materials");
    options.materials.push_back(d.material);
    options.materials[2].modulus = -2;
    refuses(made, "materials[2]");
    options.materials[2] = {};
    options.materials[2].elements = {{1, 1}, {2, 2}};
    refuses(made, "materials[2]");
}

TEST_CASE("a pad at rest leaves it where one cell alone is pressed, whichever") {
    const Validated vulkan;
    const SkinDescription d = ridged(7, 3);
    const int cells = 21;
    for (const Device& device : {Device::cpu(1), Device::cpu(3), vulkan.device()}) {
        Skin batch(device, d, {.responses = {Quantity::sa1}, .count = cells}); // in pad i cell i
        std::vector<float> pressure(size_t(cells * cells));
        for (int i = 0; i < cells; ++i) pressure[size_t(i * cells + i)] = 1e3f;
        batch.press(pressure, 0.01);
        for (int i = 0; i < cells; ++i) CHECK(batch.response(Quantity::sa1)[i * cells + i] > 0);
    }
}
