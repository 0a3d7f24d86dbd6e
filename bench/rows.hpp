// SPDX-License-Identifier: MIT
// Measurements, and a table of them as CSV.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace bench {

// The quartiles of repeated runs, in seconds.
struct Timing {
    double median = NAN, q1 = NAN, q3 = NAN;
    int runs = 0;
};
Timing timing_of(std::vector<double> seconds);

// A row of the table; what is not known is NAN or empty. errors: strain, SA1, SA2, FA1, FA2, curvature.
struct Measurement {
    std::string backend, workload, model, method, precision, stencil, status = "ok";
    std::string device = "cpu", device_uuid, driver, driver_version;
    bool exact = true; // the device's bits are those of plain loops
    int threads = 1;
    long long width = 0, height = 0, steps = 0, receptors = 0;
    double dt_over_tau = NAN, bytes_per_cell = NAN, flops_per_cell = NAN; // per cell and step
    Timing wall;                                                          // seconds of all steps
    double gpu_median = NAN;
    std::string limit; // the bandwidth that bounds the speed; of_limit: the share of it that is reached
    double limit_GBs = NAN, of_limit = NAN;
    std::array<double, 6> errors{NAN, NAN, NAN, NAN, NAN, NAN};

    // Sets the limit to a bandwidth, and of_limit from bytes_per_cell.
    void against(const std::string& name, double GBs);
};

std::string csv_of(const std::vector<Measurement>&, const std::string& commit);

// The losses against an earlier table, one line each: a row is missing, an error of an exact device differs in any bit,
// or of_limit is lower by more than 10 % and twice its quartile range.
std::vector<std::string> lost(const std::string& earlier_csv, const std::string& csv);

} // namespace bench
