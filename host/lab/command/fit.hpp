// SPDX-License-Identifier: MIT
// dermis fit: a chain of elements from a measured curve.
#pragma once

#include <optional>
#include <string>

namespace dermis::cli {

struct FitArguments {
    std::string data, kind, residual = "relative", out;
    int elements = 0;
    std::optional<double> stress;
};

// Prints the chain as a table of a scene, what the data leave open, and with `out` writes fit.csv and fit.png there.
int fit_data(const FitArguments&);

} // namespace dermis::cli
