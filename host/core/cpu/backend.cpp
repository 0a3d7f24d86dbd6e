// SPDX-License-Identifier: MIT
#include "host/core/cpu/backend.hpp"

#include "host/core/base/cores.hpp"
#include "host/core/cpu/stream.hpp"

namespace dermis::cpu {

int CpuBackend::threads() const { return threads_ ? threads_ : simd::cores(); }

std::unique_ptr<plan::Stream> CpuBackend::stream(const plan::StreamedSkin& skin) {
    return cpu::stream(skin, threads_, isa_);
}

} // namespace dermis::cpu
