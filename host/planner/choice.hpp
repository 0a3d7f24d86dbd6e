// SPDX-License-Identifier: MIT
// Which model and precision serve a scene, cheapest first, and which is taken.
#pragma once

#include "host/device.hpp"

namespace dermis::planner {

// Settles plan.model and its precision. `everything`: also what was not taken, with its error. Throws Error::bad_input
// for a model, precision or tolerance that cannot be had.
Explanation choose(plan::Plan&, const Device&, const RunOptions&, bool everything);

} // namespace dermis::planner
