// SPDX-License-Identifier: MIT
// The cost of running a schedule by one model: steps, memory, traffic, seconds. Costs serve to choose, they are no
// promise.
#pragma once

#include "host/plan/backend.hpp"

namespace dermis::planner {

Candidate costed(const plan::PreparedSkin&, const plan::Schedule&, Model, Precision, const plan::Capabilities&);

} // namespace dermis::planner
