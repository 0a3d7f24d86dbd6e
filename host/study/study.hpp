// SPDX-License-Identifier: MIT
// The published study, whole: its scenes and sweeps, by its own method and exactly.
#pragma once

#include "host/output/output.hpp"

#include <map>

namespace dermis::study {

using output::Path;

// Runs everything, writes it below `out` and prints what was done; returns the exit status.
int reproduce(const Path& out);

// The study's scene: 150 x 150 cells, E = 1.54, eta = 1, 1000 outputs 0.01 s apart, its five probes.
Scene study_scene(Surface::Kind, Load::Kind, Method);
Result in_double(const Scene&);

// What the study's runs gave, in double, by folder ("exact/wave_circular", "sweep_modulus/1.25/published").
struct StudyRun {
    Scene scene;
    Result result;
};
using StudyRuns = std::map<std::string, StudyRun>;

// Each claim of the study's sections 4 and 5 beside what was computed, as Markdown.
std::string claims(const StudyRuns&);

// Error against time: euler and exact, f32 and f64, CPU and Vulkan (null: none), over a ladder of steps, as CSV.
std::string error_against_time(const Device* vulkan);

// Greatest strain error of every method for dt/tau = 1e-6 .. 1e6, and how methods fail, step by step; as CSV.
std::string stability_map();
std::string failing_courses();

} // namespace dermis::study
