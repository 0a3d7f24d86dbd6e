// SPDX-License-Identifier: MIT
// labels: device threads
// Many pads pressed together, on the CPU, on Vulkan and in a host's command buffer. That each has the bits of a Skin
// alone is what the suite `ways` says.
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"
#include "tests/allocations.hpp"
#include "tests/embedding_host.hpp"

#include <cstring>

using namespace test;

namespace {

constexpr int pads = 5;

const std::vector<int> every = {0, 1, 2, 3, 4};

SkinDescription pad(int width, int height) {
    SkinDescription d = small_scene(width, height);
    d.receptors.fa2 = Fa2::step_mean;
    d.material.modulus = 1.3;
    return d;
}

} // namespace

TEST_CASE("a press of pads that is refused names what is wrong, and nothing has happened") {
    const Validated vulkan;
    const SkinDescription d = pad(20, 3);
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

TEST_CASE("pads in a host's command buffer have the CPU's bits, those that are not pressed keep state and pressure") {
    const Validated vulkan;
    Context& context = *vulkan::context_of(*vulkan.device().impl().backend);
    for (int variant = 0; variant < 8; ++variant) {
        CAPTURE(variant);
        SkinDescription d = pad(21, 6);
        SkinOptions options{.count = pads};
        for (int i = 0; variant & 1 && i < pads; ++i) {
            options.materials.push_back(d.material);
            options.materials.back().viscosity = 0.5 + i;
        }
        for (int i = 0; variant & 2 && i < 24; ++i) d.sites.push_back({all_responses[i % 4], {i * 5 % 21, i % 6}});
        Skin skin(Device::cpu(1), d, options);
        Host host(context, d, 4, options);
        const std::vector<int> lists[] = {every, {1, 3}, {0, 2, 3, 4}, every};
        const std::vector<double> dt = {0.01, 0.3, 0.0, 0.02, 1};
        const auto pressure = [&](int i, const std::vector<int>& list) {
            std::vector<float> all;
            for (int p : list) {
                const std::vector<float> own = frame(d, i + p);
                all.insert(all.end(), own.begin(), own.end());
            }
            return all;
        };
        for (int i = 1; i <= 4; ++i) host.set_pressure(i, pressure(i, every));
        vulkan::Recording recording(context);
        const VkCommandBuffer commands = recording.commands();
        for (int i = 1; i <= 4; ++i) {
            const std::vector<int>& list = lists[i - 1];
            const Binding binding = host.bindings[size_t(i - 1)];
            const bool each = variant & 4 && i > 1;
            REQUIRE((i == 4 && !each
                         ? host.program.record_press(commands, binding, dt[0])
                         : host.program.record_press(commands, binding, list, dt.data(), each ? list.size() : 1)));
            barrier(context, commands, host.program);
        }
        CHECK(!host.program.record_press(commands, host.bindings[0], std::vector<int>{1, 0}, dt.data(), 1));
        CHECK(!host.program.record_press(commands, host.bindings[0], std::vector<int>{pads}, dt.data(), 1));
        CHECK(!host.program.record_press(commands, host.bindings[0], std::vector<int>{0, 1, 2}, dt.data(), 2));
        context.barrier(commands);
        recording.submit();
        for (int i = 1; i <= 4; ++i) {
            const std::vector<int>& list = lists[i - 1];
            if (variant & 4 && i > 1) skin.press(pressure(i, list), {dt.begin(), dt.begin() + long(list.size())}, list);
            else skin.press(pressure(i, list), dt[0], list);
            for (Quantity q : all_responses) {
                CAPTURE(i);
                CAPTURE(name(q));
                const Skin::Response r = skin.response(q);
                const std::vector<float> answered = host.response(i, q);
                REQUIRE(answered.size() == r.size);
                const size_t of_pad = r.size / pads;
                for (int p : list)
                    CHECK(std::memcmp(answered.data() + size_t(p) * of_pad, r.data + size_t(p) * of_pad,
                                      of_pad * sizeof(float)) == 0);
            }
        }
        CHECK(host.not_finite() == 0);
        CHECK(host.untouched_around());
    }
}

TEST_CASE("presses of pads allocate nothing") {
    const SkinDescription d = pad(20, 25);
    SkinOptions options{.count = 64};
    for (int threads : {1, 2}) {
        Skin batch(Device::cpu(threads), d, options);
        const std::vector<float> pressure(64 * 500, 1.0f), some(2 * 500, 2.0f);
        const std::vector<double> steps(64, 0.5);
        const std::vector<int> list = {7, 3};
        batch.press(pressure, steps);
        const size_t before = allocations();
        batch.press(pressure, 0.01);
        batch.press(some, 0.02, list);
        batch.press(pressure, steps);
        batch.reset(list);
        CHECK(allocations() == before);
    }
}
