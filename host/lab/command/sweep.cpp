// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

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
    std::string table = "run";
    for (const auto& [column, place] : output::figure_columns) (table += ",") += column;
    for (const std::string& override_ : in_columns(runs[0].overrides)) table += "," + key_of(override_);
    for (const std::string& name : names) table += "," + name;
    table += ",set\n";
    for (size_t i = 0; i < runs.size(); ++i) {
        const output::Figures f = finished.empty() ? output::Figures() : finished[i];
        table += std::to_string(i + 1);
        for (size_t c = 0; c < std::size(output::figure_columns); ++c)
            table += "," + (finished.empty() ? "" : f.values[c]);
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

// Leaves a table of what is to come in the folder of a sweep, which shows the next command that the folders are a
// sweep's. Removes earlier runs, except the ones that stay.
void begin_sweep(const Path& out, const Plan& plan, bool resume) {
    output::remove_earlier_run(out);
    output::remove_earlier_sweep(out, resume ? plan.runs.size() + 1 : 1);
    output::write_file(out / "runs.csv", table_of(plan.runs, {}));
}

} // namespace

Path Plan::folder(const Path& out, size_t run) const { return runs.size() > 1 ? out / std::to_string(run + 1) : out; }

output::Json Plan::origin(size_t run) const {
    return output::origin_of(text, asked, runs[run].overrides, runs[run].inputs);
}

Plan plan_of(const std::string& path, const Path& out, const std::vector<Setting>& settings, output::Json asked) {
    const scene::SceneText text = scene::text_of_file(path);
    Plan plan{.text = text.text, .asked = std::move(asked), .share_maps = share_maps(settings), .runs = {}};
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

RunsDone run_all(const output::Folder& folder, const Plan& plan, const Device& device, const RunOptions& options,
                 bool resume, const std::function<void(size_t, const Result&)>& done) {
    const Path& out = folder.path();
    const bool several = plan.runs.size() > 1;
    std::vector<size_t> open; // runs that are not finished
    for (size_t i = 0; i < plan.runs.size(); ++i)
        if (!resume || !output::is_finished(plan.folder(out, i), plan.runs[i].scene, plan.origin(i))) open.push_back(i);
    const size_t at_once = plan.share_maps ? most_at_once : 1;
    for (size_t next = 0; next < open.size(); next += at_once) {
        const std::vector<size_t> some(open.begin() + std::ptrdiff_t(next),
                                       open.begin() + std::ptrdiff_t(std::min(next + at_once, open.size())));
        const std::vector<Result> results = results_of(plan.runs, some, device, options);
        if (several && next == 0) begin_sweep(out, plan, resume);
        for (size_t i = 0; i < some.size(); ++i) {
            std::optional<output::Folder> own;
            if (several) own.emplace(plan.folder(out, some[i]));
            output::write_result(own ? *own : folder, plan.runs[some[i]].scene, results[i], plan.origin(some[i]));
            done(some[i], results[i]);
        }
    }
    if (several && open.empty()) begin_sweep(out, plan, resume);
    if (!several) output::remove_earlier_sweep(out, 1);
    std::vector<output::Figures> figures;
    for (size_t i = 0; i < plan.runs.size(); ++i) figures.push_back(output::figures_of(plan.folder(out, i)));
    if (several) output::write_file(out / "runs.csv", table_of(plan.runs, figures));
    return {.before = plan.runs.size() - open.size(), .right = std::ranges::none_of(figures, &output::Figures::wrong)};
}

} // namespace dermis::cli
