// SPDX-License-Identifier: MIT
// What earlier runs have left in a folder: finished runs, which need not be done again, and files that go, so that the
// folder holds those of one run or one sweep. Only files that dermis itself names are removed, and only where a file
// shows that dermis was there. Throws Error::io.
#pragma once

#include "host/core/base/hash.hpp"
#include "host/lab/output/json.hpp"

#include <filesystem>

namespace dermis::output {

inline const std::string made_by_dermis = "{\n  \"program\": \"dermis\","; // begins each summary.json
inline const std::string runs_columns = "run,model,precision,";            // begins each runs.csv

// Returns whether a path is a regular file that begins with `start`.
bool begins_with(const std::filesystem::path&, const std::string& start);

// Throws Error::bad_input where one of `inputs`, which the scenes read, is a file that would be removed or
// replaced. runs: 0 for a run into `folder`, else a sweep's runs 1 .. runs below it. written: names of the files that
// such a run writes.
void need_inputs_kept(const std::filesystem::path& folder, size_t runs, const std::vector<std::string>& written,
                      const std::vector<std::string>& inputs);

struct EarlierRun {
    std::vector<std::filesystem::path> files; // in the order in which they may be removed
    bool owned = true; // dermis wrote all files that have names of a run's: summary.json shows it, or there are none
};
// Returns a run's files, except the ones in `kept`; none unless summary.json shows that dermis wrote them.
EarlierRun earlier_run(const std::filesystem::path& folder, const std::vector<std::string>& kept = {});
void remove_file(const std::filesystem::path&);
void remove_earlier_run(const std::filesystem::path& folder);

// Removes a sweep's runs from number `first` on, with their folders if they are then empty; runs.csv shows how many
// there were, and goes with the first.
void remove_earlier_sweep(const std::filesystem::path& folder, size_t first);

// A file that a run reads or writes, by its name and what it holds.
struct Contents {
    std::string name;
    uint64_t bytes = 0, hash = fnv1a_64; // FNV-1a of the bytes
    void add(const char* more, size_t count);
};
void to_json(Json&, const Contents&);
// Throws Error::io where the file cannot be read.
Contents contents_of(const std::filesystem::path&);

// Returns the first keys of the summary.json of a run: all that its results follow from, with the version and the
// commit of dermis. scene: its text, or a name that the program gives it; asked: device, precision and check as they
// were asked for; set: overrides of keys; inputs: maps, frames and receptors.
Json origin_of(const std::string& scene, const Json& asked, const std::vector<std::string>& set,
               const std::vector<Contents>& inputs);
// Adds the key behind them, a list of the other files of the run.
void add_files(Json& origin, std::vector<Contents>);
// Returns a summary.json that has its own hash as last key.
std::string sealed(const Json&);

// Returns whether a folder holds all files of a finished run of this scene, with every byte as it was written, and with
// a summary.json that begins with `origin`.
bool is_finished(const std::filesystem::path& folder, const Scene&, Json origin);

// The columns of runs.csv behind the run's number, and where a summary.json has their values.
inline constexpr std::pair<const char*, const char*> figure_columns[] = {{"model", "/plan/model"},
                                                                         {"precision", "/plan/precision"},
                                                                         {"seconds", "/seconds"},
                                                                         {"predicted_error", "/plan/predicted_error"},
                                                                         {"measured_error", "/plan/measured_error"},
                                                                         {"greatest_gain", "/greatest_gain"},
                                                                         {"kinks", "/kinks"},
                                                                         {"cells_compared", "/cross_check/cells"},
                                                                         {"cells_different", "/cross_check/different"}};

// The figures of a finished run for runs.csv; empty where its summary.json has null.
struct Figures {
    std::vector<std::string> values;                           // of figure_columns
    std::vector<std::pair<std::string, std::string>> outcomes; // by name, as outcomes() returns them
    bool wrong = false; // cells differ, or the measured error is above the prediction
};
// Throw Error::io if the folder's summary.json cannot be read or lacks a key.
Json summary_of(const std::filesystem::path& folder);
Figures figures_of(const std::filesystem::path& folder);

} // namespace dermis::output
