// SPDX-License-Identifier: MIT
#include "host/lab/output/earlier.hpp"

#include "dermis/version.hpp"
#include "host/core/base/text.hpp"
#include "host/lab/output/output.hpp"
#include "host/lab/scenes/input_file.hpp"
#include "host/lab/scenes/scene_names.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace dermis::output {
namespace {

namespace fs = std::filesystem;

// The files that dermis plot may write into the folder of a run or a sweep.
const std::vector<std::string> drawn = {"report.html",   "skin.png",   "skin.svg",    "traces.png",  "traces.svg",
                                        "maps.png",      "maps.svg",   "surface.png", "surface.svg", "receptors.png",
                                        "receptors.svg", "spikes.png", "spikes.svg",  "events.png",  "events.svg",
                                        "sweep.png",     "sweep.svg"};

// Whether a run has files of this name, or a sweep pictures: the fixed ones, and {quantity}_t{time}.npy.
bool is_result(const std::string& name) {
    for (const char* fixed : {"traces.csv", "impulses.csv", "receptors.csv", "responses.npy", "spikes.npy",
                              "afferents.csv", "psth.csv", "summary.json"})
        if (name == fixed) return true;
    if (std::ranges::count(drawn, name)) return true;
    const size_t time = name.find("_t");
    if (time == name.npos || !name.ends_with(".npy")) return false;
    const std::string number = name.substr(time + 2, name.size() - 4 - (time + 2));
    const std::optional<Quantity> quantity = scene::value_of<Quantity>(name.substr(0, time));
    return quantity && *quantity <= Quantity::deformation && !number.empty() &&
           number.find_first_not_of("0123456789.e+-") == number.npos;
}

const std::string runs_columns = "run,model,precision,"; // begins each runs.csv

// Returns whether a path is a regular file that begins with `start`.
bool begins_with(const Path& path, const std::string& start) {
    std::ifstream in;
    std::string text(start.size(), ' ');
    return scene::open_file(path.string(), in).empty() && in.read(text.data(), std::streamsize(text.size())) &&
           text == start;
}

std::string text_in(const Path& file) {
    std::string text;
    scene::read_file(file.string(), text);
    return text;
}

// Returns the number of lines of an earlier sweep's runs.csv, the first of which has the columns; 0 where there is
// none.
size_t lines_of_sweep(const fs::path& folder) {
    if (!begins_with(folder / "runs.csv", runs_columns)) return 0;
    const std::string table = text_in(folder / "runs.csv");
    return size_t(std::ranges::count(table, '\n')) + (!table.empty() && table.back() != '\n');
}

// Returns a JSON object's text up to its last brace.
std::string opening(const Json& json) {
    const std::string text = text_of(json);
    return text.substr(0, text.size() - 2);
}

// Returns a text with its hash as last key; `text` is all before that.
std::string with_hash(std::string text) {
    Contents contents;
    contents.add(text.data(), text.size());
    return text + fmt::format(",\n  \"fnv1a\": \"{:016x}\"\n}}\n", contents.hash);
}

// Calls `take` with a folder's summary.json.
template <class Take> auto taken_from(const Path& folder, const Take& take) {
    const Path file = folder / "summary.json";
    try {
        return take(Json::parse(text_in(file)));
    } catch (const Json::exception& e) {
        throw Error(Error::Code::io, "", fmt::format("{}: {}", file.string(), e.what()));
    }
}

} // namespace

void remove_file(const fs::path& path) {
    std::error_code error;
    fs::remove(path, error);
    if (error)
        throw Error(Error::Code::io, "",
                    fmt::format("{}: cannot be removed ({}), and is an earlier run's", path.string(), error.message()));
}

bool is_ours(const Path& folder) {
    return begins_with(folder / "summary.json", made_by_dermis) || begins_with(folder / "runs.csv", runs_columns);
}

void need_inputs_kept(const std::vector<std::string>& inputs, const std::vector<fs::path>& files) {
    std::error_code none;
    for (const fs::path& given : files) {
        const fs::path file = fs::weakly_canonical(given, none); // NEW/.. is a folder before NEW is made
        if (!fs::exists(file, none)) continue;
        const auto input = std::ranges::find_if(inputs, [&](auto& path) { return fs::equivalent(path, file, none); });
        if (input == inputs.end()) continue;
        throw Error(
            Error::Code::bad_input, "",
            fmt::format("{}: is read{}, and this command or dermis plot would remove or replace it; allowed: another "
                        "--out, or inputs that lie elsewhere",
                        file.string(), *input == file ? "" : " as " + *input));
    }
}

