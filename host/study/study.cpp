// SPDX-License-Identifier: MIT
#include "host/study/study.hpp"

#include "host/scene/text.hpp"

#include "figures_script.h"

#include <cmath>
#include <cstdio>
#include <future>
#include <memory>

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
            scenes[fmt::format("sweep_modulus/{}/{}", shortest(scene.material.modulus), name(method))] = scene;
            scene.material = {};
            scene.material.viscosity = (4 + 9 * i) / 40.0; // 0.1 .. 1.0
            scenes[fmt::format("sweep_viscosity/{}/{}", shortest(scene.material.viscosity), name(method))] = scene;
        }
    }
    return scenes;
}

// Greatest |float - double| of any trace over the greatest |double| of that trace.
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

class Stages {
  public:
    void next(const std::string& stage) {
        const auto now = Clock::now();
        if (!stage_.empty())
            fmt::print("  {:<34} {:6.2f} s\n", stage_, std::chrono::duration<double>(now - start_).count());
        std::fflush(stdout);
        stage_ = stage;
        start_ = now;
    }

  private:
    std::string stage_;
    Clock::time_point start_;
};

void write_maps(const Path& folder) {
    std::filesystem::create_directories(folder);
    for (auto [surface, kind] : surfaces) {
        const Scene s = study_scene(kind, Load::Kind::circular, Method::exact);
        output::write_npy(folder / fmt::format("surface_{}.npy", surface), maps(s).surface, s.grid.width, s.grid.height);
    }
    for (auto [load, kind] : loads) {
        const Scene s = study_scene(Surface::Kind::flat, kind, Method::exact);
        output::write_npy(folder / fmt::format("pressure_{}.npy", load), maps(s).pressure, s.grid.width, s.grid.height);
    }
}

// The pictures, by the script that is compiled in; false where there is no Python with matplotlib.
bool draw(const Path& out) {
    const std::string python = "/usr/bin/python3"; // Debian's, which has Debian's matplotlib
    if (std::system((python + " -c 'import matplotlib' >/dev/null 2>&1").c_str()) != 0) return false;
    std::string quoted = "'";
    for (char c : out.string()) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    FILE* pipe = ::popen((python + " - " + quoted + "'").c_str(), "w");
    if (!pipe) return false;
    std::fwrite(figures_script, 1, sizeof figures_script - 1, pipe);
    if (::pclose(pipe) != 0) throw Error(Error::Code::io, "", "drawing the figures failed; its message stands above");
    return true;
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

Result in_double(const Scene& scene) {
    RunOptions f64;
    f64.precision = Precision::f64;
    return run(scene, Device::cpu(1), f64);
}

namespace {

struct Done {
    Result f32, f64;
};

Done run_both(const Scene& scene, const Device* vulkan) {
    RunOptions options;
    options.precision = Precision::f32;
    options.check = vulkan != nullptr;
    return {run(scene, vulkan ? *vulkan : Device::cpu(1), options), in_double(scene)};
}

} // namespace

int reproduce(const Path& out) {
    // Two scenes at a time, each with a device of its own: a software driver leaves cores idle while it is waited for.
    std::unique_ptr<Device> devices[2];
    try {
        for (auto& device : devices) device = std::make_unique<Device>(Device::open("vulkan"));
        fmt::print("Vulkan: {}, {}\n", devices[0]->info().name, devices[0]->info().driver);
    } catch (const Error& e) {
        fmt::print("no Vulkan, so nothing is compared: {}\n", e.what());
    }
    const Device* vulkan = devices[1] ? devices[0].get() : nullptr;
    const std::map<std::string, Scene> scenes = all_scenes();
    fmt::print("{:<36} {:>12} {:>14} {:>15} {:>10}\n", "scene", "cells x steps", "cells compared", "cells different",
               "f32 error");
    const auto start = Clock::now();
    StudyRuns runs;
    long long cell_steps = 0, compared = 0, different = 0;
    output::Progress progress("study");
    for (auto next = scenes.begin(); next != scenes.end();) {
        std::vector<std::pair<std::string, std::future<Done>>> lanes;
        for (auto& device : devices)
            if (next != scenes.end()) {
                lanes.emplace_back(next->first, std::async(std::launch::async, run_both, next->second,
                                                           vulkan ? device.get() : nullptr));
                ++next;
            }
        for (auto& [folder, lane] : lanes) {
            Done done = lane.get();
            const long long work = 22500LL * done.f32.steps;
            progress.clear();
            fmt::print("{:<36} {:>12} {:>14} {:>15} {:>10.1e}\n", folder, work, done.f32.cells_compared,
                       done.f32.cells_different, float_error(done.f32, done.f64));
            output::write_result(out / folder, scenes.at(folder), done.f32);
            cell_steps += work;
            compared += done.f32.cells_compared;
            different += done.f32.cells_different;
            runs[folder] = {scenes.at(folder), std::move(done.f64)};
        }
        progress(double(runs.size()) / double(scenes.size()));
    }
    progress.clear();
    fmt::print("{} scenes, {} cell-steps each on {}; {} cells compared, {} different\n", scenes.size(), cell_steps,
               vulkan ? "Vulkan, CPU float and CPU double" : "CPU float and CPU double", compared, different);
    fmt::print("  {:<34} {:6.2f} s\n", "scenes and sweeps",
               std::chrono::duration<double>(Clock::now() - start).count());
    Stages stages;
    stages.next("claims");
    output::write_file(out / "claims.md", claims(runs));
    stages.next("error against time");
    output::write_file(out / "chart.csv", error_against_time(vulkan));
    output::write_file(out / "chart_device.txt",
               vulkan
                   ? fmt::format("Vulkan: {}{}\n", vulkan->info().name,
                                 vulkan->info().kind == "software" ? ", a software driver on the CPU's own cores" : "")
                   : "no Vulkan device\n");
    stages.next("stability map");
    output::write_file(out / "stability.csv", stability_map());
    output::write_file(out / "failures.csv", failing_courses());
    stages.next("pictures");
    write_maps(out / "maps");
    const bool drawn = draw(out);
    stages.next("");
    fmt::print("claims    {}\n", (out / "claims.md").string());
    if (drawn) fmt::print("pictures  {}\n", (out / "figures").string());
    else fmt::print("no pictures: /usr/bin/python3 has no matplotlib (Debian: python3-matplotlib)\n");
    return different ? 1 : 0;
}

} // namespace dermis::study
