// SPDX-License-Identifier: MIT
// Reads measured curves from CSV files.
#pragma once

#include "dermis/fit.hpp"
#include "host/lab/fit/problem.hpp"

#include <optional>

namespace dermis::cli {

struct Curve {
    fit::Test test = fit::Test::creep;
    std::vector<double> times, values; // s; 1/Pa or Pa
};

struct CurveOptions {
    std::optional<fit::Test> test; // default: told by the name of the second column
    std::optional<double> stress;  // Pa: the second column is the strain under this stress
    Residual residual = Residual::relative;
};

// The file: a line of names, time and one of modulus (relaxation), compliance or strain (creep); then two numbers in
// each line. Empty lines and lines that begin with # are skipped. Throws Error::bad_input, naming file, line and value.
Curve read_curve(const std::string& path, const CurveOptions&);

} // namespace dermis::cli
