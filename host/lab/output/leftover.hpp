// SPDX-License-Identifier: MIT
// Removes what a process leaves half done, also where a signal ends it.
#pragma once

#include <string>

namespace dermis::output {

// While such an object lives no signal ends the process, except SIGKILL and faults of the process itself. A signal that
// arrives meanwhile ends the process when the object is destroyed. Such objects do not nest.
class HeldSignals {
  public:
    HeldSignals();
    ~HeldSignals();
    HeldSignals(const HeldSignals&) = delete;
};

// The path of a file, or of a folder that is empty, which is removed with this object or where a signal ends the
// process.
class Leftover {
  public:
    // The path is made while the same signals are held, so that it is never another process's.
    Leftover(std::string path, const HeldSignals&);
    ~Leftover();
    Leftover(const Leftover&) = delete;
    const std::string& path() const { return path_; }

  private:
    friend void remove_leftovers() noexcept;
    std::string path_;
    Leftover* older_;
};

// Removes all of them now, before the process ends without destructors.
void remove_leftovers() noexcept;
// Removes leftovers on each signal that would end the process and can be caught; one that is ignored, or handled
// already, stays so.
void remove_leftovers_on_signals();

} // namespace dermis::output
