// SPDX-License-Identifier: MIT
// labels: device threads
// What a press costs a Vulkan device, counted: bytes that are copied, submissions, and workgroups.
#include "host/core/press/device.hpp"
#include "tests/shim.hpp"
#include "tests/support.hpp"

using namespace test;

namespace {

SkinOptions of_pads(int count) {
    SkinOptions options;
    options.count = count;
    return options;
}

// The nth pressure of these pads.
std::vector<float> frames_of(const SkinDescription& d, int n, size_t pads) {
    std::vector<float> all;
    for (size_t pad = 0; pad < pads; ++pad) {
        const std::vector<float> own = frame(d, n + int(pad));
        all.insert(all.end(), own.begin(), own.end());
    }
    return all;
}

std::vector<float> floats(const Skin::Response& r) { return {r.begin(), r.end()}; }

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
        std::vector<int> every;
        for (int i = 0; i < pads; ++i) every.push_back(i);
        CHECK(press(every) == pads * pad);
        CHECK(press(every) == pads * pad);
        shim.copied = 0;
        const Skin::Response fa1 = skin.response(Quantity::fa1);
        CHECK(shim.copied == pads * pad);
        CHECK(floats(fa1) == floats(right.response(Quantity::fa1)));
        CHECK(press(every) == 2 * pads * pad);
        CHECK(floats(fa1) == floats(right.response(Quantity::fa1))); // the same memory, without another call
        shim.copied = 0;
        CHECK(skin.response(Quantity::fa1).data == fa1.data);
        CHECK(shim.copied == 0);
        for (Quantity q : all_responses) CHECK(floats(skin.response(q)) == floats(right.response(q)));
        CHECK(press(every) == 5 * pads * pad);
        for (Quantity q : all_responses) CHECK(floats(skin.response(q)) == floats(right.response(q)));
        if (pads == 1) continue;
        const uint64_t state = 4 * pad; // other pads keep state and pressure by a copy on the device
        CHECK(press({2, 3, 7}) == 3 * 5 * pad + 6 * (state + pad));
        for (Quantity q : all_responses) CHECK(floats(skin.response(q)) == floats(right.response(q)));
        for (Skin* s : {&skin, &right}) s->reset(std::vector<int>{3, 8});
        for (Quantity q : all_responses) CHECK(floats(skin.response(q)) == floats(right.response(q)));
    }
}
