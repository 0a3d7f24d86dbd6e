// SPDX-License-Identifier: MIT
// The opening of a device, its test included, one after the other. An interpreter waits for it before it lets exit()
// begin: while a driver is opened it makes static objects, which exit() would destroy before it waits for uses.
#pragma once

#include "dermis/description.hpp"

#include <mutex>

namespace dermis {

class Opening {
  public:
    Opening() : lock_(mutex()) { // throws Error::device after end()
        if (ended_) throw Error(Error::Code::device, "device", "no device is opened while the process is ending");
    }
    // Waits for the opening of another thread; from then on there is none.
    static void end() {
        const std::lock_guard lock(mutex());
        ended_ = true;
    }

  private:
    // Never destroyed, because threads may go on after the end of main().
    static std::mutex& mutex() {
        static std::mutex& of_all = *new std::mutex;
        return of_all;
    }
    static inline bool ended_ = false;
    std::lock_guard<std::mutex> lock_;
};

} // namespace dermis
