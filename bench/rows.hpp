// SPDX-License-Identifier: MIT
// One measurement, and a table of them as CSV.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace bench {

// Quartiles of some runs, in seconds.
struct Timing {
    double median = NAN, q1 = NAN, q3 = NAN;
    int runs = 0;
};
Timing timing_of(std::vector<double> seconds);

// Not known: NAN, or empty. errors: strain, SA1, SA2, FA1, FA2, curvature.
struct Measurement {
    std::string backend, workload, model, method, precision, stencil, status = "ok";
    std::string device = "cpu", device_uuid, driver, driver_version;
    bool exact = true; // the device's bits are those of plain loops
    int threads = 1;
    long long width = 0, height = 0, steps = 0, receptors = 0;
    double dt_over_tau = NAN, bytes_per_cell = NAN, flops_per_cell = NAN; // of a cell and step
    Timing wall;                                                          // of all steps
    double gpu_median = NAN;
    std::string limit; // what bounds it, and how much of that it reaches
    double limit_GBs = NAN, of_limit = NAN;
    std::array<double, 6> errors{NAN, NAN, NAN, NAN, NAN, NAN};

    // Counts bytes_per_cell against a bandwidth.
    void against(const std::string& name, double GBs);
};

std::string csv_of(const std::vector<Measurement>&, const std::string& commit);

// What of an earlier table does not hold any more, one line each: errors of exact devices to the bit, of_limit within
// 10 % and twice its quartile range, no row lost.
std::vector<std::string> lost(const std::string& earlier_csv, const std::string& csv);

} // namespace bench
