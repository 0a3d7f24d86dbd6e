// SPDX-License-Identifier: MIT
// Which process threads and devices belong to: in a child that it forks the threads do not run, and a driver's do not
// either, so that waiting for one would never end.
#pragma once

#include <new>
#include <string>
#include <utility>

namespace dermis::simd {

// The process that makes something.
class Process {
  public:
    Process();
    bool calls() const; // whether it is the calling one
    // Throws Error::device. what: what was opened, as "a device was".
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
