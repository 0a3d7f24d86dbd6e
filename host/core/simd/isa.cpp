// SPDX-License-Identifier: MIT
#include "host/core/simd/isa.hpp"

namespace dermis::simd {

const std::vector<const Isa*>& isas() {
    static const std::vector<const Isa*> found = [] {
        std::vector<const Isa*> all;
#ifdef DERMIS_X86_64
        for (const Isa* isa : {&avx512, &avx2})
            if (isa->supported()) all.push_back(isa);
#endif
        all.push_back(&plain);
        return all;
    }();
    return found;
}

} // namespace dermis::simd
