// SPDX-License-Identifier: MIT
// The gate: compares the table of a run with an earlier one of the same machine.
#pragma once

#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace bench {

// Thrown for a table that this program did not write, or that has nothing in common with the run. The message says why.
struct Incomparable : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Rows of a table by column name. Throws Incomparable, which names the table by `name`, unless the table has this
// program's schema, at least one row, and a cell for each column.
using Columns = std::map<std::string, std::string>;
std::vector<Columns> read_table(const std::string& csv, const std::string& name);

struct GateOptions {
    bool speed = false;         // speeds are compared too
    bool devices = true;        // rows of Vulkan devices were asked for
    std::set<std::string> cpus; // supported_backends() of machine.hpp
};

struct Verdict {
    size_t rows = 0, speeds = 0;     // compared
    std::vector<std::string> failed; // what is lost or different
    std::vector<std::string> said;   // rows of the earlier table that this machine or this run cannot have
};

// A speed counts as lost if its ratio rises above this many times the earlier one. On a machine that also served five
// others, ratios of the unchanged program were within 1.4 of each other.
constexpr double speed_slack = 1.5;

// Joins rows of the same machine (CPU, cores, device, driver) and the same size. Errors of exact devices must be equal
// to the last bit, exactness and status must be equal, and no row may be lost. With `speed`, no ratio may rise beyond
// the slack where the compiler is the same. Throws Incomparable where no row, or none of the speeds asked for, is in
// common.
Verdict compare(const std::vector<Columns>& earlier, const std::vector<Columns>& now, const GateOptions&);

} // namespace bench
