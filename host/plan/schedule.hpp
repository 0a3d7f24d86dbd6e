// SPDX-License-Identifier: MIT
// The load of a run and its outputs in time.
#pragma once

#include "host/plan/skin.hpp"
#include "host/scene/instant.hpp"
#include "host/scene/scene.hpp"

#include <memory>

namespace dermis::plan {

struct Schedule {
    Method method = Method::exact;
    bool allow_unstable = false;
    Load load; // validated
    Time time;
    Output output;
    Map pressure;                             // Pa, width*height; of a sequence its first frame
    bool framed = false;                      // the pressure runs from frame to frame, those handed to Stepper::frame
    std::shared_ptr<scene::NpyFile> sequence; // null without
    std::vector<double> frame_peaks;          // of a sequence: greatest |pressure| of each frame
    PressedBox pressed;
    long long outputs = 0;                   // rows of the traces
    std::vector<scene::Instant> field_times; // sorted, each once; equal to an output's but for rounding: that output's
    std::vector<Cell> points;                // cells whose values are wanted: Output::probes, then the skin's sites
    Wanted wanted{};
    bool keeps_maps = false; // maps of responses are read, not their totals alone
    bool derives = false;    // curvature or deformation is read
};

// check: every map of every output is compared with another backend's.
Schedule make_schedule(const scene::ValidatedScene&, const PreparedSkin&, bool check = false);

// A scene made ready to run.
struct PreparedRun {
    PreparedSkin skin;
    Schedule schedule;
};
PreparedRun prepare_run(const scene::ValidatedScene&, bool check = false);
// Validates the scene, once. Throws Error::bad_input.
PreparedRun prepare_run(const Scene&, bool check = false);

Variant variant_of(const PreparedSkin&, const Schedule&, Precision);

// The reason why a model cannot serve; empty where it can.
std::string why_not(const PreparedSkin&, const Schedule&, Model);
// .. why the run is no product of a map and scalars of time.
std::string why_not_separable(const PreparedSkin&, const Schedule&);

} // namespace dermis::plan
