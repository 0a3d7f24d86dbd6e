// SPDX-License-Identifier: MIT
// Memory as the timed loops have it, and the time.
#pragma once

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

double now(); // s

} // namespace bench
