// SPDX-License-Identifier: MIT
// Tests whether every kernel of a backend computes the CPU path's bits.
#pragma once

#include "host/core/base/hash.hpp"
#include "host/core/model/stream.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>

namespace dermis {

// The comparison of each kernel on a backend with the plain loops of the CPU path, on small grids.
struct SelfTest {
    struct Kernel {
        const char* name;
        uint64_t hash = fnv1a_64; // FNV-1a of the backend's values
        long long values = 0, different = 0;
        void compare(double device, double cpu); // takes a value and what the CPU path has in its place
    };
    // others: what the samples of the first three leave out: FA2 without gains, the CPU's double, and means, least and
    // greatest values against sums over the maps. Its hash leaves out double, which devices do not have.
    enum { press, reduce, sites, spread, others };
    Kernel kernels[5] = {{"press"}, {"reduce"}, {"sites"}, {"spread"}, {"others"}};
    bool exact() const {
        return std::all_of(std::begin(kernels), std::end(kernels), [](auto& k) { return k.different == 0; });
    }
};
// Tests every kind of variant, in marches and at sites.
SelfTest self_test(model::Backend&);

// Whether a march of this variant has the bits of the CPU path's plain loops.
bool marches_exactly(model::Backend&, const model::Variant&);

} // namespace dermis
