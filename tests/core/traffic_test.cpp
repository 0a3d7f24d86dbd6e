// SPDX-License-Identifier: MIT
// labels: device threads
// What a press costs a Vulkan device, counted: bytes that are copied, submissions, and workgroups.
#include "host/core/press/device.hpp"
#include "tests/shim.hpp"
#include "tests/support.hpp"

#include <functional>
#include <numeric>

using namespace test;

namespace {

SkinOptions of_pads(int count) { return {.count = count}; }

// The nth pressure of these pads.
// The workgroups of each submission of a call.
template <class Call> std::vector<uint64_t> submissions_of(Call&& call) {
    std::vector<uint64_t> submissions;
    shim.submissions = &submissions;
    call();
    shim.submissions = nullptr;
    return submissions;
}

} // namespace

TEST_CASE(
    "a press uploads the pads that it presses and downloads their responses that have ever been read, no others") {
    const Device device = open_device("vulkan", shimmed());
    for (const auto& [width, pads] : {std::pair{64, 1}, {61, 1}, {20, 9}}) {
        CAPTURE(width);
        const SkinDescription d = small_scene(width, 25);
        Skin skin(device, d, of_pads(pads)), right(Device::cpu(1), d, of_pads(pads));
        const uint64_t row = pads > 1 ? 20 : 64, pad = row * 25 * sizeof(float);
        int n = 0;
        const auto press = [&](const std::vector<int>& list) {
            shim.copied = 0;
            const std::vector<float> pressures = frames_of(d, ++n, list.size());
            skin.press(pressures, 0.01, list);
            right.press(pressures, 0.01, list);
            return shim.copied;
        };
        std::vector<int> every(size_t(pads), 0);
        std::iota(every.begin(), every.end(), 0);
        CHECK(press(every) == pads * pad);
        CHECK(press(every) == pads * pad);
        shim.copied = 0;
        const Skin::Response fa1 = skin.response(Quantity::fa1);
        CHECK(shim.copied == pads * pad);
        CHECK(std::vector<float>(fa1.begin(), fa1.end()) == answers(right, Quantity::fa1));
        CHECK(press(every) == 2 * pads * pad);
        CHECK(std::vector<float>(fa1.begin(), fa1.end()) ==
              answers(right, Quantity::fa1)); // the same memory, without another call
        shim.copied = 0;
        CHECK(skin.response(Quantity::fa1).data == fa1.data);
        CHECK(shim.copied == 0);
        CHECK(answers(skin) == answers(right));
        CHECK(press(every) == 5 * pads * pad);
        CHECK(answers(skin) == answers(right));
        if (pads == 1) continue;
        const uint64_t state = 4 * pad; // other pads keep state and pressure by a copy on the device
        CHECK(press({2, 3, 7}) == 3 * 5 * pad + 6 * (state + pad));
        CHECK(answers(skin) == answers(right));
        for (Skin* s : {&skin, &right}) s->reset(std::vector<int>{3, 8});
        CHECK(answers(skin) == answers(right));
    }
}

