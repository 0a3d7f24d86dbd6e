// SPDX-License-Identifier: MIT
// What the machine's memory gives, measured in the same run as what is held against it.
#pragma once

#include "host/simd/pool.hpp"

#include <cstddef>
#include <memory>

namespace bench {

// Floats on large pages; maps made one after another begin at different bits of an address.
class Floats {
  public:
    explicit Floats(size_t count);
    float* data() const { return begin_; }

  private:
    struct Free {
        void operator()(void* p) const;
    };
    std::unique_ptr<void, Free> memory_;
    float* begin_;
};

class Limits {
  public:
    explicit Limits(int threads);
    double read(); // seconds to read as many bytes
    double copy(); // seconds to read half of them and write the other half past the caches
    static constexpr size_t moved() { return 2 * count * sizeof(float); } // bytes, by either

  private:
    static constexpr size_t count = size_t(48) << 20;
    dermis::simd::Pool pool_;
    Floats from_{count}, to_{count};
};

double now(); // s

} // namespace bench
