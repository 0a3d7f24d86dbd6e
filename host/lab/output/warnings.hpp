// SPDX-License-Identifier: MIT
#pragma once

#include "dermis/dermis.hpp"

namespace dermis::output {

// Returns a sentence for each reason not to trust a result as it stands, with what can be done about it. A figure that
// the result does not know gives none. scene: as it was run.
std::vector<std::string> warnings(const Scene& scene, const Result&);

} // namespace dermis::output
