// SPDX-License-Identifier: MIT
#pragma once

#include <cfenv>

namespace dermis {

// Sets the default floating-point environment while in scope. Rounding or flush-to-zero modes that the caller has set
// must not reach results, neither on this thread nor, through a software driver's threads, on a device.
class DefaultFloats {
  public:
    DefaultFloats() {
        std::fegetenv(&saved_);
        std::fesetenv(FE_DFL_ENV);
    }
    ~DefaultFloats() { std::fesetenv(&saved_); }
    DefaultFloats(const DefaultFloats&) = delete;
    DefaultFloats& operator=(const DefaultFloats&) = delete;

  private:
    std::fenv_t saved_;
};

} // namespace dermis
