// SPDX-License-Identifier: MIT
#include "host/lab/study/study.hpp"

#include "host/core/base/text.hpp"
#include "host/lab/output/drawing.hpp"
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/origin.hpp"

#include "figures_script.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <future>
#include <memory>
#include <optional>

#include <fmt/format.h>

namespace dermis::study {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::pair<const char*, Surface::Kind> surfaces[] = {
    {"flat", Surface::Kind::flat}, {"wave", Surface::Kind::wave}, {"spiral", Surface::Kind::spiral}};
constexpr std::pair<const char*, Load::Kind> loads[] = {
    {"circular", Load::Kind::circular}, {"point", Load::Kind::point}, {"linear", Load::Kind::linear}};
constexpr Method methods[] = {Method::published, Method::exact};

std::map<std::string, Scene> all_scenes() {
    std::map<std::string, Scene> scenes;
    for (Method method : methods) {
        for (auto [surface, s] : surfaces)
            for (auto [load, l] : loads)
                scenes[fmt::format("{}/{}_{}", name(method), surface, load)] = study_scene(s, l, method);
        for (int i = 0; i < 5; ++i) {
            Scene scene = study_scene(Surface::Kind::wave, Load::Kind::circular, method);
            scene.material.modulus = 1 + 0.25 * i;
            scenes[fmt::format("sweep_modulus/{}/{}", shortest(*scene.material.modulus), name(method))] = scene;
            scene.material = {};
            scene.material.viscosity = (4 + 9 * i) / 40.0; // 0.1 .. 1.0
            scenes[fmt::format("sweep_viscosity/{}/{}", shortest(*scene.material.viscosity), name(method))] = scene;
        }
    }
    return scenes;
}

// Returns the greatest |float - double| of any trace, relative to the greatest |double| of the same trace.
double float_error(const Result& f32, const Result& f64) {
    double worst = 0;
    for (const Trace& t : f64.traces) {
        const Trace& f = f32.trace(t.quantity);
        double error = 0, largest = 0;
        for (size_t n = 0; n < t.mean.size(); ++n)
            for (auto [a, b] : {std::pair{f.mean[n], t.mean[n]}, {f.min[n], t.min[n]}, {f.max[n], t.max[n]}}) {
                error = std::max(error, std::abs(a - b));
                largest = std::max(largest, std::abs(b));
            }
        if (largest > 0) worst = std::max(worst, error / largest);
    }
    return worst;
}

// Prints the phase as it begins, and its seconds when it is done.
template <class Work> void timed(const char* phase, Work work) {
    fmt::print("{} ..\n", phase);
    std::fflush(stdout);
    const auto start = Clock::now();
    work();
    fmt::print("  {:<34} {:6.2f} s\n", phase, std::chrono::duration<double>(Clock::now() - start).count());
    std::fflush(stdout);
}

void write_maps(const Path& folder) {
    const output::Folder locked(folder);
    for (auto [surface, kind] : surfaces) {
        const Scene s = study_scene(kind, Load::Kind::circular, Method::exact);
        output::write_file(folder / fmt::format("surface_{}.npy", surface),
                           output::npy_of(maps(s).surface, s.grid.width, s.grid.height));
    }
    for (auto [load, kind] : loads) {
        const Scene s = study_scene(Surface::Kind::flat, kind, Method::exact);
        output::write_file(folder / fmt::format("pressure_{}.npy", load),
                           output::npy_of(maps(s).pressure, s.grid.width, s.grid.height));
    }
}

// Removes what an earlier study wrote, which the summary of a scene shows. If the study is resumed, its finished scenes
// stay. Maps and pictures stay until they are replaced, each whole.
void remove_earlier_study(const Path& out, bool resume) {
    bool shown = false;
    for (const auto& [folder, scene] : all_scenes()) {
        if (!output::begins_with(out / folder / "summary.json", output::made_by_dermis)) continue;
        shown = true;
        if (!resume) output::remove_earlier_run(output::Folder(out / folder).path());
    }
    for (const char* name : {"claims.md", "chart.csv", "chart_device.txt", "stability.csv", "failures.csv"})
        if (shown) std::filesystem::remove(out / name);
}

// Two scenes run at a time, each on a device of its own: a software driver leaves cores idle while it is waited for.
using Devices = std::array<std::unique_ptr<Device>, 2>;

// Both are null where there is no Vulkan.
Devices open_devices() {
    Devices devices;
    try {
        for (auto& device : devices) device = std::make_unique<Device>(Device::open("vulkan"));
        fmt::print("Vulkan: {}, {}\n", devices[0]->info().name, devices[0]->info().driver);
    } catch (const Error& e) {
        fmt::print("no Vulkan, so nothing is compared: {}\n", e.what());
        return {};
    }
    return devices;
}

struct Done {
    std::optional<Result> f32; // none where an earlier study has written it
    Result f64;
};

Done run_both(const Scene& scene, const Device* vulkan, bool finished) {
    if (finished) return {{}, in_double(scene)};
    const RunOptions options{.precision = Precision::f32, .check = vulkan != nullptr};
    return {run(scene, vulkan ? *vulkan : Device::cpu(1), options), in_double(scene)};
}

// A scene of the study is known by its folder.
std::string origin_of(const std::string& folder, const Device* vulkan) {
    return output::text_of({.scene = "study " + folder,
                            .overrides = {},
                            .inputs = {},
                            .device = vulkan ? vulkan->info().name + ", " + vulkan->info().driver : "cpu",
                            .precision = name(Precision::f32),
                            .check = vulkan != nullptr});
}

struct Totals {
    StudyRuns runs;
    long long cell_steps = 0, compared = 0, different = 0;
};

// Prints the scene's row, writes its folder unless it is finished, and adds it to the totals.
void finish(const Path& out, const std::string& folder, const Scene& scene, Done done, const std::string& origin,
            Totals& totals) {
    if (done.f32) {
        const long long cell_steps = 1LL * scene.grid.width * scene.grid.height * done.f32->steps;
        fmt::print("{:<36} {:>12} {:>14} {:>15} {:>10.1e}\n", folder, cell_steps, done.f32->cells_compared,
                   done.f32->cells_different, float_error(*done.f32, done.f64));
        totals.cell_steps += cell_steps;
        output::write_result(output::Folder(out / folder), scene, *done.f32, origin);
    }
    const output::Figures figures = output::figures_of(out / folder);
    if (!done.f32)
        fmt::print("{:<36} {:>12} {:>14} {:>15}\n", folder, "done before", figures.compared, figures.different);
    std::fflush(stdout);
    totals.compared += figures.compared;
    totals.different += figures.different;
    totals.runs[folder] = {scene, std::move(done.f64)};
}

// A scene that is running, and the device that it occupies.
struct Lane {
    std::string folder;
    const Device* device;
    std::future<Done> done;
};

Totals run_scenes(const Path& out, const Devices& devices, bool resume) {
    const std::map<std::string, Scene> scenes = all_scenes();
    fmt::print("{:<36} {:>12} {:>14} {:>15} {:>10}\n", "scene", "cells x steps", "cells compared", "cells different",
               "f32 error");
    std::fflush(stdout);
    Totals totals;
    output::Progress progress("study");
    std::deque<Lane> lanes; // in the order of the scenes
    auto next = scenes.begin();
    const auto start = [&](const Device* device) {
        if (next == scenes.end()) return;
        const auto& [folder, scene] = *next++;
        const bool finished = resume && output::is_finished(out / folder, scene, origin_of(folder, device));
        lanes.push_back({folder, device, std::async(std::launch::async, run_both, scene, device, finished)});
    };
    for (const auto& device : devices) start(device.get());
    while (!lanes.empty()) {
        Lane lane = std::move(lanes.front());
        lanes.pop_front();
        Done done = lane.done.get();
        start(lane.device); // runs while this scene's files are written
        progress.clear();
        finish(out, lane.folder, scenes.at(lane.folder), std::move(done), origin_of(lane.folder, lane.device), totals);
        progress(double(totals.runs.size()) / double(scenes.size()));
    }
    progress.clear();
    fmt::print("{} scenes, {} cell-steps each on {}; {} cells compared, {} different\n", scenes.size(),
               totals.cell_steps, devices[0] ? "Vulkan, CPU float and CPU double" : "CPU float and CPU double",
               totals.compared, totals.different);
    return totals;
}

// The machine that the chart's Vulkan rows were measured on, for the chart's title.
std::string chart_device(const Device* vulkan) {
    if (!vulkan) return "no Vulkan device\n";
    return fmt::format("Vulkan: {}{}\n", vulkan->info().name,
                       vulkan->info().kind == "software" ? ", a software driver on the CPU's own cores" : "");
}

void print_places(const Path& out, const std::string& why_not) {
    const auto place = [&](const char* what, const char* where) {
        fmt::print("{:<16}{}\n", what, (out / where).string());
    };
    place("claims", "claims.md");
    if (why_not.empty()) place("pictures", "figures");
    else fmt::print("no pictures: {}\n", why_not);
    place("published runs", "published");
    place("exact runs", "exact");
    place("modulus sweep", "sweep_modulus");
    place("viscosity sweep", "sweep_viscosity");
    place("maps", "maps");
    place("error chart", "chart.csv");
    place("chart's device", "chart_device.txt");
    place("stability map", "stability.csv");
    place("failing courses", "failures.csv");
}

} // namespace

