// SPDX-License-Identifier: MIT
// Runs of scenes: how a run would be computed, its result, and whether its numbers are plausible.
#pragma once

#include <dermis/device.hpp>
#include <dermis/scene.hpp>

#include <functional>

namespace dermis {

// One quantity over time: over all cells, and in each probe. Means are summed with twice the digits of the run's
// precision. Each list has one number for each output time. min and max are empty without Output::extremes.
struct Trace {
    Quantity quantity = Quantity::strain;
    std::vector<double> mean, min, max;
    std::vector<std::vector<double>> probes; // [probe][time]
};

// A jump of the load at `time` makes an impulse in FA2, or in FA1 where the viscosity is 0. mean, min, max and probes
// are the weights of the impulses over all cells and in each probe, 1/s of FA2 and 1 of FA1, with the gain 1 + l*C at
// that time and after fa2_gains. Only Method::exact lists impulses, and only of responses that are asked for.
struct Impulse {
    double time = 0; // s
    Quantity quantity = Quantity::fa2;
    double mean = 0, min = 0, max = 0; // min and max are NaN without Output::extremes
    std::vector<double> probes;
};

struct Field {
    double at = 0; // s, as FieldRequest::at
    Quantity quantity = Quantity::strain;
    std::vector<double> values; // width*height
};

// A spike of an afferent (a nerve fibre of the skin), numbered as in Scene::afferents.
struct FiredSpike {
    double time = 0; // s
    int afferent = 0;
};

struct Result {
    std::vector<double> time;      // s
    std::vector<Trace> traces;     // in the order of Output::traces
    std::vector<double> responses; // [time][site of the scene], row by row; empty without sites
    std::vector<Impulse> impulses; // empty with Model::sites, which computes the cells of sites alone
    std::vector<Field> fields;
    DeviceInfo device; // the CPU path for all models except march
    Model model = Model::march;
    Precision precision = Precision::f32;
    long long steps = 0;             // steps of the whole skin
    long long left_out = 0;          // steps that were skipped, because the skin was steady and no output could change
    long long dispatches = 0;        // GPU kernels dispatched
    double seconds = 0;              // time of stepping, without set-up; with RunOptions::check also of the comparison
    double tau_min = 0, tau_max = 0; // s: range of viscosity/modulus of the materials; infinite if a modulus is 0
    double predicted_error = std::nan(""); // Candidate::error of this run; NaN if no error was needed to choose it
    // Where Scene::tolerance is given: the greatest error found, relative as predicted_error is, by computing up to 32
    // cells and up to 32 sites once more in long double, and the mean and extremes of each trace once more from the
    // run's own cells. If it is above predicted_error, a driver, a compiler or dermis is at fault. 0: all numbers that
    // were compared are exact. NaN: nothing was measured, for want of a tolerance or of a cell that the load presses.
    double measured_error = std::nan("");
    long long measured_cells = 0; // the number of these cells and sites that the load presses
    // Names of what was asked for and not computed once more in cells: under an envelope, FA2 as a mean over a step and
    // responses that follow the stress; everything, with more_loads; impulses. Spikes never are.
    std::string unmeasured;
    double cells_per_ridge = HUGE_VAL; // infinite as Report::cells_per_ridge is; below 8 the curvature is coarse
    double fine_load = std::nan("");   // as Report::fine_load
    // The next five describe the whole skin; with Model::sites they are not known: NaN or -1. C5 and C4 are the
    // curvature by the five-point and by the fourth-order stencil.
    double stencil_estimate = std::nan("");   // 1/m: greatest |C5 - C4| at the end, the error of C5 on a smooth skin
    double greatest_curvature = std::nan(""); // 1/m: greatest |C|, at rest, at the end and at the greatest strain
    double greatest_gain = std::nan("");      // greatest |l*C|, at the same times; above 1 responses change sign
    long long kinks = -1;                     // cells where |C5 - C4| > |C5|/2: the curvature does not converge there
    long long pressed_cells = -1;             // cells that the load presses, of a sequence in any of its frames
    // Counted with RunOptions::check. Any NaN counts as equal to any other, whatever its sign and payload.
    long long cells_compared = 0, cells_different = 0;
    // Of Scene::afferents, until Time::duration; by time, then by afferent.
    std::vector<FiredSpike> spikes;

