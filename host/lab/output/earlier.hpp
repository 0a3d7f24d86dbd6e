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

// Returns whether summary.json or runs.csv shows that dermis wrote into a folder.
bool is_ours(const std::filesystem::path& folder);

// Throws Error::bad_input where one of `inputs`, which a command reads, is one of the files that would be removed or
// replaced.
void need_inputs_kept(const std::vector<std::string>& inputs, const std::vector<std::filesystem::path>& files);

// The same for the files of runs and of their pictures. runs: 0 for a run into `folder`, else a sweep's runs 1 .. runs
// below it. written: names of the files that such a run writes.
void need_inputs_kept(const std::filesystem::path& folder, size_t runs, const std::vector<std::string>& written,
                      const std::vector<std::string>& inputs);

struct EarlierRun {
    std::vector<std::filesystem::path> files; // in the order in which they may be removed
    bool owned =
        true; // dermis wrote all files that have such names: summary.json or runs.csv shows it, or there are none
};
// Returns the files of a run, or the pictures of a sweep, except the ones in `kept`; none unless summary.json or
// runs.csv shows that dermis wrote them.
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
// Returns a summary.json that has its own hash as last key.
std::string sealed(const Json&);

// Returns whether a folder holds a finished run of this origin, with every byte of its files as it was written.
bool is_finished(const std::filesystem::path& folder, const Json& origin);

// The columns of runs.csv behind the run's number: keys of a summary.json or of its plan, and its cross-check.
inline constexpr const char* figure_columns[] = {"model",           "precision",      "seconds",
                                                 "predicted_error", "measured_error", "greatest_gain",
                                                 "kinks",           "cells_compared", "cells_different"};

// The figures of a finished run for runs.csv.
struct Figures {
    std::vector<std::string> values; // of figure_columns; empty where the summary has null
    Json outcomes;                   // an object, as the summary has it
    bool wrong = false;              // cells differ, or the measured error is above the prediction
};
// Returns a value as a table has it: a text without quotes, nothing for null.
std::string in_table(const Json&);
// Throw Error::io if the folder's summary.json cannot be read or lacks a key.
Json summary_of(const std::filesystem::path& folder);
Figures figures_of(const std::filesystem::path& folder);

} // namespace dermis::output
