// SPDX-License-Identifier: MIT
// What a way to run a schedule costs: steps, memory, traffic, seconds. To choose by, no promise.
#pragma once

#include "host/plan/backend.hpp"

namespace dermis::planner {

Candidate costed(const plan::PreparedSkin&, const plan::Schedule&, Model, Precision, const plan::Capabilities&);

} // namespace dermis::planner
