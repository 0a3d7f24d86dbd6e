// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include "host/core/base/text.hpp"
#include "host/core/press/device.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/scene_names.hpp"
#include "plot_script.h"

#include <algorithm>
#include <chrono>
#include <map>

#include <fmt/format.h>

namespace dermis::cli {
namespace {

// Returns the time of a clock that runs evenly, s.
double seconds_now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

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

// The numbers of each output of a run: of a quantity's traces and fields, or of the sites of a class.
using Outputs = std::map<std::string, std::vector<double>>;

Outputs outputs_of(const Scene& scene, const Result& r) {
    Outputs all;
    const auto add = [&](const std::string& output, const auto& numbers) {
        all[output].insert(all[output].end(), numbers.begin(), numbers.end());
    };
    for (const TraceColumn& column : trace_columns(r))
        add(column.name.substr(0, column.name.find('_')), *column.values);
    for (const Field& f : r.fields) add(name(f.quantity), f.values);
    for (size_t i = 0; i < r.responses.size(); ++i)
        all["site " + std::string(name(scene.sites[i % scene.sites.size()].type))].push_back(r.responses[i]);
    return all;
}

// The exact outputs of a scene, and the greatest exact value of each over all cells and times.
struct Truth {
    Outputs outputs;
    std::map<std::string, double> greatest;

    explicit Truth(Scene scene) {
        scene.method = Method::exact;
        scene.model.reset(), scene.precision = Precision::f64, scene.tolerance.reset();
        const auto add = [&](const Outputs& some) {
            for (const auto& [output, numbers] : some)
                for (double v : numbers) greatest[output] = std::max(greatest[output], std::abs(v));
        };
        add(outputs = outputs_of(scene, run(scene)));
        if (!scene.output.traces.empty() && !std::exchange(scene.output.extremes, true))
            add(outputs_of(scene, run(scene)));
    }
};

// A way to compute a scene, and what it took.
struct Way {
    Method method;
    Candidate candidate; // its error is the bound, NaN without one; refused: why it cannot be run
    double step;
    std::vector<double> seconds = {}; // of runs, ascending
    double error = std::nan("");
    std::string worst = {}; // the output with this error; empty where there is no error
    output::Contents outputs = {};