TEST_CASE("a press of which nothing is read waits for the press before the last alone; then all have the right bits") {
    Ledger ledger;
    const vulkan::Loader loader = shimmed();
    shim.ledger = &ledger;
    {
        const Device device = open_device("vulkan", loader);
        for (const int pads : {1, 9}) {
            const SkinDescription d = small_scene(20, 25);
            Skin skin(device, d, of_pads(pads)), right(Device::cpu(1), d, of_pads(pads));
            for (int i = 1; i <= 7; ++i) {
                const std::vector<float> pressures = frames_of(d, i, size_t(pads));
                for (Skin* s : {&skin, &right}) s->press(pressures, 0.01 * i);
                CHECK(ledger.running() == size_t(std::min(i, 2)));
            }
            CHECK(saved(skin) == saved(right));
            CHECK(ledger.running() == 0);
            for (int i = 8; i <= 10; ++i)
                for (Skin* s : {&skin, &right}) s->press(frames_of(d, i, size_t(pads)), 0.01);
            CHECK(ledger.running() == 2);
            for (int i = 11; i <= 12; ++i) {
                CHECK(answers(skin, Quantity::fa2) == answers(right, Quantity::fa2));
                CHECK(ledger.running() == 0);
                for (Skin* s : {&skin, &right}) s->press(frames_of(d, i, size_t(pads)), 0.01);
            }
            Skin ended(device, d, of_pads(pads));
            for (int i = 1; i <= 3; ++i) ended.press(frames_of(d, i, size_t(pads)), 0.01);
            CHECK(ledger.running() == 2);
        }
        CHECK(ledger.running() == 0); // what has ended was waited for
    }
    shim.ledger = nullptr;
    CHECK(ledger.faults().empty());
    CHECK(ledger.left().empty());
}

TEST_CASE("what fails in a press that was not waited for is an error of a later call, and the device is lost") {
    const LeftToDriver leaks;
    for (const bool reads : {false, true}) {
        const Device device = open_device("vulkan", shimmed());
        const SkinDescription d = small_scene(20, 12);
        Skin skin(device, d);
        shim.fault = {.call = "vkWaitForFences", .code = VK_ERROR_DEVICE_LOST, .made = true};
        skin.press(frame(d, 1), 0.1);
        skin.press(frame(d, 2), 0.1);
        const std::string first = refusal(Error::Code::device, [&] {
            if (reads) skin.response(Quantity::sa1);
            else skin.press(frame(d, 3), 0.1);
        });
        CHECK(first == "vkWaitForFences failed with VkResult -4 (device lost)");
        shim.fault = {};
        shim.calls.clear();
        for (const auto& call : {std::function<void()>([&] { skin.press(frame(d, 3), 0.1); }),
                                 {[&] { skin.response(Quantity::sa1); }},
                                 {[&] { saved(skin); }},
                                 {[&] { skin.reset(); }}})
            CHECK(refusal(Error::Code::device, call).find(" is lost since vkWaitForFences") != std::string::npos);
        CHECK(shim.calls.empty());
    }
}

TEST_CASE("frames that are pressed at once are one submission, and their bits are those of as many presses") {
    const Device device = open_device("vulkan", shimmed());
    SkinDescription sites = small_scene(30, 20), chain = small_scene(61, 25);
    for (int i = 0; i < 20; ++i) sites.sites.push_back({all_responses[i % 4], {i, i}});
    chain.material.elements = {{3, 0.1}, {2, 0.9}};
    for (const SkinDescription& d : {SkinDescription(small_scene(64, 25)), chain, sites})
        for (const int pads : {1, 5}) {
            CAPTURE(pads);
            Skin skin(device, d, of_pads(pads)), right(Device::cpu(1), d, of_pads(pads));
            const size_t cells = size_t(d.grid.width * d.grid.height);
            const uint64_t row = pads == 1 ? 64u : size_t(d.grid.width + 3) / 4 * 4,
                           map = row * size_t(d.grid.height * pads) * sizeof(float);
            int n = 0;
            for (const size_t count : {4u, 1u, 8u, 3u, 100u}) {
                std::vector<float> frames;
                for (size_t i = 0; i < count; ++i)
                    for (float p : frames_of(d, ++n % 30, size_t(pads))) frames.push_back(p);
                if (pads > 1) std::fill_n(frames.begin(), cells, 0.0f); // it rests in the first one
                shim.copied = 0;
                const size_t submissions =
                    submissions_of([&] { skin.press_frames(frames.data(), count, cells * size_t(pads), 0.01); }).size();
                CHECK(submissions == (count > 64 ? 2 : 1));
                if (n == 4) CHECK(shim.copied <= (d.sites.empty() ? 4 : 5) * 4 * map);
                for (size_t i = 0; i < count; ++i)
                    right.press(frames.data() + i * cells * size_t(pads), cells * size_t(pads), 0.01);
                if (count == 1) continue; // nothing is read of it
                CHECK(answers(skin) == answers(right));
                CHECK(saved(skin) == saved(right));
            }
        }
}

