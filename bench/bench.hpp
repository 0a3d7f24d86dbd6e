// SPDX-License-Identifier: MIT
#pragma once

#include "bench/limits.hpp"
#include "bench/rows.hpp"
#include "host/device.hpp"
#include "host/simd/isa.hpp"

#include <functional>
#include <optional>

namespace bench {

struct Bench {
    bool quick = false;
    int runs = 5, cores = 1;
    std::optional<dermis::Device> vulkan;      // without: rows of the CPU alone
    double read_GBs[2] = {}, copy_GBs[2] = {}; // one thread, all cores
    std::vector<Measurement> rows;

    Measurement cpu(const std::string& workload, long long n, int threads) const;
    Measurement on_vulkan(const std::string& workload, long long n) const;
    void add(const Measurement&); // and prints it
    // Medians of `runs` runs of each, in turn, after one that warms up.
    std::vector<Timing> paired(const std::vector<std::function<double()>>&, int runs) const;
};

double seconds_of(const std::function<void()>&);
dermis::Scene with_maps(dermis::Scene); // its maps made beforehand

void limits(Bench&);
void streamed_frames(Bench&);     // W1, W1s
void constant_map(Bench&);        // W2
void study(Bench&);               // W3
void population(Bench&);          // W4
void streamed_population(Bench&); // W4 frame by frame
void materials(Bench&);           // a hundred on one map
void accuracy(Bench&);            // error against time
// Before any device is open, because its processes begin as copies of this one.
std::vector<double> first_frames(const std::string& device, int runs); // from a process's start; empty without a device
void growth(Bench&);                                                   // time and memory with cells

} // namespace bench