void need_inputs_kept(const fs::path& folder, size_t runs, const std::vector<std::string>& written,
                      const std::vector<std::string>& inputs) {
    const size_t lines = lines_of_sweep(folder);
    const auto check = [&](const fs::path& of_run, const std::vector<std::string>& names) {
        std::vector<fs::path> files = earlier_run(of_run).files;
        for (const auto* list : {&names, &drawn})
            for (const std::string& name : *list) files.push_back(of_run / name);
        need_inputs_kept(inputs, files);
    };
    check(folder, runs ? std::vector<std::string>{"runs.csv"} : written);
    for (size_t run = 1; run < std::max(runs + 1, lines); ++run)
        check(folder / std::to_string(run), run <= runs ? written : std::vector<std::string>());
}

EarlierRun earlier_run(const fs::path& folder, const std::vector<std::string>& kept) {
    EarlierRun run;
    std::error_code error;
    if (!fs::is_directory(folder, error)) return run;
    const bool shown = is_ours(folder);
    fs::directory_iterator entries(folder, error);
    if (error == std::errc::not_enough_memory) throw std::bad_alloc();
    if (error)
        throw Error(Error::Code::io, "", fmt::format("{}: cannot be read ({})", folder.string(), error.message()));
    for (const fs::directory_entry& entry : entries) {
        const std::string name = entry.path().filename().string();
        if (!is_result(name)) continue;
        run.owned = shown;
        if (shown && !entry.is_directory() && !std::ranges::count(kept, name)) run.files.push_back(entry.path());
    }
    // summary.json goes last: until then a run that was stopped here can be finished by the next.
    std::ranges::sort(run.files, {}, [](const fs::path& file) { return file.filename() == "summary.json"; });
    return run;
}

void remove_earlier_run(const fs::path& folder) {
    for (const fs::path& path : earlier_run(folder).files) remove_file(path);
}

void remove_earlier_sweep(const fs::path& folder, size_t first) {
    const size_t lines = lines_of_sweep(folder);
    for (size_t run = first; run < lines; ++run) {
        const fs::path of_run = folder / std::to_string(run);
        std::error_code none;
        if (!fs::is_directory(of_run, none)) continue;
        remove_earlier_run(Folder(of_run).path());
        fs::remove(of_run, none); // where nothing else is in it
    }
    if (lines && first == 1) remove_file(folder / "runs.csv");
}

void Contents::add(const char* more, size_t count) {
    bytes += count;
    for (size_t i = 0; i < count; ++i) hash = fnv1a(hash, static_cast<unsigned char>(more[i]));
}

Contents contents_of(const Path& path) {
    Contents contents{path.filename().string()};
    std::ifstream in(path, std::ios::binary);
    for (char block[1 << 16]; in.read(block, sizeof block), in.gcount() > 0;) contents.add(block, size_t(in.gcount()));
    if (!in.eof()) throw Error(Error::Code::io, "", path.string() + ": cannot be read");
    return contents;
}

void to_json(Json& json, const Contents& c) {
    json = {{"file", c.name}, {"bytes", c.bytes}, {"fnv1a", fmt::format("{:016x}", c.hash)}};
}

Json origin_of(const std::string& scene, const Json& asked, const std::vector<std::string>& set,
               const std::vector<Contents>& inputs) {
    return {{"program", "dermis"}, {"version", version()}, {"commit", commit()}, {"scene", scene},
            {"set", set},          {"inputs", inputs},     {"asked", asked}};
}

std::string sealed(const Json& summary) { return with_hash(opening(summary)); }

bool is_finished(const Path& folder, const Json& origin) {
    if (!begins_with(folder / "summary.json", opening(origin) + ",")) return false;
    const std::string text = text_in(folder / "summary.json");
    if (text != with_hash(text.substr(0, text.rfind(",\n")))) return false;
    return taken_from(folder, [&](Json&& summary) {
        return std::ranges::all_of(summary.at("files"), [&](const Json& file) {
            const Path path = folder / file.at("file").get<std::string>();
            return fs::is_regular_file(path) && Json(contents_of(path)) == file;
        });
    });
}

std::string in_table(const Json& value) {
    if (value.is_number_float()) return shortest(value.get<double>());
    return value.is_null() ? "" : value.is_string() ? value.get<std::string>() : value.dump();
}

Json summary_of(const Path& folder) {
    return taken_from(folder, [](Json&& summary) { return std::move(summary); });
}

Figures figures_of(const Path& folder) {
    return taken_from(folder, [](Json&& summary) {
        Figures figures{.outcomes = Json::object()};
        Json &plan = summary.at("plan"), &check = summary.at("cross_check");
        if (check.is_null()) check = {{"cells", 0}, {"different", 0}};
        plan["cells_compared"] = check.at("cells"), plan["cells_different"] = check.at("different");
        for (const char* column : figure_columns)
            figures.values.push_back(in_table(plan.contains(column) ? plan[column] : summary.at(column)));
        figures.outcomes.update(summary.at("outcomes"));
        const auto error = [&](const char* key) {
            const Json& value = plan[key];
            return value.is_null() ? std::nan("") : value.get<double>();
        };
        figures.wrong = check["different"] != 0 || error("measured_error") > error("predicted_error");
        return figures;
    });
}

} // namespace dermis::output