TEST_CASE("frames whose submission fails leave the skin as it was") {
    const Device device = open_device("vulkan", shimmed());
    const SkinDescription d = small_scene(20, 12);
    Skin skin(device, d);
    std::vector<float> frames;
    for (int i = 0; i < 3; ++i)
        for (float p : frame(d, i)) frames.push_back(p);
    skin.press(frame(d, 7), 0.1);
    const Bytes before = saved(skin);
    for (const char* call : {"vkEndCommandBuffer", "vkQueueSubmit"}) {
        shim.fault = {.call = call, .code = VK_ERROR_OUT_OF_HOST_MEMORY};
        refusal(Error::Code::device, [&] { skin.press_frames(frames.data(), 3, 240, 0.1); });
        shim.fault = {};
        CHECK(saved(skin) == before);
    }
    skin.press_frames(frames.data(), 3, 240, 0.1);
    Skin right(Device::cpu(1), d);
    right.press(frame(d, 7), 0.1);
    for (int i = 0; i < 3; ++i) right.press(frame(d, i), 0.1);
    CHECK(answers(skin) == answers(right));
}

TEST_CASE("small pads share workgroups of up to 128 invocations of four cells, and any number of them is pressed") {
    struct Case {
        int width, height, pads;
        uint64_t groups; // of a press of all pads
    };
    for (const bool own : {false, true})
        for (const Case& c : {Case{4, 4, 4096, 128},
                              {8, 8, 4096, 512},
                              {16, 16, 64, 32},
                              {20, 25, 64, 64},
                              {64, 64, 9, 72},
                              {1, 1, 70, 2},
                              {3, 2, 70000, 1094}}) {
            if (own && c.pads > 4096) continue;
            CAPTURE(c.width);
            CAPTURE(own);
            const Device device = open_device("0", shimmed()); // whatever it can
            const SkinDescription d = small_scene(c.width, c.height);
            SkinOptions options = of_pads(c.pads);
            options.responses = {Quantity::sa1, Quantity::fa2};
            for (int i = 0; own && i < c.pads; ++i)
                options.materials.push_back({.modulus = 1 + 0.1 * (i % 9), .viscosity = 0.5});
            Skin skin(device, d, options), right(Device::cpu(1), d, options);
            std::vector<float> pressures(size_t(c.width) * size_t(c.height) * size_t(c.pads));
            for (int n = 1; n <= 2; ++n) {
                for (size_t i = 0; i < pressures.size(); ++i) pressures[i] = float(1 + (i * size_t(n)) % 17);
                const std::vector<uint64_t> groups = submissions_of([&] { skin.press(pressures, 0.01); });
                CHECK(std::accumulate(groups.begin(), groups.end(), uint64_t(0)) == c.groups);
                right.press(pressures, 0.01);
            }
            CHECK(saved(skin) == saved(right));
        }
}

TEST_CASE("more pads than a device takes workgroups along an axis are pressed in several dispatches") {
    const Device device = open_device("0", shimmed());
    SkinDescription d = small_scene(2, 2);
    d.sites = {{Quantity::fa1, {1, 0}}};
    const int pads = 70000;
    Skin skin(device, d, of_pads(pads)), right(Device::cpu(1), d, of_pads(pads));
    std::vector<float> pressures(size_t(pads) * 4);
    for (size_t i = 0; i < pressures.size(); ++i) pressures[i] = float(1 + i % 17);
    for (Skin* s : {&skin, &right}) s->press(pressures, 0.01);
    CHECK(answers(skin, Quantity::fa1) == answers(right, Quantity::fa1));
}
