// SPDX-License-Identifier: MIT
// When does a device pay? One skin by its number of cells, on one thread and more and on every Vulkan device, from the
// caller's pressure to responses that the caller can read.
#include "bench/skins.hpp"

#include <algorithm>
#include <stdexcept>

namespace bench {

using namespace dermis;

namespace {

// One thread, then twice as many each time, and all of them; then every Vulkan device that can be used.
std::vector<Device> places_of(const Bench& bench) {
    std::vector<Device> places;
    for (int threads = 1; threads < bench.cores; threads *= 2) places.push_back(Device::cpu(threads));
    places.push_back(Device::cpu(bench.cores));
    if (!bench.vulkan) return places;
    const std::vector<DeviceInfo> all = Device::list();
    for (size_t i = 0; i < all.size(); ++i)
        if (all[i].refused.empty()) places.push_back(Device::open(std::to_string(i)));
    return places;
}

int presses_of(const Device& place, int n) {
    const bool software = place.info().kind == "software";
    return std::clamp(int((software ? 5e5 : 4e6) / n / n), 1, software ? 20 : 2000);
}

} // namespace

void by_cells(Bench& bench) {
    const std::vector<Device> places = places_of(bench);
    for (int n = 4; n <= (bench.quick ? 512 : 4096); n *= 2) {
        const size_t cells = size_t(n) * size_t(n);
        const std::vector<float> frames = random_frames(cells, 2);
        std::vector<Skin> skins;
        std::vector<std::function<double()>> work;
        SkinOptions options;
        options.precision = Precision::f32;
        skins.reserve(places.size());
        for (const Device& place : places) {
            Skin& skin = skins.emplace_back(place, rectangle(n, n), options);
            const auto press = [&skin, &frames, cells](int count) {
                for (int i = 0; i < count; ++i) {
                    skin.press(frames.data() + cells * size_t(i % 2), cells, press_dt);
                    skin.response(Quantity::fa2);
                }
            };
            press(4);
            for (Quantity q : options.responses)
                if (!same(skin.response(q), skins[0].response(q)))
                    throw std::runtime_error(place.info().name + " has other bits than one thread");
            work.push_back([press, count = presses_of(place, n)] { return seconds_of([&] { press(count); }); });
        }
        const std::vector<Timing> timings = bench.paired(work, bench.runs);
        for (size_t i = 0; i < places.size(); ++i) {
            Measurement r = bench.on(places[i], "cells", n);
            r.model = "skin";
            r.precision = "f32";
            r.steps = presses_of(places[i], n);
            r.wall = timings[i];
            bench.add(r);
        }
    }
}

} // namespace bench
