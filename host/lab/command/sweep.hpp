// SPDX-License-Identifier: MIT
// The runs of `dermis run`: one, or a sweep of several.
#pragma once

#include "host/lab/command/settings.hpp"
#include "host/lab/output/folder.hpp"
#include "host/lab/output/origin.hpp"

namespace dermis::cli {

// A run of a command: its scene, the overrides that make it, and the files that it reads.
struct PlannedRun {
    Scene scene;
    std::vector<std::string> overrides;
    std::vector<output::Contents> inputs;
};

// The runs of a command. They share what they have in common: maps, and the text of the scene.
struct Plan {
    output::Origin common; // without overrides and inputs
    std::vector<PlannedRun> runs;

    // Returns the first lines of the run's summary.json.
    std::string origin(size_t run) const;
};

// Reads the scene of every run. Refuses all of them if a run into `out` would overwrite a file that one of them reads.
// asked: how they are to be run. Throws Error::bad_input.
Plan plan_of(const std::string& path, const output::Path& out, const std::vector<Setting>&, output::Origin asked);

struct SweepOptions {
    bool resume = false; // finished runs stay
    bool quiet = false;  // prints nothing
};
// Writes OUT/1, OUT/2 .. and OUT/runs.csv, each run as soon as it is done. Returns whether every run is right: no cell
// differs from the other backend, and no measured error is above its bound.
bool sweep(const output::Folder&, const std::vector<Setting>&, const Plan&, const Device&, const RunOptions&,
           const SweepOptions&);

} // namespace dermis::cli
