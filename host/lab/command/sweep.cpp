// SPDX-License-Identifier: MIT
#include "host/lab/command/commands.hpp"

#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/units.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace dermis::cli {
namespace {

using output::Path;

constexpr size_t most_runs = 100000;

[[noreturn]] void refuse(const std::string& override_, const std::string& allowed) {
    throw Error(Error::Code::bad_input, "--set", fmt::format("--set {}; allowed: {}", override_, allowed));
}

bool is_assignment(const std::string& word) {
    const size_t equals = word.find('=');
    return equals != std::string::npos && equals > 0 && word[0] != '-' &&
           std::all_of(word.begin(), word.begin() + std::ptrdiff_t(equals),
                       [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '.' || c == '-' || c == ' '; });
}

// Splits at each `separator` that stands in no brackets and no quotes.
std::vector<std::string> split(const std::string& override_, const std::string& text, char separator) {
    std::vector<std::string> parts(1);
    int depth = 0;
    char quote = 0;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quote) {
            if (c == '\\' && quote == '"' && i + 1 < text.size()) parts.back() += text[i++];
            else if (c == quote) quote = 0;
        } else if (c == '"' || c == '\'') quote = c;
        else if (c == '[' || c == '{') ++depth;
        else if (c == ']' || c == '}') --depth;
        if (c == separator && depth == 0 && !quote) parts.emplace_back();
        else parts.back() += text[i];
    }
    if (depth != 0 || quote) refuse(override_, "brackets and quotes that are closed");
    return parts;
}

// A whole number is written without a fraction or exponent, so that keys of whole numbers take it.
std::string number_text(double x) {
    return x == std::floor(x) && std::abs(x) < 1e15 ? fmt::format("{:.0f}", x) : fmt::format("{}", x);
}

// Appends the numbers of a range, or the value as it stands.
void append_values(const std::string& override_, const std::string& value, std::vector<std::string>& values) {
    std::vector<std::string> parts = split(override_, value, ':');
    const bool logarithmic = parts.size() > 1 && parts.back() == "log";
    if (logarithmic) parts.pop_back();
    std::vector<double> numbers(parts.size());
    bool range = parts.size() > 1 || logarithmic;
    for (size_t i = 0; i < parts.size(); ++i) range = range && scene::read_number(parts[i], numbers[i]);
    if (!range) return values.push_back(value);
    const double count = numbers.back();
    if (parts.size() != 3 || count != std::floor(count) || count < 2 || count > double(most_runs))
        refuse(override_, fmt::format("first:last:count as a range, with a whole count in 2..{}", most_runs));
    const double first = numbers[0], last = numbers[1], steps = count - 1;
    if (logarithmic && !(first > 0 && last > 0)) refuse(override_, "first:last:count:log with first and last > 0");
    for (double i = 0; i <= steps; ++i) {
        const double share = i / steps;
        const double inside = logarithmic ? first * std::pow(last / first, share) : first + (last - first) * i / steps;
        values.push_back(number_text(i == steps ? last : i == 0 ? first : inside));
    }
}

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

// Returns the overrides that have a column of their own. A run has its model and its precision in other columns.
std::vector<std::string> in_columns(std::vector<std::string> overrides) {
    std::erase_if(overrides, [](const std::string& o) { return key_of(o) == "model" || key_of(o) == "precision"; });
    return overrides;
}

// Returns runs.csv: the run and its figures, the keys that are set, the outcomes, and all settings in one text. Figures
// and outcomes are empty unless all runs are finished.
std::string table_of(const std::vector<PlannedRun>& runs, const std::vector<output::Figures>& finished) {
    output::Json outcomes = output::Json::object(); // of all runs, which differ where their outputs do
    for (const output::Figures& f : finished) outcomes.update(f.outcomes);
    std::string table = "run";
    for (const char* column : output::figure_columns) (table += ",") += column;
    for (const std::string& override_ : in_columns(runs[0].overrides)) table += "," + key_of(override_);
    for (const auto& [name, value] : outcomes.items()) table += "," + name;
    table += ",set\n";
    for (size_t i = 0; i < runs.size(); ++i) {
        const output::Figures f = finished.empty() ? output::Figures() : finished[i];
        table += std::to_string(i + 1);
        for (size_t c = 0; c < std::size(output::figure_columns); ++c)
            table += "," + (finished.empty() ? "" : f.values[c]);
        for (const std::string& override_ : in_columns(runs[i].overrides)) table += "," + value_of(override_);
        for (const auto& [name, value] : outcomes.items())
            table += "," + output::in_table(f.outcomes.value(name, output::Json()));
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

// Leaves a table of what is to come in the folder of a sweep, which shows the next command that the folders are a
// sweep's. Removes earlier runs, except the ones that stay.
void begin_sweep(const Path& out, const Plan& plan, bool resume) {
    output::remove_earlier_run(out);
    output::remove_earlier_sweep(out, resume ? plan.runs.size() + 1 : 1);
    output::write_file(out / "runs.csv", table_of(plan.runs, {}));
}

} // namespace

std::vector<std::string> with_each_set(const std::vector<std::string>& words) {
    std::vector<std::string> all;
    bool after_set = false;
    for (const std::string& word : words) {
        const bool value = !all.empty() && all.back() == "--set";
        if (after_set && !value && is_assignment(word)) all.push_back("--set");
        after_set = word == "--set" || word.rfind("--set=", 0) == 0 || (after_set && is_assignment(word));
        all.push_back(word);
    }
    return all;
}

std::vector<Setting> settings_of(const std::vector<std::string>& overrides) {
    std::vector<Setting> all;
    for (const std::string& o : overrides) {
        const size_t equals = o.find('=');
        if (equals == std::string::npos || equals == 0) refuse(o, "key=value, as in time.step=0.001");
        Setting setting{.key = o.substr(0, equals), .values = {}};
        setting.key.erase(std::remove(setting.key.begin(), setting.key.end(), ' '), setting.key.end());
        if (std::ranges::any_of(all, [&](const Setting& other) { return other.key == setting.key; }))
            refuse(o, fmt::format("{} once; several values are {}=a,b", setting.key, setting.key));
        for (const std::string& value : split(o, o.substr(equals + 1), ',')) {
            if (value.find_first_not_of(' ') == value.npos)
                refuse(o, "a value after = and after each comma; a text without letters is \"\"");
            append_values(o, value, setting.values);
        }
        all.push_back(std::move(setting));
    }
    return all;
}

std::vector<std::vector<std::string>> combinations(const std::vector<Setting>& settings) {
    size_t runs = 1;
    for (const Setting& s : settings)
        if ((runs *= s.values.size()) > most_runs)
            refuse(s.key + "=..", fmt::format("at most {} runs in all combinations", most_runs));
    std::vector<std::vector<std::string>> all(runs);
    for (size_t run = 0, each = runs; run < runs; ++run, each = runs)
        for (const Setting& s : settings)
            all[run].push_back(s.key + "=" + s.values[run / (each /= s.values.size()) % s.values.size()]);
    return all;
}

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
        if (!resume || !output::is_finished(plan.folder(out, i), plan.origin(i))) open.push_back(i);
    const size_t at_once = plan.share_maps ? most_at_once : 1;
    for (size_t next = 0; next < open.size(); next += at_once) {
        const std::vector<size_t> some(open.begin() + std::ptrdiff_t(next),
                                       open.begin() + std::ptrdiff_t(std::min(next + at_once, open.size())));
        std::vector<Material> materials;
        for (size_t i : some) materials.push_back(plan.runs[i].scene.material);
        const std::vector<Result> results = run(plan.runs[some[0]].scene, materials, device, options);
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
