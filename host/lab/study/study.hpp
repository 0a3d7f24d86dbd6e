// SPDX-License-Identifier: MIT
// This header reproduces the whole published study: its scenes and sweeps, by its own method and exactly.
#pragma once

#include "host/lab/output/output.hpp"

#include <map>

namespace dermis::study {

using output::Path;

// Runs everything, writes it below `out` and prints what is being done and where it lies. Returns the exit status: 1
// where a cell differs between Vulkan and the CPU, else 0. resume: scenes that an earlier study of this version, commit
// and device has finished there stay; only what the claims need of them is computed again.
int reproduce(const Path& out, bool resume);

// Makes the study's scene: 150 x 150 cells, E = 1.54, eta = 1, 1000 outputs 0.01 s apart, its five probes.
Scene study_scene(Surface::Kind, Load::Kind, Method);
Result in_double(const Scene&);

// A StudyRun is a scene and what it gave in double. StudyRuns finds it by its folder ("exact/wave_circular",
// "sweep_modulus/1.25/published").
struct StudyRun {
    Scene scene;
    Result result;
};
using StudyRuns = std::map<std::string, StudyRun>;

// Sets each claim of the study's sections 4 and 5 beside what was computed, as Markdown.
std::string claims(const StudyRuns&);

// Compares error with time: euler and exact, f32 and f64, CPU and Vulkan (null: none), over a ladder of steps; as CSV.
std::string error_against_time(const Device* vulkan);

// Lists the greatest strain error of every method for dt/tau = 1e-6 .. 1e6; as CSV.
std::string stability_map();

// Lists the strain step by step where methods fail; as CSV.
std::string failing_courses();

} // namespace dermis::study
