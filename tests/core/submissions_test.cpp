// SPDX-License-Identifier: MIT
// Where the work of a Vulkan device is cut into submissions, and what stands between them, changes no bit.
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"
#include "tests/command.hpp"
#include "tests/oracle/scene_files.hpp"
#include "tests/shim.hpp"
#include "tests/support.hpp"

#include <functional>
#include <numeric>
#include <optional>

using namespace test;

namespace {

using Numbers = std::vector<double>;

// A march of 64 outputs, under a sine or, with a file of them, between frames.
Scene marched(const std::string& frames) {
    Scene s = small_scene(40, 30);
    s.model = Model::march;
    s.precision = Precision::f32;
    s.time = {0.01, 0.64};
    s.load.envelope.kind = Envelope::Kind::sine;
    s.output.fields = {{0.33, {Quantity::curvature, Quantity::fa2}}};
    if (frames.empty()) return s;
    s.load = {};
    s.load.kind = Load::Kind::sequence;
    s.load.path = frames;
    s.load.interval = 0.15;
    return s;
}

// Writes five frames for it and returns their path.
std::string write_frames(const Folder& folder) {
    std::vector<std::vector<double>> maps;
    for (int n = 0; n < 5; ++n) {
        const std::vector<float> map = frame(marched(""), n);
        maps.emplace_back(map.begin(), map.end());
    }
    oracle::write_frames(folder / "frames.npy", marched("").grid, maps);
    return (folder / "frames.npy").string();
}

// Presses some frames of all pads and one of some of them, and returns every response.
Numbers pressed(const Device& device, const SkinDescription& d, const SkinOptions& options) {
    Skin skin(device, d, options);
    const size_t pads = size_t(options.count);
    Numbers all;
    const auto press = [&](int n, const std::vector<int>& list, bool each) {
        std::vector<float> pressures;
        std::vector<double> steps;
        for (int pad : list) {
            const std::vector<float> own = frame(d, n + pad);
            pressures.insert(pressures.end(), own.begin(), own.end());
            steps.push_back(0.01 * (1 + pad % 3));
        }
        if (each) skin.press(pressures, steps, list);
        else skin.press(pressures, 0.02, list);
        const std::vector<float> more = answers(skin);
        all.insert(all.end(), more.begin(), more.end());
    };
    std::vector<int> list(pads), some;
    std::iota(list.begin(), list.end(), 0);
    for (size_t i = 0; i < pads; i += 2) some.push_back(int(pads - 1 - i));
    press(1, list, false);
    press(2, list, pads > 1);
    press(3, some, false);
    press(4, list, false);
    return all;
}

} // namespace

TEST_CASE("whatever a progress callback does on the run's own device, no number of the run changes") {
    const Folder folder;
    const std::string file = write_frames(folder);
    for (const Device& device : {Device::cpu(1), Device::open("vulkan")})
        for (const std::string& frames : {std::string(), file}) {
            CAPTURE(device.info().name);
            CAPTURE(frames);
            RunOptions options{.check = device.info().vulkan && !frames.empty()};
            const Scene scene = marched(frames);
            const Numbers right = numbers_of(run(scene, device, options));
            const SkinDescription d = small_scene(40, 30);
            Skin skin(device, d);
            const std::function<void()> deeds[] = {
                [&] { skin.press(frame(d, 1), 0.1); },
                [&] {
                    skin.reset();
                    std::vector<char> state(skin.state_bytes());
                    skin.save(state.data(), state.size());
                    skin.load(state.data(), state.size());
                },
                [&] { Skin(device, with_chain(ridged(20, 10))).press(frame(small_scene(20, 10), 1), 0.1); },
                [&] { run(marched(frames.empty() ? file : ""), device); },
                [&, opened = std::optional<Device>()]() mutable {
                    if (!opened) opened = Device::open("vulkan");
                    Skin(*opened, d).press(frame(d, 1), 0.1);
                },
            };
            for (const auto& deed : deeds) {
                int calls = 0;
                options.progress = [&](double) { ++calls, deed(); };
                CHECK(numbers_of(run(scene, device, options)) == right);
                CHECK(calls > 2);
            }
        }
}

