// SPDX-License-Identifier: MIT
#pragma once

#include "bench/limits.hpp"
#include "bench/rows.hpp"
#include "dermis/dermis.hpp"
#include "host/core/press/device.hpp"
#include "host/core/simd/isa.hpp"

#include <functional>
#include <optional>

namespace bench {

struct Bench {
    bool quick = false;
    int runs = 5, cores = 1;
    std::optional<dermis::Device> vulkan; // empty: only rows of the CPU
    std::vector<Measurement> rows;

    Measurement cpu(const std::string& workload, long long n, int threads) const;
    Measurement on_vulkan(const std::string& workload, long long n) const;
    void add(const Measurement&); // prints it too
    // Runs each work once to warm up, then all works in turn `runs` times. Returns the timing of each.
    std::vector<Timing> paired(const std::vector<std::function<double()>>&, int runs) const;
};

double seconds_of(const std::function<void()>&);
dermis::Scene with_maps(dermis::Scene); // the same scene with surface and load as ready maps

void limits(Bench&);
void streamed_frames(Bench&); // W1, W1s
void streamed_frames_on_device(Bench&, int n);
void constant_map(Bench&);        // W2
void study(Bench&);               // W3
void population(Bench&);          // W4
void streamed_population(Bench&); // W4 frame by frame
void marches(Bench&);             // traces by materials and precision
void chains(Bench&);              // frames by elements in series
void pads(Bench&);                // batches of pads, sites beside fields, presses at 1 kHz
void materials(Bench&);           // a hundred materials on one map
void accuracy(Bench&);            // error against time
void stiff(Bench&);               // error against step and time on a chain of elements
void construction(Bench&);        // making a skin
void processes(Bench&);           // the command from its start to its end
void device_growth(Bench&);       // W1, march and sites on the device, by cells
// The following fork processes, so they run before any device is opened.
// Seconds from the start of a process to its first frame; empty without a device.
std::vector<double> first_frames(const std::string& device, int runs);
void growth(Bench&); // time and memory against the number of cells
void memory(Bench&); // memory by models

} // namespace bench
