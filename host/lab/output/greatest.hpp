// SPDX-License-Identifier: MIT
// The greatest responses of a run, for a reader.
#pragma once

#include "dermis/dermis.hpp"

namespace dermis::output {

// Two lines at most, of the slowly and of the rapidly adapting classes: the greatest response of each class and its
// time, of all cells where the class has a trace with extremes, else of its receptors, with the receptor's cell.
std::vector<std::string> greatest_responses(const Scene&, const Result&);

} // namespace dermis::output
