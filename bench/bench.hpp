// SPDX-License-Identifier: MIT
#pragma once

#include "bench/limits.hpp"
#include "bench/peers.hpp"
#include "bench/rows.hpp"
#include "dermis/dermis.hpp"
#include "host/core/embedding/backend.hpp"
#include "host/core/press/device.hpp"
#include "host/core/simd/isa.hpp"
#include "tests/maps.hpp"

#include <functional>
#include <memory>
#include <optional>

#include <fmt/format.h>

namespace bench {

// A row of the table, and the work that is timed for it. Everything that is compared is timed in the same rounds.
struct Contender {
    Measurement row;
    std::function<double()> work; // seconds of one run; empty: a peer that is not installed
    std::string ratio_to = {};    // if named, the contender with which the row's ratio is taken,
    size_t reference = 0;         // and its place in the rounds
};

struct Bench {
    bool quick = false;
    int runs = 5, cores = 1;
    std::optional<dermis::Device> vulkan; // empty: only rows of the CPU
    std::unique_ptr<Peers> peers;
    std::vector<Measurement> rows;

    std::vector<dermis::Device> cpus() const;    // one thread, and all of them
    std::vector<dermis::Device> devices() const; // every Vulkan device that can be used; none without `vulkan`
    Measurement cpu(const std::string& workload, long long n, int threads) const;
    // A row of a Vulkan device, or of the CPU path with so many threads.
    Measurement on(const dermis::Device&, const std::string& workload, long long n) const;
    // The rows and the work of the peers in Python that do this work, `count` times in a run. like: the columns that
    // all of their rows share. errors: the quantities whose errors the peers print.
    std::vector<Contender> of_peers(const std::string& work, const Measurement& like, int count,
                                    const std::vector<size_t>& errors = {}) const;
    void add(const Measurement&); // prints it too
    // Runs each work once to warm up, then all of them in turn; sets times and ratios.
    void time(std::vector<Contender>&, int times) const;
    void measure(std::vector<Contender>, int times); // times all, and adds their rows
    void measure(const Measurement& row, std::function<double()> work, int times) { measure({{row, work}}, times); }
};

double seconds_of(const std::function<void()>&);
dermis::Scene with_maps(dermis::Scene); // the same scene with surface and load as ready maps
Measurement row_of(Measurement, const std::string& model, const std::string& precision, long long steps);

void streamed_frames(Bench&); // one press of one skin, beside peers and the memory's limits
void streamed_frames_on_device(Bench&, int n);
void chains(Bench&);              // the same by elements in series
void by_cells(Bench&);            // skins of 4 x 4 to 4096 x 4096 cells, by threads and on every device
void options(Bench&);             // what each option of a skin saves
void kinds(Bench&);               // what each kind of skin costs: materials, widths, stencils, elements
void pads(Bench&);                // batches of pads, sites beside fields, presses at 1 kHz
void streamed_population(Bench&); // receptors of a hand, frame by frame
void touch(Bench&);               // contacts of a whole batch, and shear
void depth(Bench&);               // receptors at depths: what they cost and how exact they are
void construction(Bench&);        // making a skin
void constant_map(Bench&);        // means of a map whose strength alone changes
void study(Bench&);               // the published study's nine scenes
void population(Bench&);          // receptors of a hand, in a run
void marches(Bench&);             // traces by materials and precision
void materials(Bench&);           // a hundred materials on one map
void accuracy(Bench&);            // error against time
void spikes(Bench&);              // afferents
void stiff(Bench&);               // error against step and time on a chain of elements
void processes(Bench&);           // the command from its start to its end
void device_growth(Bench&);       // a press, a march and receptors on the device, by cells
// These fork processes, so they run before any device is opened.
void growth(Bench&); // time and memory against the number of cells
void memory(Bench&); // memory by models

} // namespace bench
