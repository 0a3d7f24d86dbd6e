// SPDX-License-Identifier: MIT
// dermis fit: a chain of elements from measured curves.
#pragma once

#include "host/lab/scenes/curve_file.hpp"

namespace dermis::cli {

struct FitArguments {
    std::vector<std::string> data;
    scene::CurveOptions options;
    std::string out;
    int elements = 0; // 0: as few as describe the data
};

// Prints the chain as a table of a scene, and what the data leave open, by fit.py; with `out` writes material.toml,
// fit.csv and fit.png there. Returns the command's status.
int fit_data(const FitArguments&);

} // namespace dermis::cli
