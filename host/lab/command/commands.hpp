// SPDX-License-Identifier: MIT
// The parts of the command that main.cpp calls.
#pragma once

#include "dermis/dermis.hpp"
#include "host/lab/march/self_test.hpp"
#include "host/lab/scenes/curve_file.hpp"

namespace dermis::cli {

// dermis bench: presses `pads` pads of the scene's skin on one thread of the CPU path and on all threads, and on a
// Vulkan device if Device::open(device) gives one, each for a quarter of a second. Prints the times of a press and
// their shares of the scene's step.
int bench_scene(const std::string& path, int pads, const std::string& device);
// The time of a clock that runs evenly, s.
double seconds_now();

// dermis bench --errors: runs the scene by every candidate of its plan, and by every other method at its step, a half
// and a quarter of it. Writes errors.csv and errors.png into a folder. device: of the candidates on Vulkan, beside the
// CPU's; "cpu": none. Returns whether no error is above its bound.
bool bench_errors(const std::string& scene, const std::string& out, const std::string& device);

struct FitArguments {
    std::vector<std::string> data;
    scene::CurveOptions options;
    std::string out;
    int elements = 0; // 0: as few as describe the data
};
// dermis fit: prints the chain as a table of a scene, and what the data leave open, by fit.py; with `out` writes
// material.toml, fit.csv and fit.png there. Returns the command's status.
int fit_data(const FitArguments&);

// dermis check: compares receptors of a surface, and below it, under a sliding texture with those of one thread of the
// CPU path.
SelfTest::Kernel touch(const Device&);

// Answers as JSON, which programs read: elements of a list, in brackets, each on a line; a plan, whose overrides are
// the keys that are set, one by one; a device; and the bits of its kernels, beside the CPU path's.
std::string json_list(const std::vector<std::string>& items);
std::string json_of(const Scene&, const std::vector<std::string>& overrides, const Explanation&);
std::string json_of(const DeviceInfo&);
std::string json_of(const DeviceInfo&, const std::vector<SelfTest::Kernel>&);

} // namespace dermis::cli
