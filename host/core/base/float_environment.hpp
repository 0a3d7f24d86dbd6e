// SPDX-License-Identifier: MIT
#pragma once

#include <cfenv>

namespace dermis {

// Sets the default floating-point environment while in scope. Rounding or flush-to-zero modes that the caller has set
// must not reach results, neither on this thread nor, through a software driver's threads, on a device.
class DefaultFloats {
  public:
    DefaultFloats() : changes_(!is_default()) {
        if (!changes_) return;
        std::fegetenv(&saved_);
        std::fesetenv(FE_DFL_ENV);
    }
    ~DefaultFloats() {
        if (changes_) std::fesetenv(&saved_);
    }
    DefaultFloats& operator=(DefaultFloats&&) = delete; // and no copies

  private:
    // Whether all but the flags of past exceptions are the defaults; false where only fegetenv() could tell. Saving and
    // restoring an environment takes longer than pressing a small pad.
    static bool is_default() {
#ifdef __x86_64__
        unsigned short x87;
        asm volatile("fnstcw %0" : "=m"(x87));
        return x87 == 0x037f && (__builtin_ia32_stmxcsr() & ~0x3fU) == 0x1f80;
#else
        return false;
#endif
    }

    bool changes_;
    std::fenv_t saved_;
};

} // namespace dermis
