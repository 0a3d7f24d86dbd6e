// SPDX-License-Identifier: MIT
// The process to which threads and devices belong. In a child that it forks, neither these threads nor the driver's
// threads run, so that waiting for one would never end.
#pragma once

#include <new>
#include <string>
#include <utility>

namespace dermis::simd {

// The process in which the object was made.
class Process {
  public:
    Process();
    bool calls() const; // whether it is the calling process
    // Throws Error::device. what: the beginning of the message, such as "a device was".
    [[noreturn]] void refuse(const std::string& what) const;

  private:
    int id_;
};

// Keeps a value, and so what it owns, from ever being destroyed.
template <class T> void leave(T& value) {
    alignas(T) unsigned char for_ever[sizeof(T)];
    new (for_ever) T(std::move(value));
}

} // namespace dermis::simd
