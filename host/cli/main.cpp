// SPDX-License-Identifier: MIT
// The dermis command. Exit status: 0 done, 1 failed or cells differ, 2 bad input.
#include "host/check.hpp"
#include "host/device.hpp"
#include "host/scene/names.hpp"
#include "host/study/study.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <sstream>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace dermis::cli {
namespace {

struct Arguments {
    std::string scene, out, device = "auto", precision;
    std::string checked_device; // empty: every device
    std::vector<std::string> overrides;
    bool check = false;
};

std::string shown(const DeviceInfo& d) { return d.driver.empty() ? d.name : fmt::format("{} ({})", d.name, d.driver); }

// Prints the figures and warnings by which a user judges a result.
void print_scene(const Scene& s, const Result& r) {
    const auto span = [](double a, double b) {
        return a == b ? fmt::format("{:.6g}", a) : fmt::format("{:.6g}..{:.6g}", a, b);
    };
    fmt::print("tau = {} s, z = dt/tau = {}\n", span(r.tau_min, r.tau_max),
               span(s.time.step / r.tau_max, s.time.step / r.tau_min));
    if (r.model == Model::sites) {
        fmt::print("{} receptors, without the rest of the skin\n", s.sites.size());
        return;
    }
    fmt::print("greatest |l*C| = {:.4g}\n", r.greatest_gain);
    if (r.greatest_gain > 1) fmt::print("warning: |l*C| above 1: responses change sign there\n");
    fmt::print("stencil estimate |C5 - C4| = {:.3g}\n", r.stencil_estimate);
    if (r.kinks) fmt::print("warning: {} cells not convergent: kink\n", r.kinks);
    if (std::isfinite(r.cells_per_ridge)) fmt::print("{:.1f} cells per ridge\n", r.cells_per_ridge);
    if (r.cells_per_ridge < 8) fmt::print("warning: fewer than 8 cells per ridge: curvature is coarse\n");
}

std::string engineering(double x) {
    for (auto [unit, size] : {std::pair{"T", 1e12}, {"G", 1e9}, {"M", 1e6}, {"k", 1e3}})
        if (x >= size) return fmt::format("{:.3g} {}", x / size, unit);
    return fmt::format("{:.3g} ", x);
}

RunOptions options_of(const Arguments& a) {
    RunOptions options;
    options.precision = scene::value_of<Precision>(a.precision);
    options.check = a.check;
    return options;
}

// Only the CPU path computes in double, so with f64 the device auto is the CPU path.
Device device_of(const Arguments& a) {
    return Device::open(a.device == "auto" && a.precision == name(Precision::f64) ? "cpu" : a.device);
}

// Prints every candidate with its cost and error, and why it is taken or not.
int explain_scene(const Arguments& a) {
    const Scene scene = Scene::from_file(a.scene, a.overrides);
    const Device device = device_of(a);
    const Explanation e = explain(scene, device, options_of(a));
    fmt::print("{}: {} x {} cells, {} outputs, method {}, tolerance {}{}\n", a.scene, scene.grid.width,
               scene.grid.height, e.candidates[e.chosen].steps, name(scene.method), e.tolerance,
               e.binding ? "" : " (default: of what is chosen freely)");
    fmt::print("   stencil estimate |C5 - C4| = {:.3g}, apart from the errors below\n", e.stencil_estimate);
    for (size_t i = 0; i < e.candidates.size(); ++i) {
        const Candidate& c = e.candidates[i];
        fmt::print("{} {} in {} on {}\n", i == e.chosen ? "->" : "  ", name(c.model), name(c.precision), c.device);
        if (c.steps)
            fmt::print("       {} steps, {} dispatches, {}flop, {}B moved, {}B of memory, about {:.2g} s\n", c.steps,
                       c.dispatches, engineering(c.flops), engineering(c.traffic), engineering(c.bytes), c.seconds);
        if (!std::isnan(c.error)) fmt::print("       error at most {:.2g}\n", c.error);
        if (!c.refused.empty()) fmt::print("       not taken: {}\n", c.refused);
    }
    return 0;
}

// Splits key=v1,v2,.. into an override for each value. A list in brackets, or a text in quotes, is one value.
std::vector<std::string> values_of(const std::string& override_) {
    const size_t equals = override_.find('=');
    if (equals == std::string::npos || override_.find_first_of("[{\"'", equals) != std::string::npos)
        return {override_};
    std::vector<std::string> all;
    std::istringstream values(override_.substr(equals + 1));
    for (std::string value; std::getline(values, value, ',');) all.push_back(override_.substr(0, equals + 1) + value);
    return all.empty() ? std::vector<std::string>{override_} : all;
}

// Every combination of the overrides' values; the last key varies fastest.
std::vector<std::vector<std::string>> combinations(const std::vector<std::string>& overrides) {
    std::vector<std::vector<std::string>> all = {{}};
    for (const std::string& o : overrides) {
        std::vector<std::vector<std::string>> longer;
        for (const auto& before : all)
            for (const std::string& value : values_of(o)) {
                longer.push_back(before);
                longer.back().push_back(value);
            }
        all = std::move(longer);
    }
    return all;
}

// Writes OUT/1, OUT/2 .. and OUT/runs.csv. Where only the numbers of the material vary, the maps are read once.
int sweep(const Arguments& a, const Device& device, const RunOptions& options) {
    const output::Path out = a.out;
    const auto runs = combinations(a.overrides);
    std::vector<Scene> scenes; // all are read before any is run, so that a bad one is refused first
    for (const auto& values : runs) scenes.push_back(Scene::from_file(a.scene, values));
    const bool materials_only = std::all_of(a.overrides.begin(), a.overrides.end(), [](const std::string& o) {
        return values_of(o).size() == 1 || o.rfind("material.modulus=", 0) == 0 ||
               o.rfind("material.viscosity=", 0) == 0;
    });
    std::vector<Result> results;
    if (materials_only) {
        std::vector<Material> materials;
        for (const Scene& s : scenes) materials.push_back(s.material);
        results = run(scenes[0], materials, device, options);
    } else {
        for (const Scene& s : scenes) results.push_back(run(s, device, options));
    }
    std::string table = "run,model,precision,seconds,cells_compared,cells_different,set\n";
    bool same = true;
    for (size_t i = 0; i < runs.size(); ++i) {
        const Result& r = results[i];
        output::write_result(out / std::to_string(i + 1), scenes[i], r);
        table += fmt::format("{},{},{},{},{},{},\"{}\"\n", i + 1, name(r.model), name(r.precision), r.seconds,
                             r.cells_compared, r.cells_different, fmt::join(runs[i], " "));
        same &= r.cells_different == 0;
    }
    output::write_file(out / "runs.csv", table);
    fmt::print("{}: {} runs\n{}\n", a.scene, runs.size(), (out / "runs.csv").string());
    return same ? 0 : 1;
}

int run_scene(const Arguments& a) {
    const auto runs = combinations(a.overrides);
    const Scene scene = Scene::from_file(a.scene, runs[0]);
    const Device device = device_of(a);
    if (!device.info().refused.empty()) fmt::print("{}\n", device.info().refused);
    if (!device.info().exact) fmt::print("warning: the bits of {} differ from the CPU path's\n", device.info().name);
    RunOptions options = options_of(a);
    if (runs.size() > 1) return sweep(a, device, options);
    const output::Path out = a.out;
    output::Progress progress(a.scene);
    options.progress = std::ref(progress);
    const Result r = run(scene, device, options);
    output::write_result(out, scene, r);
    const double cells = double(scene.grid.width) * scene.grid.height;
    fmt::print("{}: {} x {} cells, {} steps, {}, {}, {} on {}", a.scene, scene.grid.width, scene.grid.height, r.steps,
               name(scene.method), name(r.model), name(r.precision), shown(r.device));
    if (!a.check)
        fmt::print(": {:.3f} s, {:.2f} ns per cell-step", r.seconds, 1e9 * r.seconds / (cells * double(r.steps)));
    fmt::print("\n");
    print_scene(scene, r);
    if (!std::isnan(r.predicted_error)) fmt::print("predicted error at most {:.2g}\n", r.predicted_error);
    if (a.check) fmt::print("{} cells compared, {} different\n", r.cells_compared, r.cells_different);
    fmt::print("{}\n", (out / "traces.csv").string());
    return r.cells_different ? 1 : 0;
}

int list_devices() {
    fmt::print("cpu: the CPU path, {} threads\n", std::thread::hardware_concurrency());
    try {
        int row = 0;
        for (const DeviceInfo& d : Device::list())
            fmt::print("{}: {}, {}, {}{}\n", row++, d.name, d.kind, d.driver,
                       d.refused.empty() ? "" : "; not usable: " + d.refused);
    } catch (const Error& e) {
        if (e.code() != Error::Code::no_device) throw;
        fmt::print("no Vulkan device: {}\n", e.what());
    }
    return 0;
}

int check_devices(const std::string& only) {
    std::vector<std::string> names = {only};
    if (only.empty()) {
        names.clear();
        for (size_t i = 0; i < Device::list().size(); ++i) names.push_back(std::to_string(i));
    }
    bool exact = true;
    for (const std::string& name : names) {
        const Device device = Device::open(name);
        const SelfTest test = self_test(*device.impl().backend);
        fmt::print("{}:", shown(device.info()));
        for (const SelfTest::Kernel& k : test.kernels)
            fmt::print(" {} {:016x} {} of {} differ;", k.name, k.hash, k.different, k.values);
        fmt::print(" {}\n", test.exact() ? "exact" : "NOT exact");
        exact &= test.exact();
    }
    return exact ? 0 : 1;
}

constexpr const char* devices_help = "auto, cpu, vulkan, a row of `dermis devices`, or part of a name";

void add_scene(CLI::App& command, Arguments& a) {
    command.add_option("scene", a.scene, "A scene file (TOML)")->required();
}

void add_backend(CLI::App& command, Arguments& a) {
    std::vector<std::string> precisions;
    for (const scene::Name<Precision>& name : scene::Names<Precision>::table) precisions.push_back(name.text);
    command.add_option("--device", a.device, devices_help)->capture_default_str();
    command.add_option("--precision", a.precision, "f32, f32-compensated or f64 (CPU only)")
        ->check(CLI::IsMember(precisions));
}

void add_overrides(CLI::App& command, Arguments& a) {
    command.add_option("--set", a.overrides, "Override a key: time.step=0.001")->take_all()->allow_extra_args(false);
}

struct Commands {
    CLI::App *run, *plan, *study, *devices, *check;
};

Commands add_commands(CLI::App& app, Arguments& a) {
    const Commands all{
        .run = app.add_subcommand("run", "Run a scene file"),
        .plan = app.add_subcommand("plan", "Say how a scene would be run, why, and why not otherwise"),
        .study = app.add_subcommand("study", "Reproduce the published study, with figures and claims"),
        .devices = app.add_subcommand("devices", "List devices"),
        .check = app.add_subcommand("check", "Compare every kernel's bits on every device with the CPU path")};
    add_scene(*all.run, a);
    all.run->add_option("--out", a.out, "Folder for the results")->required();
    add_backend(*all.run, a);
    all.run->add_flag("--check", a.check, "Also run the other backend and compare every cell's bits");
    add_overrides(*all.run, a);
    add_scene(*all.plan, a);
    add_backend(*all.plan, a);
    add_overrides(*all.plan, a);
    all.study->add_option("--out", a.out, "Folder for the results")->required();
    all.check->add_option("--device", a.checked_device, devices_help);
    return all;
}

int execute(const Commands& commands, const Arguments& a) {
    if (*commands.run) return run_scene(a);
    if (*commands.plan) return explain_scene(a);
    if (*commands.study) return study::reproduce(a.out);
    if (*commands.devices) return list_devices();
    return check_devices(a.checked_device);
}

} // namespace
} // namespace dermis::cli

int main(int argc, char** argv) {
    using namespace dermis;
    std::signal(SIGXFSZ, SIG_IGN); // a file that grows too large is then an error of write()
    CLI::App app{"dermis: pressure on skin in, mechanoreceptor responses out"};
    app.require_subcommand(1);
    app.set_version_flag("--version", fmt::format("dermis {} (commit {})", version(), commit()));
    cli::Arguments arguments;
    const cli::Commands commands = cli::add_commands(app, arguments);
    try {
        app.parse(argc, argv);
        return cli::execute(commands, arguments);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) ? 2 : 0;
    } catch (const Error& e) {
        fmt::print(stderr, "dermis: {}\n", e.what());
        return e.code() == Error::Code::bad_input ? 2 : 1;
    } catch (const std::exception& e) {
        fmt::print(stderr, "dermis: {}\n", e.what());
        return 1;
    }
}
