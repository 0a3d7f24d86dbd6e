// SPDX-License-Identifier: MIT
#pragma once

#include "host/simd/isa.hpp"
#include "host/plan/stepper.hpp"

#include <memory>

namespace dermis::cpu {

// threads: 0 = one per core. `plan` outlives the stepper.
std::unique_ptr<plan::Stepper> march(const plan::Plan& plan, int threads, plan::Stepper::Sink,
                                     const simd::Isa& isa = simd::best());

} // namespace dermis::cpu
