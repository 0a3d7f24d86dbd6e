// SPDX-License-Identifier: MIT
// The march of a skin whose receptors lie at depths.
#pragma once

#include "host/core/model/stream.hpp"
#include "host/lab/schedule/half_space.hpp"

namespace dermis::model {

// The backend marches the signals of the surface. At the end of each step that is sampled or read, their maps are
// spread on the host, and answer. half_space: Schedule::half_space, whose depths spread.
std::unique_ptr<March> deep_march(Backend&, const MarchPlan&, const HalfSpaces& half_space);

} // namespace dermis::model