    bool broken() const { return error > candidate.error; }
};

void compare(Way& way, const Truth& truth, const Outputs& outputs) {
    way.error = 0;
    for (const auto& [output, numbers] : outputs) {
        const std::vector<double>& exact = truth.outputs.at(output);
        for (size_t i = 0; i < numbers.size(); ++i) {
            const double error = std::abs(numbers[i] - exact.at(i));
            if (error > 0 && error / truth.greatest.at(output) > way.error)
                way.error = error / truth.greatest.at(output), way.worst = output;
        }
        way.outputs.add(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double));
    }
}

void print(const Way& w) {
    fmt::print("{:<14} {:<8} {:<16} {:<24.24} step {:<9.4g} ", name(w.method), name(w.candidate.model),
               name(w.candidate.precision), w.candidate.device, w.step);
    if (w.seconds.empty()) return fmt::print("refused\n");
    fmt::print("{:>9.3g} s  error {:<8.2g}{:<8}", w.seconds[w.seconds.size() / 2], w.error,
               w.worst.empty() ? "" : "in " + w.worst);
    if (std::isfinite(w.candidate.error))
        fmt::print(" at most {:.2g}{}", w.candidate.error, w.broken() ? ": BROKEN" : "");
    fmt::print("\n");
}

// Runs a scene again and again for half a second, at least three times and at most nine times, and prints the result.
Way measured(Way way, const Scene& scene, const Device& device, const Truth& truth) {
    const double start = seconds_now();
    try {
        for (int runs = 0; runs < 3 || (runs < 9 && seconds_now() - start < 0.5); ++runs) {
            const double before = seconds_now();
            const Result r = run(scene, device);
            way.seconds.push_back(seconds_now() - before);
            if (runs > 0) continue;
            way.candidate.model = r.model;
            compare(way, truth, outputs_of(scene, r));
        }
    } catch (const Error& e) {
        if (e.code() != Error::Code::bad_input) throw;
        way.candidate.refused = e.what();
    }
    std::ranges::sort(way.seconds);
    print(way);
    std::fflush(stdout);
    return way;
}

// Every candidate that a plan could take.
void add_candidates(std::vector<Way>& ways, Scene scene, const Device& cpu, const Device& device) {
    scene.tolerance.reset();
    const Truth truth(scene);
    for (const Device* at : {&cpu, &device}) {
        if (at == &device && !device.info().vulkan) continue; // the CPU path again
        for (const Candidate& c : plan(scene, *at).candidates) {
            const bool vulkan = c.device != cpu.info().name;
            if (!c.steps || vulkan != at->info().vulkan) continue; // not in question, or of the other device
            Scene own = scene;
            own.model = c.model, own.precision = c.precision;
            const Explanation plan = dermis::plan(own, *at); // has the bound, even where it was not needed to choose
            Candidate candidate = c;
            candidate.error = plan.candidates[plan.chosen].error, candidate.refused.clear();
            ways.push_back(measured({scene.method, candidate, scene.time.step}, own, *at, truth));
        }
    }
}

// Every other method. A smaller step has more outputs, and means over shorter steps, so that each has a truth of its
// own.
void add_methods(std::vector<Way>& ways, const Scene& scene, const Device& cpu) {
    for (int divisor : {1, 2, 4}) { // of the step
        Scene own = scene;
        own.allow_unstable = true;
        own.model.reset(), own.precision = Precision::f64, own.tolerance.reset();
        own.time.step /= divisor;
        const Truth truth(own);
        for (const scene::Name<Method>& method : scene::Names<Method>::all) {
            if (method.value == Method::exact || method.value == Method::published) continue;
            own.method = method.value;
            const Candidate march{.precision = Precision::f64, .device = cpu.info().name, .bytes = std::nan("")};
            ways.push_back(measured({method.value, march, own.time.step}, own, cpu, truth));
        }
    }
}

std::string table_of(const std::vector<Way>& ways) {
    std::string text = "method,model,precision,device,step,seconds,seconds_low,seconds_high,error,bound,bytes,hash,"
                       "refused\n";
    const auto number = [](double x) { return std::isfinite(x) ? shortest(x) : std::string(); };
    for (const Way& w : ways) {
        const size_t n = w.seconds.size();
        const auto quartile = [&](size_t quarters) { return n ? number(w.seconds[quarters * (n - 1) / 4]) : ""; };
        text += fmt::format("{},{},{},\"{}\",{},{},{},{},{},{},{},{},\"{}\"\n", name(w.method), name(w.candidate.model),
                            name(w.candidate.precision), w.candidate.device, shortest(w.step), quartile(2), quartile(1),
                            quartile(3), number(w.error), number(w.candidate.error), number(w.candidate.bytes),
                            n ? fmt::format("{:016x}", w.outputs.hash) : "", w.candidate.refused);
    }
    return text;
}

} // namespace

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
    fmt::print("{}\nnext: dermis plan {}\n", text, path);
    return 0;
}

int bench_errors(const std::string& path, const output::Path& out, const std::string& device) {
    const auto [scene, files] = scene::read_scene(path, {});
    output::need_inputs_kept(files, {out / "errors.csv", out / "errors.png"});
    const Device cpu = Device::cpu(), other = Device::open(device);
    std::vector<Way> ways;
    add_candidates(ways, scene, cpu, other);
    add_methods(ways, scene, cpu);
    const output::Folder folder(out);
    output::write_file(folder.path() / "errors.csv", table_of(ways));
    fmt::print("{}\n", (folder.path() / "errors.csv").string());
    std::fflush(stdout);
    Scene free = scene; // has the default tolerance
    free.tolerance.reset();
    const double tolerance = scene.tolerance.value_or(plan(free, cpu).tolerance);
    const std::string file = output::Path(path).filename().string();
    const bool drawn = output::draw(plot_script, folder.path(), {"errors", file, shortest(tolerance)}).empty();
    fmt::print("open first: {}\nnext: dermis plan {}\n",
               (folder.path() / (drawn ? "errors.png" : "errors.csv")).string(), path);
    return std::ranges::any_of(ways, &Way::broken);
}

} // namespace dermis::cli