Scene study_scene(Surface::Kind surface, Load::Kind load, Method method) {
    Scene s;
    s.surface.kind = surface;
    s.load.kind = load;
    s.method = method;
    s.output.probes = {{75, 75}, {85, 85}, {60, 80}, {37, 37}, {112, 112}};
    s.output.fields = {{9.99, {Quantity::deformation, Quantity::curvature, Quantity::sa1}}};
    return s;
}

Result in_double(const Scene& scene) { return run(scene, Device::cpu(1), {.precision = Precision::f64}); }

int reproduce(const Path& out, bool resume) {
    const output::Folder folder(out);
    remove_earlier_study(out, resume);
    const Devices devices = open_devices();
    const Device* vulkan = devices[0].get();
    Totals totals;
    std::string why_not;
    timed("scenes and sweeps", [&] { totals = run_scenes(out, devices, resume); });
    timed("claims", [&] { output::write_file(out / "claims.md", claims(totals.runs)); });
    timed("error against time", [&] {
        output::write_file(out / "chart.csv", error_against_time(vulkan));
        output::write_file(out / "chart_device.txt", chart_device(vulkan));
    });
    timed("stability map", [&] {
        output::write_file(out / "stability.csv", stability_map());
        output::write_file(out / "failures.csv", failing_courses());
    });
    timed("pictures", [&] {
        write_maps(out / "maps");
        const output::Folder figures(out / "figures");
        why_not = output::draw(figures_script, out);
    });
    print_places(out, why_not);
    return totals.different ? 1 : 0;
}

} // namespace dermis::study
