// SPDX-License-Identifier: MIT
#pragma once

#include "host/plan/backend.hpp"
#include "host/simd/isa.hpp"

namespace dermis::cpu {

// The CPU path as a backend. threads: 0 = one per core.
std::unique_ptr<plan::Backend> backend(int threads, const simd::Isa& isa = simd::best());

} // namespace dermis::cpu
