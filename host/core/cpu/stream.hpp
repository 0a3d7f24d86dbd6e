// SPDX-License-Identifier: MIT
// A skin pressed frame by frame on the CPU path, in f32.
#pragma once

#include "host/core/model/stream.hpp"
#include "host/core/simd/isa.hpp"

namespace dermis::cpu {

// A press of fields, from any map of pitch*height to any other, into memory that is the caller's.
class FramePress {
  public:
    // threads: 0 = one per core.
    FramePress(plan::StreamedSkin skin, int threads, const simd::Isa& isa = simd::best());
    ~FramePress();
    // response: where the responses begin, in the order of kernels/layout.h, null where one is not asked for; rows of
    // fields are so many cells apart, and large ones are streamed past the caches if all begin at cache lines. False,
    // and nothing has happened, where a coefficient of the step is beyond float. Nothing is allocated.
    bool press(double dt, const float* from, const float* to, float* const (&response)[RESPONSE_MAPS],
               size_t response_pitch);
    // The same where rows are a pitch apart.
    bool press(double dt, const float* from, const float* to, float* const (&response)[RESPONSE_MAPS]);
    void reset(); // to a skin at rest
    // Copies the planes of a state (plan::StateLayout), without the pressure.
    void save(char* planes) const;
    void load(const char* planes);
    void set_elements(const std::vector<plan::Element>&); // of a uniform material, in place of as many
    // Copies width*height numbers to a map of pitch*height, on the threads of a press. Returns whether all are finite.
    bool take(const float* numbers, float* to);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

// A stream of pads alike, or of a skin as one, of which a thread takes whole pads.
std::unique_ptr<plan::Stream> pad_stream(const plan::StreamedSkin&, int threads, const simd::Isa&);
// threads: 0 = one per core.
std::unique_ptr<plan::Stream> stream(const plan::StreamedSkin&, int threads, const simd::Isa& isa = simd::best());

} // namespace dermis::cpu
