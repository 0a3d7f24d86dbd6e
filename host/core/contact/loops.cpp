// SPDX-License-Identifier: MIT
#define DERMIS_LOOPS plain_loops
#include "host/core/contact/loops.inl"

namespace dermis::contact {

const CellLoops& loops() {
#ifdef DERMIS_X86_64
    static const bool has_avx2 = __builtin_cpu_supports("avx2");
    if (has_avx2) return avx2_loops;
#endif
    return plain_loops;
}

} // namespace dermis::contact
