// SPDX-License-Identifier: MIT
// Removes what earlier runs have written, so that a folder holds the files of one run or one sweep. Only files that
// dermis itself names are removed, and only where a file shows that dermis was there. Throws Error::io.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace dermis::output {

inline const std::string made_by_dermis = "{\n  \"program\": \"dermis\","; // begins each summary.json
inline const std::string runs_columns = "run,model,precision,";            // begins each runs.csv

// Opens a file with a stream that throws if memory runs out: others hide that, and the file seems to end or be missing.
std::ifstream opened(const std::filesystem::path&);

// Returns whether a path is a regular file that begins with `start`.
bool begins_with(const std::filesystem::path&, const std::string& start);

// Throws Error::bad_input where one of `paths`, the files that the scenes read, is a file that would be removed or
// replaced. runs: 0 for a run into `folder`, else a sweep's runs 1 .. runs below it. written: names of the files that
// such a run writes.
void need_inputs_kept(const std::filesystem::path& folder, size_t runs, const std::vector<std::string>& written,
                      const std::vector<std::string>& paths);

// Returns whether dermis wrote all files that have names of a run's files: summary.json shows it, or there are none.
bool is_owned(const std::filesystem::path& folder);

// Returns a run's files, except the ones in `kept`, in the order in which they may be removed; its summary.json shows
// that dermis wrote them.
std::vector<std::filesystem::path> earlier_run(const std::filesystem::path& folder,
                                               const std::vector<std::string>& kept);
void remove_file(const std::filesystem::path&);
void remove_earlier_run(const std::filesystem::path& folder);

// Removes a sweep's runs from number `first` on, with their folders if they are then empty; runs.csv shows how many
// there were, and goes with the first.
void remove_earlier_sweep(const std::filesystem::path& folder, size_t first);

} // namespace dermis::output
