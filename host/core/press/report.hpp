// SPDX-License-Identifier: MIT
// Judges whether the numbers of a skin can mean skin: the figures, and the ranges that reports and warnings share.
#pragma once

#include "host/core/description/description.hpp"

namespace dermis {

// Returns what a description tells. tau: of all cells. gain: greatest |l*C| that is known.
Report report_of(const SkinDescription&, scene::TauRange tau, double cells_per_ridge, double gain);

} // namespace dermis
