// SPDX-License-Identifier: MIT
// The bandwidth of the machine's memory, measured in the same run as the workloads that are compared with it.
#pragma once

#include "host/core/base/pool.hpp"

#include <cstddef>
#include <memory>

namespace bench {

// An array of floats on large pages. Arrays made one after another begin at different offsets in a page, so that their
// equal indices do not fall into one cache set.
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

// Writes n floats past the caches; both begin at a cache line, and n is a multiple of 16. A fence completes the writes.
void stream(float* to, const float* from, size_t n);
void fence_streams();

class Limits {
  public:
    explicit Limits(int threads);
    double read(); // seconds to read moved() bytes
    double copy(); // seconds to read half of them and write the other half past the caches
    static constexpr size_t moved() { return 2 * count * sizeof(float); } // bytes that either of them moves

  private:
    static constexpr size_t count = size_t(48) << 20;
    dermis::simd::Pool pool_;
    Floats from_{count}, to_{count};
};

double now(); // s

} // namespace bench
