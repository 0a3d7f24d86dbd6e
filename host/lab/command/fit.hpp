// SPDX-License-Identifier: MIT
// dermis fit: a chain of elements from measured curves.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dermis::cli {

struct FitArguments {
    std::vector<std::string> data;
    std::string kind, residual, out; // residual: empty: absolute of histories, else relative
    int elements = 0;                // 0: as few as describe the data
    std::optional<double> stress;
};

// Prints the chain as a table of a scene, what the data leave open, and with `out` writes fit.csv and fit.png there.
int fit_data(const FitArguments&);

} // namespace dermis::cli