TEST_CASE("a run whose device is lost within its progress callback is an error, though the callback catches its own") {
    const LeftToDriver leaks;
    const Device device = open_device("vulkan", shimmed());
    const SkinDescription d = small_scene(40, 30);
    Skin skin(device, d);
    RunOptions options;
    options.progress = [&](double) {
        shim.fault = {.call = "vkQueueSubmit", .code = VK_ERROR_DEVICE_LOST};
        refusal(Error::Code::device, [&] { skin.press(frame(d, 1), 0.1); });
        shim.fault = {};
    };
    CHECK(refusal(Error::Code::device, [&] { run(marched(""), device, options); }).find(" is lost since ") !=
          std::string::npos);
}

TEST_CASE("runs and presses have the same bits however small their submissions are") {
    const Folder folder;
    const std::string file = write_frames(folder);
    SkinDescription sites = small_scene(40, 30);
    for (int i = 0; i < 60; ++i) sites.sites.push_back({all_responses[i % 4], {i * 13 % 40, i * 7 % 30}});
    SkinDescription chain_sites = with_chain(with_materials(ridged(40, 30)));
    chain_sites.sites = sites.sites;
    SkinDescription periodic = small_scene(37, 31);
    periodic.stencil = Stencil::fourth_order;
    periodic.edges = Edges::periodic;
    SkinOptions single, seven, own, compensated;
    seven.count = own.count = 7;
    for (int i = 0; i < 7; ++i) own.materials.push_back({.modulus = 1 + 0.3 * i, .viscosity = 0.5 + i});
    compensated.precision = Precision::f32_compensated;
    for (const double work : {1e3, 3e4}) {
        const Validated vulkan(shimmed(), {.validation = {}, .most_work = work});
        for (const SkinDescription& d : {SkinDescription(small_scene(40, 30)),
                                         with_chain(with_materials(ridged(40, 30))), sites, chain_sites, periodic})
            for (const SkinOptions& options : {single, compensated, seven})
                CHECK(pressed(vulkan.device(), d, options) == pressed(Device::cpu(1), d, options));
        CHECK(pressed(vulkan.device(), small_scene(30, 40), own) == pressed(Device::cpu(1), small_scene(30, 40), own));
        for (const std::string& frames : {std::string(), file}) {
            const Scene scene = marched(frames);
            std::vector<uint64_t> submissions;
            shim.submissions = &submissions;
            CHECK(numbers_of(run(scene, vulkan.device())) == numbers_of(run(scene, Device::cpu(1))));
            shim.submissions = nullptr;
            CHECK(double(submissions.size()) >= 64 * 40 * 30 * 6 / work); // numbers of 64 steps, at the least
        }
    }
}

TEST_CASE("no submission of a press is more work than its limit; the limit is about a second of a software driver's") {
    CHECK(vulkan::context_of(*Device::open("vulkan").impl().backend)->pipelines().device().most_work <= 2e8);
    struct Case {
        int width, height, count;
        uint64_t cells; // of a workgroup
    };
    for (const Case& c : {Case{256, 300, 1, 512}, Case{64, 64, 50, 512}, Case{512, 256, 3, 512}})
        for (const int elements : {1, 3}) {
            CAPTURE(c.width);
            CAPTURE(elements);
            constexpr double most = 3e5;
            const Device device = open_device("0", shimmed(), {.validation = {}, .most_work = most});
            SkinDescription d = small_scene(c.width, c.height);
            if (elements > 1) d.material.elements = {{3, 0.1}, {2, 0.9}, {1, 4}};
            SkinOptions options{.precision = Precision::f32_compensated, .count = c.count};
            Skin skin(device, d, options);
            const std::vector<float> pressures(size_t(c.width * c.height * c.count), 1.0f);
            std::vector<uint64_t> submissions;
            shim.submissions = &submissions;
            skin.press(pressures, 0.01);
            shim.submissions = nullptr;
            const uint64_t all = std::accumulate(submissions.begin(), submissions.end(), uint64_t(0));
            CHECK(all * c.cells == pressures.size());   // each cell once
            const int numbers = 2 * (elements + 1) + 4; // sums with their errors, for SA2 one more, and four responses
            const double work = double(pressures.size()) * numbers;
            for (const uint64_t groups : submissions) CHECK(double(groups * c.cells) * numbers <= most);
            CHECK(double(submissions.size()) >= work / most);
            CHECK(double(submissions.size()) <= 2 * work / most + 2); // nor much less
        }
}
