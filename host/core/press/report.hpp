// SPDX-License-Identifier: MIT
// Judges whether the numbers of a skin are plausible: the figures, and the ranges that reports and warnings share.
#pragma once

#include "host/core/description/description.hpp"

namespace dermis {

// Returns the report of a description; strain, indentation, changed signs and load are not known yet. tau: the
// retardation times of all cells. gain: the greatest |l*C| that is known.
Report report_of(const SkinDescription&, scene::TauRange tau, double cells_per_ridge, double gain);

// Report::fine_load of pressures, width*height numbers of any unit.
double fine_load_of(const SkinDescription&, const std::vector<double>& pressure);

// Report::vibration for frames that are dt > 0 seconds apart.
inline double vibration_between(double dt) { return 0.17801314285637831 / dt; } // sinc(f*dt)^2 = 0.9

} // namespace dermis
