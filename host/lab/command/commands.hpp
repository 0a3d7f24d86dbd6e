// SPDX-License-Identifier: MIT
// The parts of the command that main.cpp calls.
#pragma once

#include "host/lab/output/earlier.hpp"
#include "host/lab/output/output.hpp"
#include "host/lab/scenes/curve_file.hpp"

namespace dermis::cli {

// Repeats --set before each key=value that follows another one, so that one --set takes several keys.
std::vector<std::string> with_each_set(const std::vector<std::string>& words);

struct Setting {
    std::string key;
    std::vector<std::string> values; // at least one
};

// Reads key=value,value .. of each override. A value is a number, a text, a list in brackets, or a range
// first:last:count, which is `count` numbers at equal distances with both ends. Throws Error::bad_input.
std::vector<Setting> settings_of(const std::vector<std::string>& overrides);

// Returns the overrides of each run: every combination of the values; the last key varies fastest.
std::vector<std::vector<std::string>> combinations(const std::vector<Setting>&);

// A run of a command: its scene, the overrides that make it, and the files that it reads.
struct PlannedRun {
    Scene scene;
    std::vector<std::string> overrides;
    std::vector<output::Contents> inputs;
};

// The runs of `dermis run`: one, or a sweep of several. They have maps in common.
struct Plan {
    std::string text; // of the scene's file
    output::Json asked;
    bool share_maps; // whether one reading of the maps serves all
    std::vector<PlannedRun> runs;

    // Returns the folder of a run into `out`: a sweep's runs have their own, OUT/1, OUT/2 ..
    output::Path folder(const output::Path& out, size_t run) const;
    // Returns the first keys of the run's summary.json.
    output::Json origin(size_t run) const;
};

// Reads the scene of every run. Refuses all of them if a run into `out` would overwrite a file that one of them reads.
// asked: how they are to be run. Throws Error::bad_input.
Plan plan_of(const std::string& path, const output::Path& out, const std::vector<Setting>&, output::Json asked);

struct RunsDone {
    size_t before; // runs that an earlier command had finished
    bool right;    // no cell differs from the other backend, and no measured error is above its bound
};
// Writes each run as soon as it is done, and then calls `done` with its number from 0; of a sweep also OUT/runs.csv.
// resume: finished runs stay.
RunsDone run_all(const output::Folder&, const Plan&, const Device&, const RunOptions&, bool resume,
                 const std::function<void(size_t run, const Result&)>& done);

// dermis bench: presses `pads` pads of the scene's skin on one thread of the CPU path and on all threads, and on a
// Vulkan device if Device::open(device) gives one, each for a quarter of a second. Prints the times of a press and
// their shares of the scene's step.
int bench_scene(const std::string& path, int pads, const std::string& device);
// dermis bench --errors: runs the scene by every candidate of its plan, and by every other method at its step, a half
// and a quarter of it. Writes errors.csv and errors.png into a folder. device: of the candidates on Vulkan, beside the
// CPU's; "cpu": none. Returns 1 if an error is above its bound.
int bench_errors(const std::string& scene, const output::Path& out, const std::string& device);

struct FitArguments {
    std::vector<std::string> data;
    scene::CurveOptions options;
    std::string out;
    int elements = 0; // 0: as few as describe the data
};
// dermis fit: prints the chain as a table of a scene, and what the data leave open, by fit.py; with `out` writes
// material.toml, fit.csv and fit.png there. Returns the command's status.
int fit_data(const FitArguments&);

// Returns a device's name with its driver.
std::string shown(const DeviceInfo&);
// dermis devices, and dermis check of one device or, with an empty name, of all. Return the command's status.
int list_devices(bool json);
int check_devices(const std::string& only, bool json);

} // namespace dermis::cli
