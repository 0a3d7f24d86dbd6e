// SPDX-License-Identifier: MIT
#include "host/output/earlier.hpp"

#include "dermis/dermis.hpp"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

namespace dermis::output {
namespace {

namespace fs = std::filesystem;

bool begins_with(const fs::path& path, const std::string& start) {
    std::error_code none;
    if (!fs::is_regular_file(path, none)) return false;
    std::string text(start.size(), ' ');
    std::ifstream in(path, std::ios::binary);
    return in.read(text.data(), std::streamsize(text.size())) && text == start;
}

// Whether a run has files of this name: the fixed ones, and {quantity}_t{time}.npy.
bool is_ours(std::string name) {
    if (name.ends_with(".part")) name.resize(name.size() - 5); // left by a run that was killed
    for (const char* fixed : {"traces.csv", "impulses.csv", "receptors.csv", "responses.npy", "summary.json"})
        if (name == fixed) return true;
    const size_t time = name.find("_t");
    if (time == name.npos || !name.ends_with(".npy")) return false;
    const std::string number = name.substr(time + 2, name.size() - 4 - (time + 2));
    bool quantity = false;
    for (int q = 0; q <= int(Quantity::deformation); ++q) quantity |= name.substr(0, time) == dermis::name(Quantity(q));
    return quantity && !number.empty() && number.find_first_not_of("0123456789.e+-") == number.npos;
}

void remove_file(const fs::path& path) {
    std::error_code error;
    fs::remove(path, error);
    if (error)
        throw Error(Error::Code::io, "",
                    fmt::format("{}: cannot be removed ({}), and is an earlier run's", path.string(), error.message()));
}

} // namespace

void remove_earlier_run(const fs::path& folder, const std::vector<std::string>& kept) {
    if (!begins_with(folder / "summary.json", made_by_dermis)) return;
    std::vector<fs::path> stale;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (is_ours(name) && !entry.is_directory() && std::find(kept.begin(), kept.end(), name) == kept.end())
            stale.push_back(entry.path());
    }
    // summary.json goes last: until then a run that was stopped here can be finished by the next.
    std::sort(stale.begin(), stale.end(), [](const fs::path& a, const fs::path& b) {
        return (a.filename() == "summary.json") < (b.filename() == "summary.json");
    });
    for (const fs::path& path : stale) remove_file(path);
}

void remove_earlier_sweep(const fs::path& folder, size_t first) {
    if (!begins_with(folder / "runs.csv", runs_columns)) return;
    std::ifstream table(folder / "runs.csv");
    size_t lines = 0;
    for (std::string line; std::getline(table, line);) ++lines;
    for (size_t run = first; run < lines; ++run) {
        const fs::path of_run = folder / std::to_string(run);
        if (!begins_with(of_run / "summary.json", made_by_dermis)) continue;
        remove_earlier_run(of_run, {});
        std::error_code not_empty;
        fs::remove(of_run, not_empty);
    }
    if (first == 1) remove_file(folder / "runs.csv");
}

} // namespace dermis::output
