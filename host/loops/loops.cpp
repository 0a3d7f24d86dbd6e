// SPDX-License-Identifier: MIT
#include "host/loops/loops.hpp"

namespace dermis::loops {

const std::vector<const Set*>& sets() {
    static const std::vector<const Set*> found = [] {
        std::vector<const Set*> all;
#ifdef DERMIS_X86_64
        for (const Set* s : {&avx512, &avx2})
            if (s->here()) all.push_back(s);
#endif
        all.push_back(&plain);
        return all;
    }();
    return found;
}

} // namespace dermis::loops
