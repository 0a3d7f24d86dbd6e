// SPDX-License-Identifier: MIT
// The model `sites`: a march, in double, of no more cells than sites and their stencils need. A site has the bits that
// the CPU path in double gives its cell.
#pragma once

#include "host/plan/marcher.hpp"

#include <memory>

namespace dermis::model {

size_t cells_of_sites(const plan::Plan&); // distinct, with those of their stencils

std::unique_ptr<plan::Marcher> sites(const plan::Plan&, plan::Marcher::Sink);

} // namespace dermis::model