    DERMIS_API const Trace& trace(Quantity) const; // throws Error::bad_input if it was not asked for
};

// The numbers of a trace, by the name of their column in traces.csv: strain_mean, strain_min, strain_max,
// strain_probe0. values: of the result, one for each output time.
struct TraceColumn {
    std::string name;
    const std::vector<double>* values; // not null, valid while the result is unchanged
};
DERMIS_API std::vector<TraceColumn> trace_columns(const Result&);

// One of the three numbers that sum up a column: NAME_final, the value at the last output time; NAME_peak, the value of
// greatest magnitude, with its sign; NAME_peak_time, the first time that has this value, s.
struct TraceOutcome {
    std::string name;
    double value = 0;
};
// Returns the outcomes of each column, in the order of trace_columns().
DERMIS_API std::vector<TraceOutcome> outcomes(const Result&);

// scene: the one that was run. A figure that the result does not hold, such as strain without its trace, is NaN.
DERMIS_API Report report(const Scene&, const Result&);

struct RunOptions {
    std::optional<Precision> precision; // overrides the scene's
    // Marches in f32 on the other backend too and compares the bits of every cell of every output: a Vulkan device with
    // the CPU path, the CPU path with the best Vulkan device.
    bool check = false;
    // For runs with several materials: whether the members stencil_estimate to pressed_cells of each Result describe
    // the skin at the end of its own run, at the cost of a pass over all cells. Otherwise results that share their maps
    // have the first material's figures.
    bool describe_each = false;
    // Called some times a second on the thread that called, while the run is prepared and planned too, with the
    // fraction done, 0..1. What it throws ends the run. It may press skins and run scenes on any device, this one too.
    std::function<void(double)> progress;
};

// A model, precision and device that could serve a scene, and what that would cost.
struct Candidate {
    Model model = Model::march;
    Precision precision = Precision::f32;
    std::string device;
    long long steps = 0, dispatches = 0;
    double bytes = 0;            // greatest memory in use
    double seconds = 0;          // an estimate from a table of rates
    double error = std::nan(""); // upper bound of the error that Scene::tolerance limits; NaN: not needed to choose
    std::string refused;         // the reason why it is not chosen; empty if it is
};

struct Explanation {
    std::vector<Candidate> candidates; // in the order in which they are tried
    size_t chosen = 0;                 // index into candidates
    double stencil_estimate = 0;       // 1/m: greatest |C5 - C4| at rest; no part of the errors here
    double greatest_curvature = 0;     // 1/m: greatest |C| at rest, the scale of the estimate
    // s: one for each map, where materials differ between cells and the strain is still a sum of a few maps, each times
    // a function of time; infinite where the modulus is 0. Empty otherwise.
    std::vector<double> retardation_times;
    // What frames lose, where the load is a sequence: an estimate, no part of the errors here. The cell with the
    // greatest pressure is stepped along lines and along parabolas between the frames (see Hold); these are the
    // greatest differences of strain and of rate (FA1) at the frames, divided by the greatest value. NaN otherwise.
    double strain_between_frames = std::nan(""), fa1_between_frames = std::nan("");
    double fine_load = std::nan(""); // as Report::fine_load
    double tolerance = 0;            // relative, as Scene::tolerance
    bool binding = false;            // the tolerance is the scene's, not the default
};

// Says how run() would compute the scene, like a database's EXPLAIN. Nothing is run.
DERMIS_API Explanation plan(const Scene&, const Device& = Device::cpu(), const RunOptions& = {});
[[deprecated("use dermis::plan")]] inline Explanation explain(const Scene& scene, const Device& device = Device::cpu(),
                                                              const RunOptions& options = {}) {
    return plan(scene, device, options);
}

// Runs the scene, on the CPU path unless a device is given. Opening a GPU takes a loader, a driver and a self-test:
// open one once, by Device::open("auto"), and pass it to each run. Throws Error::bad_input for a scene that is not
// valid, a tolerance that cannot be promised, and numbers beyond the range of the precision; Error::no_device if
// RunOptions::check finds no other backend; Error::device; Error::no_memory.
DERMIS_API Result run(const Scene&, const Device& = Device::cpu(), const RunOptions& = {});
// Runs the scene with each of these materials in place of its own. All models except march read the maps once (see
// RunOptions::describe_each).
DERMIS_API std::vector<Result> run(const Scene&, const std::vector<Material>&, const Device& = Device::cpu(),
                                   const RunOptions& = {});

} // namespace dermis
