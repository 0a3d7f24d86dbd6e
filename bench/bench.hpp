// SPDX-License-Identifier: MIT
#pragma once

#include "bench/limits.hpp"
#include "bench/peers.hpp"
#include "bench/rows.hpp"
#include "dermis/dermis.hpp"
#include "host/core/press/device.hpp"
#include "host/core/simd/isa.hpp"
#include "tests/maps.hpp"

#include <functional>
#include <memory>
#include <optional>

namespace bench {

struct Bench {
    bool quick = false;
    int runs = 5, cores = 1;
    std::optional<dermis::Device> vulkan; // empty: only rows of the CPU
    std::unique_ptr<Peers> peers;
    std::vector<Measurement> rows;

    Measurement cpu(const std::string& workload, long long n, int threads) const;
    Measurement on_vulkan(const std::string& workload, long long n) const { return on(*vulkan, workload, n); }
    // A row of a Vulkan device, or of the CPU path with so many threads.
    Measurement on(const dermis::Device&, const std::string& workload, long long n) const;
    Measurement of_peer(const Peers::Peer&, const std::string& workload, long long n) const;
    void add(const Measurement&); // prints it too
    // Runs each work once to warm up, then all works in turn `runs` times. Returns the timing of each.
    std::vector<Timing> paired(const std::vector<std::function<double()>>&, int runs) const;
};

double seconds_of(const std::function<void()>&);
dermis::Scene with_maps(dermis::Scene); // the same scene with surface and load as ready maps

void limits(Bench&);
void streamed_frames(Bench&); // one press of one skin, beside peers and the memory's limits
void streamed_frames_on_device(Bench&, int n);
void by_cells(Bench&);            // skins of 4 x 4 to 4096 x 4096 cells, by threads and on every device
void options(Bench&);             // what each option of a skin saves
void kinds(Bench&);               // what each kind of skin costs: materials, widths, stencils, elements
void constant_map(Bench&);        // means of a map whose strength alone changes
void study(Bench&);               // the published study's nine scenes
void population(Bench&);          // receptors of a hand, in a run
void streamed_population(Bench&); // the same frame by frame
void marches(Bench&);             // traces by materials and precision
void chains(Bench&);              // frames by elements in series
void pads(Bench&);                // batches of pads, sites beside fields, presses at 1 kHz
void materials(Bench&);           // a hundred materials on one map
void accuracy(Bench&);            // error against time
void spikes(Bench&);              // afferents
void touch(Bench&);               // contacts of a whole batch, and shear
void depth(Bench&);               // receptors at depths: what they cost and how exact they are
void stiff(Bench&);               // error against step and time on a chain of elements
void construction(Bench&);        // making a skin
void processes(Bench&);           // the command from its start to its end
void device_growth(Bench&);       // a press, a march and receptors on the device, by cells
// The following fork processes, so they run before any device is opened.
// Seconds from the start of a process to its first frame; empty without a device.
std::vector<double> first_frames(const std::string& device, int runs);
void growth(Bench&); // time and memory against the number of cells
void memory(Bench&); // memory by models

} // namespace bench
