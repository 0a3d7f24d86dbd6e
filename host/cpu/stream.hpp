// SPDX-License-Identifier: MIT
#pragma once

#include "host/simd/isa.hpp"
#include "host/plan/frames.hpp"

#include <memory>

namespace dermis::cpu {

// A stream of pressure frames in f32, in memory that is the caller's.
class Frames {
  public:
    // `plan`, by plan::skin_plan, outlives this. threads: 0 = one per core.
    Frames(const plan::Plan& plan, int threads, const simd::Isa& isa = simd::best());
    ~Frames();
    // Pressure runs from one map of pitch*height to the other in dt seconds. response: where the answers of SA1, SA2,
    // FA1, FA2 begin, null where one is not asked for; fields past the caches where they begin at a cache line. Nothing
    // is allocated.
    void press(double dt, const float* from, const float* to, float* const (&response)[4]);
    void reset(); // to a skin at rest

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace dermis::cpu
