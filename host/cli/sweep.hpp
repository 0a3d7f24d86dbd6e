// SPDX-License-Identifier: MIT
// The runs of `dermis run`: one, or a sweep of several.
#pragma once

#include "host/cli/settings.hpp"
#include "host/output/folder.hpp"
#include "host/output/origin.hpp"

namespace dermis::cli {

// A run of a command: its scene, the overrides that make it, and what tells it from others.
struct PlannedRun {
    Scene scene;
    std::vector<std::string> overrides;
    std::string origin;
};

// Reads the scene of every run, and refuses all where a run into `out` would cost one of them a file that it reads.
// asked: how they are to be run. Throws Error::bad_input.
std::vector<PlannedRun> planned_runs(const std::string& path, const output::Path& out, const std::vector<Setting>&,
                                     output::Origin asked);

// Writes OUT/1, OUT/2 .. and OUT/runs.csv, each run as soon as it is done. resume: those that are finished stay.
// Returns whether no cell differs in any run.
bool sweep(const output::Folder&, const std::vector<Setting>&, const std::vector<PlannedRun>&, const Device&,
           const RunOptions&, bool resume);

} // namespace dermis::cli
