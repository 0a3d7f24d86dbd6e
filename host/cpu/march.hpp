// SPDX-License-Identifier: MIT
#pragma once

#include "host/loops/loops.hpp"
#include "host/plan/marcher.hpp"

#include <memory>

namespace dermis::cpu {

// threads: 0 = one per core. `plan` outlives the marcher.
std::unique_ptr<plan::Marcher> march(const plan::Plan& plan, int threads, plan::Marcher::Sink,
                                     const loops::Set& set = loops::best());

} // namespace dermis::cpu
