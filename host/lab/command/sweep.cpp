// SPDX-License-Identifier: MIT
#include "host/lab/command/sweep.hpp"

#include "host/lab/output/earlier.hpp"
#include "host/lab/output/output.hpp"
#include "host/lab/scenes/scene.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace dermis::cli {
namespace {

using output::Path;

constexpr size_t most_at_once = 16; // runs over one map that are computed together

std::string in_quotes(const std::string& text) {
    std::string out = "\"";
    for (char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
    return out + '"';
}

// Returns the key or the value of an override. A text has no quotes, unless a comma or a quote in it needs them.
std::string key_of(const std::string& override_) { return override_.substr(0, override_.find('=')); }
std::string value_of(const std::string& override_) {
    std::string value = override_.substr(override_.find('=') + 1);
    const bool text = value.size() > 1 && (value[0] == '"' || value[0] == '\'') && value.back() == value[0];
    if (text) value = value.substr(1, value.size() - 2);
    return value.find_first_of(",\"") == value.npos ? value : in_quotes(value);
}

Path folder_of(const Path& out, size_t run) { return out / std::to_string(run + 1); }

constexpr const char* figure_columns =
    "seconds,predicted_error,measured_error,greatest_gain,kinks,cells_compared,cells_different";

// Returns the names of all outcomes, which differ between runs where their outputs do.
std::vector<std::string> outcomes_of(const std::vector<output::Figures>& finished) {
    std::vector<std::string> names;
    std::set<std::string> known;
    for (const output::Figures& f : finished)
        for (const auto& [name, value] : f.outcomes)
            if (known.insert(name).second) names.push_back(name);
    return names;
}

// Returns the overrides that have a column of their own. A run has its model and its precision in other columns.
std::vector<std::string> in_columns(std::vector<std::string> overrides) {
    std::erase_if(overrides, [](const std::string& o) { return key_of(o) == "model" || key_of(o) == "precision"; });
    return overrides;
}

// Returns runs.csv: the run and its figures, the keys that are set, the outcomes, and all settings in one text. Figures
// and outcomes are empty unless all runs are finished.
std::string table_of(const std::vector<PlannedRun>& runs, const std::vector<output::Figures>& finished) {
    const std::vector<std::string> names = outcomes_of(finished);
    std::string table = output::runs_columns + figure_columns;
    for (const std::string& override_ : in_columns(runs[0].overrides)) table += "," + key_of(override_);
    for (const std::string& name : names) table += "," + name;
    table += ",set\n";
    for (size_t i = 0; i < runs.size(); ++i) {
        const output::Figures f = finished.empty() ? output::Figures() : finished[i];
        table += fmt::format("{},{},{},{},{},{},{},{},", i + 1, f.model, f.precision, f.seconds, f.predicted_error,
                             f.measured_error, f.greatest_gain, f.kinks);
        table += finished.empty() ? "," : fmt::format("{},{}", f.compared, f.different);
        for (const std::string& override_ : in_columns(runs[i].overrides)) table += "," + value_of(override_);
        const std::map<std::string, std::string> outcomes(f.outcomes.begin(), f.outcomes.end());
        for (const std::string& name : names) table += "," + (outcomes.count(name) ? outcomes.at(name) : "");
        table += "," + in_quotes(fmt::format("{}", fmt::join(runs[i].overrides, " "))) + "\n";
    }
    return table;
}

// Returns whether the runs differ in numbers of the material alone, so that one reading of the maps serves all.
bool share_maps(const std::vector<Setting>& settings) {
    return std::ranges::all_of(settings, [](const Setting& s) {
        return s.values.size() == 1 || s.key == "material.modulus" || s.key == "material.viscosity";
    });
}

// Runs some scenes, one unless they share their maps.
std::vector<Result> results_of(const std::vector<PlannedRun>& runs, const std::vector<size_t>& some,
                               const Device& device, const RunOptions& options) {
    if (some.size() == 1) return {run(runs[some[0]].scene, device, options)};
    std::vector<Material> materials;
    for (size_t i : some) materials.push_back(runs[i].scene.material);
    return run(runs[some[0]].scene, materials, device, options);
}

// Writes runs as they are done, after what was there before has gone.
class Sweep {
  public:
    Sweep(const Path& out, const Plan& plan, const SweepOptions& options)
        : out_(out), plan_(plan), resume_(options.resume), quiet_(options.quiet) {
        for (size_t i = 0; i < runs_.size(); ++i)
            if (!resume_ || !output::is_finished(folder_of(out, i), runs_[i].scene, plan.origin(i))) open_.push_back(i);
    }

    const std::vector<size_t>& open() const { return open_; } // runs that are not finished

    void write(size_t i, const Result& result) {
        clear();
        if (!quiet_ && !result.device.refused.empty() && !refusal_shown_) fmt::print("{}\n", result.device.refused);
        refusal_shown_ |= !result.device.refused.empty();
        output::write_result(output::Folder(folder_of(out_, i)), runs_[i].scene, result, plan_.origin(i));
        for (const std::string& warning : output::warnings(runs_[i].scene, result))
            if (!quiet_) fmt::print("run {}: warning: {}\n", i + 1, warning);
    }

    // Writes the table. Returns whether no run is wrong.
    bool finish() {
        clear();
        if (resume_ && !quiet_)
            fmt::print("{} of {} runs were done before\n", runs_.size() - open_.size(), runs_.size());
        std::vector<output::Figures> figures;
        for (size_t i = 0; i < runs_.size(); ++i) figures.push_back(output::figures_of(folder_of(out_, i)));
        output::write_file(out_ / "runs.csv", table_of(runs_, figures));
        return std::ranges::all_of(figures, [](auto& f) { return !f.wrong(); });
    }

  private:
    // Removes earlier runs, except the ones that stay, and leaves a table of what is to come: it shows the next command
    // that the folders are a sweep's.
    void clear() {
        if (cleared_) return;
        cleared_ = true;
        output::remove_earlier_run(out_);
        output::remove_earlier_sweep(out_, resume_ ? runs_.size() + 1 : 1);
        output::write_file(out_ / "runs.csv", table_of(runs_, {}));
    }

    const Path& out_;
    const Plan& plan_;
    const std::vector<PlannedRun>& runs_ = plan_.runs;
    bool resume_, quiet_, cleared_ = false, refusal_shown_ = false;
    std::vector<size_t> open_;
};

} // namespace

std::string Plan::origin(size_t run) const {
    output::Origin origin = common;
    origin.overrides = runs[run].overrides;
    origin.inputs = runs[run].inputs;
    return output::text_of(origin);
}

Plan plan_of(const std::string& path, const Path& out, const std::vector<Setting>& settings, output::Origin asked) {
    const scene::SceneText text = scene::text_of_file(path);
    asked.scene = text.text;
    Plan plan{.common = std::move(asked), .runs = {}};
    std::set<std::string> inputs = {path}, written; // runs have most of them in common
    std::map<std::string, output::Contents> read;   // by their paths
    scene::FileMaps maps;
    for (auto& overrides : combinations(settings)) {
        scene::SceneWithFiles made = scene::read_scene(text, overrides, {}, &maps);
        PlannedRun run{.scene = std::move(made.scene), .overrides = std::move(overrides), .inputs = {}};
        for (const std::string& file : made.files) {
            if (!read.count(file)) read.emplace(file, output::contents_of(file));
            run.inputs.push_back(read.at(file));
        }
        inputs.insert(made.files.begin(), made.files.end());
        for (std::string& name : output::result_files(run.scene)) written.insert(std::move(name));
        plan.runs.push_back(std::move(run));
    }
    output::need_inputs_kept(out, plan.runs.size() > 1 ? plan.runs.size() : 0, {written.begin(), written.end()},
                             {inputs.begin(), inputs.end()});
    return plan;
}

bool sweep(const output::Folder& folder, const std::vector<Setting>& settings, const Plan& plan, const Device& device,
           const RunOptions& options, const SweepOptions& more) {
    Sweep sweep(folder.path(), plan, more);
    const size_t at_once = share_maps(settings) ? most_at_once : 1;
    for (auto next = sweep.open().begin(), end = sweep.open().end(); next != end;) {
        const auto last = next + std::ptrdiff_t(std::min(at_once, size_t(end - next)));
        const std::vector<size_t> some(next, last);
        const std::vector<Result> results = results_of(plan.runs, some, device, options);
        for (size_t i = 0; i < some.size(); ++i) sweep.write(some[i], results[i]);
        next = last;
    }
    return sweep.finish();
}

} // namespace dermis::cli
