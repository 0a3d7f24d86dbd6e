// SPDX-License-Identifier: MIT
// The dermis command. Exit status: 0 done, 1 failed or cells differ, 2 bad input.
#include "host/core/base/memory.hpp"
#include "host/core/press/device.hpp"
#include "host/core/press/report.hpp"
#include "host/lab/command/commands.hpp"
#include "host/lab/scenes/key_rows.hpp"
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/scene_names.hpp"
#include "host/lab/scenes/units.hpp"
#include "plot_script.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace dermis::cli {
namespace {

constexpr char out_of_memory[] = "dermis: out of memory\n";

// Ends the command with status 1 where an allocation fails before main(), or in a function of a parser that may not
// throw. Any other exception ends it as it would have.
std::terminate_handler terminate_otherwise;
[[noreturn]] void terminate_without_memory() {
    if (std::current_exception()) try {
            throw;
        } catch (const std::bad_alloc&) {
            output::remove_leftovers();
            [[maybe_unused]] const ssize_t n = ::write(2, out_of_memory, sizeof out_of_memory - 1);
            std::_Exit(1);
        } catch (...) {
        }
    terminate_otherwise();
    std::abort();
}
// The priority puts this before the objects of other headers and files.
struct Terminator {
    Terminator() { terminate_otherwise = std::set_terminate(terminate_without_memory); }
};
[[gnu::init_priority(101)]] Terminator terminator;

struct Arguments {
    std::string scene, out, folder, device = "auto", precision;
    std::string checked_device; // empty: every device
    std::vector<std::string> overrides;
    bool check = false, resume = false, json = false, errors = false, verbose = false;
    int pads = 1;
    FitArguments fit;
};

// A stencil estimate with its scale.
std::string shown_estimate(double estimate, double greatest) {
    return fmt::format("stencil estimate |C5 - C4| = {:.3g}, {:.2g} % of the greatest |C|", estimate,
                       greatest > 0 ? 100 * estimate / greatest : 0);
}

RunOptions options_of(const Arguments& a) {
    return {.precision = scene::value_of<Precision>(a.precision), .check = a.check, .describe_each = true};
}

Device device_of(const Arguments& a) { return a.device == "auto" ? open_when_marching() : Device::open(a.device); }

output::Json json_of(const Scene& scene, const std::vector<std::string>& overrides, const Explanation& e) {
    output::Json json = {{"set", overrides}};
    DERMIS_KEYS(json, scene.grid, width, height);
    DERMIS_KEYS(json, scene, method);
    DERMIS_KEYS(json, e, tolerance, binding, stencil_estimate, greatest_curvature, retardation_times,
                strain_between_frames, fa1_between_frames, fine_load, chosen, candidates);
    return json;
}

// Prints every candidate with its cost and error, and why it is taken or not.
void print_plan(const Arguments& a, const Scene& scene, const Explanation& e) {
    fmt::print("{}: {} x {} cells, {} outputs, method {}, tolerance {}{}\n", a.scene, scene.grid.width,
               scene.grid.height, e.candidates[e.chosen].steps, name(scene.method), e.tolerance,
               e.binding ? "" : " (default: of what is chosen freely)");
    fmt::print("   {} at rest, apart from the errors below\n",
               shown_estimate(e.stencil_estimate, e.greatest_curvature));
    if (!std::isnan(e.fine_load))
        fmt::print("   {:.2g} % of the load is finer than receptors{} lie deep\n", 100 * e.fine_load,
                   scene::has_depth(scene.receptors) ? "" : " of a fingertip (receptors.depth = \"fingertip\")");
    if (e.retardation_times.size() == 1)
        fmt::print(
            "   materials differ, but all have tau = {:.6g} s: the strain is pressure over {}, times one function of "
            "time\n",
            e.retardation_times[0], std::isfinite(e.retardation_times[0]) ? "modulus" : "viscosity");
    else if (e.retardation_times.size() > 1)
        fmt::print(
            "   materials have tau = {:.6g} s: the strain is the sum of {} maps, each times a function of time\n",
            fmt::join(e.retardation_times, ", "), e.retardation_times.size());
    if (scene.load.interval)
        fmt::print(
            "   {} between frames {:.4g} s apart: between lines and parabolas the strain differs by {:.2g} of its "
            "greatest value and FA1 by {:.2g};\n   of a vibration of {:.3g} Hz they keep nine tenths, of {:.3g} Hz "
            "four\n",
            scene.load.hold == Hold::linear ? "lines" : "parabolas", *scene.load.interval, e.strain_between_frames,
            e.fa1_between_frames, vibration_between(*scene.load.interval), 0.5 / *scene.load.interval);
    for (size_t i = 0; i < e.candidates.size(); ++i) {
        const Candidate& c = e.candidates[i];
        fmt::print("{} {} in {} on {}\n", i == e.chosen ? "->" : "  ", name(c.model), name(c.precision), c.device);
        if (c.steps)
            fmt::print("       {} steps, {} dispatches, {} of memory, about {:.2g} s\n", c.steps, c.dispatches,
                       scene::bytes_text(c.bytes), c.seconds);
        if (!std::isnan(c.error)) fmt::print("       error at most {:.2g}\n", c.error);
        if (!c.refused.empty()) fmt::print("       not taken: {}\n", c.refused);
    }
}

int explain_scene(const Arguments& a) {
    const auto runs = combinations(settings_of(a.overrides));
    const Device device = device_of(a);
    output::Json plans = output::Json::array();
    for (const auto& overrides : runs) {
        const Scene scene = Scene::from_file(a.scene, overrides);
        const Explanation e = dermis::plan(scene, device, options_of(a));
        if (a.json) {
            plans.push_back(json_of(scene, overrides, e));
            continue;
        }
        if (runs.size() > 1) fmt::print("{}\n", fmt::join(overrides, " "));
        print_plan(a, scene, e);
    }
    if (a.json) output::print(plans);
    return 0;
}

// Prints the predicted and the measured error, if they are known.
void print_error(const Scene& scene, const Result& r) {
    if (std::isnan(r.predicted_error)) return;
    fmt::print("error at most {:.2g}", r.predicted_error);
    if (!std::isnan(r.measured_error))
        fmt::print(", measured {:.2g} (in pressed cells: {})", r.measured_error, r.measured_cells);
    else if (scene.tolerance) fmt::print(", nothing measured");
    fmt::print("{}\n", r.unmeasured.empty() ? "" : fmt::format("; not measured: {}", r.unmeasured));
}

// Prints how a result was computed, and the figures of the whole skin.
void print_details(const Arguments& a, const Scene& s, const Result& r) {
    const auto span = [](double from, double to) {
        return from == to ? fmt::format("{:.6g}", from) : fmt::format("{:.6g}..{:.6g}", from, to);
    };
    const double cells = double(s.grid.width) * s.grid.height;
    fmt::print("{} x {} cells, {} steps, {}, {}, {} on {}: {:.3f} s", s.grid.width, s.grid.height, r.steps,
               name(s.method), name(r.model), name(r.precision), shown(r.device), r.seconds);
    if (a.check) fmt::print(" with the other backend and the comparison\n");
    else fmt::print(", {:.2f} ns per cell-step\n", 1e9 * r.seconds / (cells * double(r.steps)));
    fmt::print("tau = {} s, z = dt/tau = {}\n", span(r.tau_min, r.tau_max),
               span(s.time.step / r.tau_max, s.time.step / r.tau_min));
    if (r.model == Model::sites) return fmt::print("{} sites, without the rest of the skin\n", s.sites.size());
    fmt::print("greatest |l*C| = {:.4g}\n{}\n", r.greatest_gain,
               shown_estimate(r.stencil_estimate, r.greatest_curvature));
    if (std::isfinite(r.cells_per_ridge)) fmt::print("{:.1f} cells per ridge\n", r.cells_per_ridge);
}

void print_result(const Arguments& a, const Scene& scene, const Result& r) {
    for (const std::string& line : output::greatest_responses(scene, r)) fmt::print("{}\n", line);
    if (!scene.afferents.empty()) fmt::print("{}\n", output::spikes_line(scene, r));
    print_error(scene, r);
    if (a.check) fmt::print("{} cells compared, {} different\n", r.cells_compared, r.cells_different);
}

int run_scene(const Arguments& a) {
    const output::Path out = a.out;
    const Plan plan = plan_of(a.scene, out, settings_of(a.overrides), // a bad run is refused first
                              {{"device", a.device}, {"precision", a.precision}, {"check", a.check}});
    const Scene& scene = plan.runs[0].scene;
    const bool several = plan.runs.size() > 1;
    const Device device = device_of(a);
    const output::Folder folder(out);
    output::Progress progress(a.scene);
    RunOptions options = options_of(a);
    if (!several) options.progress = std::ref(progress);
    std::string refused; // why "auto" found no Vulkan device, if one was looked for
    const auto say = [&](size_t run, const Result& r) {
        progress.clear();
        const Scene& own = plan.runs[run].scene;
        const std::string which = several ? fmt::format("run {}: ", run + 1) : "";
        if (r.measured_error > r.predicted_error)
            fmt::print(stderr, "dermis: {}the measured error is above the prediction: these results are wrong\n",
                       which);
        if (a.json) return;
        if (!several) print_result(a, own, r);
        for (const std::string& warning : output::warnings(own, r)) fmt::print("{}warning: {}\n", which, warning);
        if (refused != r.device.refused) fmt::print("{}\n", refused = r.device.refused);
        if (a.verbose && !several) print_details(a, own, r);
        if (several) progress(double(run + 1) / double(plan.runs.size()));
    };
    const RunsDone done = run_all(folder, plan, device, options, a.resume, say);
    progress.clear();
    if (a.json) {
        output::Json summaries = output::Json::array();
        for (size_t i = 0; i < plan.runs.size(); ++i) summaries.push_back(output::summary_of(plan.folder(out, i)));
        output::print(summaries);
        return done.right ? 0 : 1;
    }
    if (a.resume) fmt::print("{} of {} runs were done before\n", done.before, plan.runs.size());
    const bool traced = scene.sites.empty() || !scene.output.traces.empty();
    const char* first = several ? "runs.csv" : traced ? "traces.csv" : "receptors.csv";
    fmt::print("open first: {}\nnext: dermis plot {}\n", (out / first).string(), a.out);
    return done.right ? 0 : 1;
}

// Draws what a run or a sweep has left in a folder.
int plot_folder(const std::string& folder) {
    const output::Path in = folder;
    if (!output::is_ours(in))
        throw Error(
            Error::Code::bad_input, "",
            fmt::format("{}: has neither summary.json nor runs.csv of dermis; allowed: the folder of a run or a sweep",
                        folder));
    const output::Folder locked(in);
    output::Json units = output::Json::object(); // of keys
    for (const std::string& key : scene::known_keys()) units[key] = scene::unit_of_key(key);
    const std::string why_not = output::draw(plot_script, in, {"run", output::text_of(units)});
    if (!why_not.empty()) throw Error(Error::Code::io, "", "no pictures: " + why_not);
    fmt::print("next: xdg-open {}\n", (in / "report.html").string());
    return 0;
}

void add_scene(CLI::App& command, Arguments& a) {
    command.add_option("scene", a.scene, "A scene file (TOML)")->required();
}

void add_json(CLI::App& command, Arguments& a, const char* what) { command.add_flag("--json", a.json, what); }

CLI::Option* add_device(CLI::App& command, std::string& device) {
    return command.add_option("--device", device,
                              "auto, cpu, vulkan, a row of `dermis devices`, or part of a name or uuid");
}

void add_backend(CLI::App& command, Arguments& a) {
    std::vector<std::string> precisions;
    for (const scene::Name<Precision>& name : scene::Names<Precision>::all) precisions.push_back(name.text);
    add_device(command, a.device)->capture_default_str();
    command.add_option("--precision", a.precision, "f32, f32-compensated or f64 (CPU only)")
        ->check(CLI::IsMember(precisions));
}

void add_overrides(CLI::App& command, Arguments& a) {
    command
        .add_option("--set", a.overrides,
                    "Override keys: time.step=0.001 load.radius=9. Several values, material.modulus=1,2, or a range,\n"
                    "first:last:count as 0.1:1:4 or first:last:count:log, make a sweep of all combinations. A list in\n"
                    "brackets and a text in quotes are one value: output.traces=[\"sa1\"],[\"sa2\"]")
        ->take_all()
        ->allow_extra_args(false)
        ->type_name("KEY=VALUE[,VALUE ..] ..");
}

void add_fit(CLI::App& command, FitArguments& a) {
    command
        .add_option(
            "data", a.data,
            "CSV files, each a curve: a line of names, as time,modulus or time,compliance or time,strain,stress,\n"
            "then a number for each in each line")
        ->required();
    command
        .add_option("--elements", a.elements,
                    "Most elements of the chain, springs and dashpots included; by default as few as describe the data")
        ->check(CLI::Range(1, 8));
    command.add_option(
        "--kind", a.options.kind,
        "creep (strain per stress) or relaxation (stress per strain); told by the name of the second column\n"
        "if that is compliance, strain, modulus or stress");
    command.add_option("--stress", a.options.stress, "The stress in Pa, if the second column is the strain under it");
    command.add_option("--strain", a.options.strain, "The strain, if the second column is the stress in Pa under it");
    command.add_option("--residual", a.options.residual,
                       "relative to each value, or absolute; by default relative, of histories absolute");
    command.add_option("--out", a.out, "Folder for material.toml, fit.csv and fit.png");
}

// Prints the keys whose dotted name begins so, as load or load.radius, or all, as tables of Markdown.
void print_keys(const std::string& asked) {
    std::string table = "?";
    bool found = false;
    for (const scene::KeyRow& row : scene::key_rows()) {
        const std::string dotted = row.table + row.name;
        if (asked != "all" && !dotted.starts_with(asked) && row.name != asked) continue;
        if (row.table != table) {
            table = row.table;
            fmt::print("{}{}\n\n| key | unit | default | allowed | meaning |\n|---|---|---|---|---|\n",
                       found ? "\n" : "",
                       table.empty() ? "Top of the file" : "[" + table.substr(0, table.size() - 1) + "]");
        }
        found = true;
        fmt::print("| `{}` | {} | {} | {} | {} |\n", row.name, row.unit, row.by_default, row.allowed, row.says);
    }
    if (!found)
        throw Error(Error::Code::bad_input, "--keys",
                    "--keys " + asked +
                        ": no such table or key; allowed: all, or the beginning of a key, as load.radius");
}

// Each subcommand sets the status when it has been parsed.
void add_commands(CLI::App& app, Arguments& a, int& status) {
    const auto add = [&](const char* name, const char* what, auto&& execute) {
        CLI::App* const command = app.add_subcommand(name, what);
        command->callback([&status, execute] { status = execute(); });
        return command;
    };
    CLI::App* const run = add("run", "Run a scene file", [&] { return run_scene(a); });
    add_scene(*run, a);
    run->add_option("--out", a.out, "Folder for the results")->required();
    add_backend(*run, a);
    run->add_flag("--check", a.check, "Also run the other backend and compare every cell's bits");
    run->add_flag("--resume", a.resume,
                  "Keep runs in --out that are finished, of the same scene, version and commit, and do the rest");
    run->add_flag("--verbose", a.verbose, "Also print model, device and time, tau and z, and the skin's curvature");
    add_json(*run, a, "Print the summary.json of each run, and nothing else");
    add_overrides(*run, a);
    run->add_option_function<std::string>(
           "--keys",
           [](const std::string& asked) {
               print_keys(asked);
               throw CLI::Success();
           },
           "Print the keys of a scene file that begin so, as load or load.radius, or all; each with unit and range")
        ->type_name("KEY")
        ->trigger_on_parse();
    add("plot", "Draw a run or a sweep: pictures, and report.html with all of them",
        [&] { return plot_folder(a.folder); })
        ->add_option("folder", a.folder, "The --out of a run")
        ->required();
    CLI::App* const plan =
        add("plan", "Say how a scene would be run, why, and why not otherwise", [&] { return explain_scene(a); });
    add_scene(*plan, a);
    add_backend(*plan, a);
    add_overrides(*plan, a);
    add_json(*plan, a, "Print the plans as JSON");
    CLI::App* const bench = add("bench", "Say how long a press of a scene's skin takes on this machine", [&] {
        return a.errors ? bench_errors(a.scene, a.out, a.device) : bench_scene(a.scene, a.pads, a.device);
    });
    add_scene(*bench, a);
    bench->add_option("--count", a.pads, "Pads, skins alike, that are pressed together")->capture_default_str();
    add_device(*bench, a.device)->capture_default_str();
    CLI::Option* const errors = bench->add_flag(
        "--errors", a.errors, "Run the scene by every candidate of its plan and every other method: time and error");
    errors->needs(
        bench->add_option("--out", a.out, "Folder for errors.csv and its chart, with --errors")->needs(errors));
    add_fit(*add("fit", "Fit a material to measured creep or relaxation", [&] { return fit_data(a.fit); }), a.fit);
    add_json(*add("devices", "List devices", [&] { return list_devices(a.json); }), a, "Print the devices as JSON");
    CLI::App* const check = add("check", "Compare every kernel's bits on every device with the CPU path",
                                [&] { return check_devices(a.checked_device, a.json); });
    add_device(*check, a.checked_device);
    add_json(*check, a, "Print the hashes as JSON");
}

// Refuses the first word, unless it is an option or a subcommand, and each long option that the subcommand does not
// have. Names the nearest one, or the key of a scene.
void need_known(const CLI::App& app, const std::vector<std::string>& words) {
    const auto refuse = [](const std::string& what, const std::vector<std::string>& known, const std::string& meant) {
        throw Error(Error::Code::bad_input, "", fmt::format("{}; allowed: {}{}", what, fmt::join(known, ", "), meant));
    };
    std::vector<std::string> known;
    for (const CLI::App* command : app.get_subcommands({})) known.push_back(command->get_name());
    if (words.empty()) refuse("a subcommand is required", known, "");
    const bool option_first = words[0].starts_with('-');
    if (!option_first && !std::ranges::count(known, words[0]))
        refuse("\"" + words[0] + "\" is no subcommand", known, scene::suggestion(words[0], known));
    const CLI::App& command = option_first ? app : *app.get_subcommand(words[0]);
    known.clear();
    for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    for (size_t i = 0; i < words.size() && words[i] != "--"; ++i) {
        if (!words[i].starts_with("--")) continue;
        const std::string word = words[i].substr(0, words[i].find('='));
        const CLI::Option* option = command.get_option_no_throw(word);
        if (option && option->get_expected_min() > 0 && word == words[i]) ++i; // the next word is its value
        if (option) continue;
        std::string meant = scene::suggestion(word, known);
        const std::string key = meant.empty() ? scene::nearest(word.substr(2), scene::known_keys()) : "";
        if (!key.empty()) meant = "; did you mean --set " + key + "=VALUE?";
        refuse(fmt::format("\"{}\" is no option of {}", word, command.get_name()), known, meant);
    }
}

int command(const std::vector<std::string>& given) {
    CLI::App app{"dermis: pressure on skin in, mechanoreceptor responses out", "dermis"};
    app.require_subcommand(1);
    app.set_version_flag("--version", fmt::format("dermis {} (commit {})", version(), commit()));
    Arguments arguments;
    int status = 0;
    add_commands(app, arguments, status);
    need_known(app, given);
    std::vector<std::string> words = with_each_set(given);
    std::reverse(words.begin(), words.end()); // as the parser takes them
    try {
        app.parse(std::move(words));
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() == 0) return app.exit(e); // --help and --version
        throw Error(Error::Code::bad_input, "", e.what());
    }
    return status;
}

} // namespace
} // namespace dermis::cli

int main(int argc, char** argv) {
    using namespace dermis;
    std::signal(SIGXFSZ, SIG_IGN); // a file that grows too large is then an error of write()
    output::remove_leftovers_on_signals();
    try {
        const int status = cli::command({argv + std::min(argc, 1), argv + argc});
        if (std::fflush(stdout) != 0 || std::ferror(stdout))
            throw Error(Error::Code::io, "",
                        fmt::format("standard output cannot be written ({})", std::strerror(errno)));
        return status;
    } catch (const std::bad_alloc&) {
        std::fputs(cli::out_of_memory, stderr);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "dermis: %s\n", e.what());
        const auto* const error = dynamic_cast<const Error*>(&e);
        if (error && error->code() == Error::Code::bad_input) return 2;
    }
    return 1;
}
