// SPDX-License-Identifier: MIT
// The model `march` on the CPU path.
#pragma once

#include "host/core/simd/isa.hpp"
#include "host/lab/march/stepper.hpp"

namespace dermis::cpu {

// threads: 0 = one per core. Skin and schedule outlive the stepper.
std::unique_ptr<plan::Stepper> stepper(const plan::PreparedSkin&, const plan::Schedule&, Precision, int threads,
                                       plan::Stepper::Sink, const simd::Isa& isa = simd::best());

} // namespace dermis::cpu
