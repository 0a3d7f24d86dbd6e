// SPDX-License-Identifier: MIT
#pragma once

#include "host/loops/loops.hpp"
#include "host/plan/marcher.hpp"

#include <memory>

namespace dermis::cpu {

// threads: 0 = one per core. `plan` outlives the marcher.
std::unique_ptr<plan::Marcher> march(const plan::Plan& plan, int threads, plan::Marcher::Sink,
                                     const loops::Set& set = loops::best());

// A stream of pressure frames in memory that is the caller's, in float: maps of pitch*height as `plan` has them.
class Frames {
  public:
    Frames(const plan::Plan& plan, int threads, const loops::Set& set = loops::best()); // see march
    ~Frames();
    // Pressure runs from one frame to the next over a step of plan::framed_step; null responses are left out. Past the
    // caches where a response begins at a cache line.
    void press(const plan::Step&, const float* from, const float* to, float* const (&response)[4]);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace dermis::cpu
