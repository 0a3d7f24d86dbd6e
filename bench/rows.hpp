// SPDX-License-Identifier: MIT
// Measurements, and a table of them as CSV.
#pragma once

#include "bench/machine.hpp"

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace bench {

// The least and the quartiles of repeated runs, in seconds. busy: the least time for which the processor or the device
// worked, whoever else was served in between.
struct Timing {
    double least = NAN, median = NAN, q1 = NAN, q3 = NAN, busy = NAN;
    int runs = 0;
};
Timing timing_of(std::vector<double> seconds);

constexpr const char* not_installed = "not installed"; // the status of a peer's row without times
constexpr const char* planned_bytes = "planned bytes"; // a limit of memory, in GB, in place of a bandwidth

// A row of the table; what is not known is NAN or empty. errors: strain, SA1, SA2, FA1, FA2, curvature.
struct Measurement {
    std::string backend, workload, model, method, precision, stencil, status = "ok";
    std::string device = "cpu", device_uuid, driver, driver_version;
    bool exact = true; // the device's bits are equal to the bits of plain loops
    int threads = 1;
    long long width = 0, height = 0, steps = 0, receptors = 0;
    double dt_over_tau = NAN, bytes_per_cell = NAN, flops_per_cell = NAN; // per cell and step
    Timing wall;                                                          // seconds of all steps
    double gpu_median = NAN;
    std::string limit; // the bandwidth that bounds the speed; of_limit: the share of it that is reached
    double limit_GBs = NAN, of_limit = NAN;
    std::string ratio_to; // the memory traffic that was timed in the same rounds
    double ratio = NAN;   // least busy time per byte of the rounds, divided by ratio_to's
    std::array<double, 6> errors{NAN, NAN, NAN, NAN, NAN, NAN};

    // Sets the limit to a bandwidth, and of_limit from bytes_per_cell.
    void against(const std::string& name, double GBs);
    // Sets the ratio to `reference`, which moved `bytes` bytes in each of the same rounds.
    void relative_to(const std::string& name, const Timing& reference, double bytes);
    double bytes() const { return bytes_per_cell * double(width * height * steps); } // moved by all steps
};

// The columns that all rows of a run share.
struct Origin {
    std::string commit, size; // size: "full" or "quick", which have other grids
    Machine machine;
};

constexpr int schema = 3; // of the table; raised whenever a column or the meaning of one changes

std::string csv_of(const std::vector<Measurement>&, const Origin&);

} // namespace bench
