// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/model/stream.hpp"
#include "host/core/simd/isa.hpp"

namespace dermis::cpu {

// The CPU path as a backend. threads: 0 = one per core.
std::unique_ptr<plan::Backend> backend(int threads, const simd::Isa& isa = simd::best());

} // namespace dermis::cpu
