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

// The model on a small grid with every length in it, from its formulas alone: at time t after a unit step of the load
// on skin at rest. Cells beyond an edge come from `outside`.
enum class Outside { mirror, periodic };
struct Skin {
    int width, height;
    double spacing, thickness, curvature_length, modulus, viscosity;
    Outside outside;
    bool fourth_order;
};
struct Fields {
    std::vector<double> strain, sa1, sa2, fa1, fa2, curvature, deformation;
};
Fields model(const Skin&, const std::vector<double>& surface, const std::vector<double>& pressure, double t);

} // namespace oracle
