// SPDX-License-Identifier: MIT
// Whether a device's bits are the CPU path's.
#pragma once

#include "dermis/dermis.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>

namespace dermis {

// Each kernel on small grids in every variant, on the device and on the CPU path.
struct SelfTest {
    struct Kernel {
        const char* name;
        uint64_t hash = 14695981039346656037u; // of the device's values
        long long values = 0, different = 0;
    };
    enum { press, fields, reduce, sites };
    Kernel kernels[4] = {{"press"}, {"fields"}, {"reduce"}, {"sites"}};
    bool exact() const {
        return std::all_of(std::begin(kernels), std::end(kernels), [](auto& k) { return k.different == 0; });
    }
};
// Not every variant: the plain march alone.
SelfTest self_test(const Device&, bool every_variant = true);

} // namespace dermis
