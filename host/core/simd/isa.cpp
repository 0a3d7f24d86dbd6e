// SPDX-License-Identifier: MIT
#include "host/core/simd/isa.hpp"

namespace dermis::simd {

const std::vector<const Isa*>& isas() {
    // Never destroyed, because threads may go on after the end of main().
    static const auto& found = *new const std::vector<const Isa*>([] {
        std::vector<const Isa*> all;
#ifdef DERMIS_X86_64
        for (const Isa* isa : {&avx512, &avx2})
            if (isa->supported()) all.push_back(isa);
#endif
        all.push_back(&plain);
        return all;
    }());
    return found;
}

} // namespace dermis::simd
