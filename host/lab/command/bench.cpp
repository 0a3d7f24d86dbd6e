// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include "dermis/dermis.hpp"
#include "host/core/press/device.hpp"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>

namespace dermis::cli {
namespace {

// Returns the median time of a press, in seconds. Presses are timed in groups of a millisecond or more.
double seconds_of_press(const Device& device, const Scene& scene, int pads) {
    SkinOptions options;
    options.precision = scene.precision;
    options.count = pads;
    Skin skin(device, scene, options);
    const std::vector<float> pressure(size_t(pads) * size_t(scene.grid.width) * size_t(scene.grid.height), 1.0f);
    const double start = seconds_now();
    std::vector<double> groups;
    for (size_t presses = 1; groups.size() < 3 || seconds_now() - start < 0.25;) {
        const double before = seconds_now();
        for (size_t i = 0; i < presses; ++i) skin.press(pressure, scene.time.step);
        const double seconds = seconds_now() - before;
        if (seconds < 1e-3) presses *= 2; // caches and clocks are not warm yet either
        else groups.push_back(seconds / double(presses));
    }
    std::ranges::sort(groups);
    return groups[groups.size() / 2];
}

} // namespace

double seconds_now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int bench_scene(const std::string& path, int pads, const std::string& device) {
    const Scene scene = Scene::from_file(path);
    const std::vector<Device> devices = {Device::cpu(1), Device::cpu(), Device::open(device)};
    std::string text = pads > 1 ? fmt::format("{} pads of ", pads) : "";
    text += fmt::format("{} x {}: ", scene.grid.width, scene.grid.height);
    for (size_t i = 0; i < devices.size(); ++i) {
        const int threads = devices[i].impl().backend->threads();
        if (i == 1 ? threads == 1 : i == 2 && !devices[i].info().vulkan) continue; // one core; the CPU path again
        const double us = 1e6 * seconds_of_press(devices[i], scene, pads), share = us * 1e-4 / scene.time.step;
        text +=
            fmt::format("{}{:.{}f} us{} on {}, {:.{}f} %{}", i ? "; " : "", us, us < 10 ? 2 : 0, i ? "" : " per press",
                        i == 2 ? devices[i].info().name : fmt::format("{} thread{}", threads, i ? "s" : ""), share,
                        share < 10 ? 1 : 0, i ? "" : fmt::format(" of a step of {:.6g} ms", 1e3 * scene.time.step));
    }
    fmt::print("{}\n", text);
    return 0;
}

} // namespace dermis::cli
