// SPDX-License-Identifier: MIT
// A straight reading of the published study, sharing no code with the library.
#pragma once

#include <functional>
#include <vector>

namespace oracle {

struct Frame { // after step n, row-major
    std::vector<double> strain, curvature, sa1, sa2, fa1, fa2;
};

// Calls `each` with n = 0 .. steps-1 in order.
void study(const std::vector<double>& surface, const std::vector<double>& pressure, int width, int height,
           double modulus, double viscosity, double dt, int steps,
           const std::function<void(int n, const Frame&)>& each);

} // namespace oracle
