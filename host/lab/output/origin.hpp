// SPDX-License-Identifier: MIT
// Tells runs apart by what they are made from, so that a finished run need not be done again.
#pragma once

#include "dermis/dermis.hpp"
#include "host/core/base/hash.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace dermis::output {

// A file that a run reads or writes, by its name and what it holds.
struct Contents {
    std::string name;
    uint64_t bytes = 0, hash = fnv1a_64; // FNV-1a of the bytes
    void add(const char* more, size_t count);
};
// Throws Error::io where the file cannot be read.
Contents contents_of(const std::filesystem::path&);

// A run's results follow from these, and from the version and the commit of dermis.
struct Origin {
    std::string scene;                  // its text, or a name that the program gives it
    std::vector<std::string> overrides; // of keys
    std::vector<Contents> inputs;       // maps, frames and receptors
    std::string device, precision;      // as they were asked for
    bool check = false;
};

// Returns the first lines of the summary.json of a run of this origin.
std::string text_of(const Origin&);
// Returns the line behind them, which lists the other files of the run.
std::string files_text(std::vector<Contents>);
// Returns a summary.json with its own hash as last line; `text` is all before that.
std::string sealed(std::string text);

// Returns whether a folder holds all files of a finished run of this scene, with every byte as it was written, and with
// a summary.json that begins with `origin`.
bool is_finished(const std::filesystem::path& folder, const Scene&, const std::string& origin);

// The figures of a finished run for tables, as they stand in its summary.json; empty where that has null.
struct Figures {
    std::string model, precision, seconds, predicted_error, measured_error, greatest_gain, kinks;
    long long compared = 0, different = 0;                     // cells
    std::vector<std::pair<std::string, std::string>> outcomes; // by name, as outcomes() returns them
    // Whether cells differ, or the measured error is above the prediction.
    bool wrong() const;
};
// Returns the summary.json of a finished run, without the end of its last line. Throws Error::io.
std::string summary_of(const std::filesystem::path& folder);
// Throws Error::io where the file does not have them.
Figures figures_of(const std::filesystem::path& folder);

} // namespace dermis::output
