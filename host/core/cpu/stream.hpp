// SPDX-License-Identifier: MIT
// A skin on the CPU path, pressed frame by frame in f32.
#pragma once

#include "host/core/cpu/cells.hpp"
#include "host/core/model/stream.hpp"

namespace dermis::cpu {

// Presses one skin whose responses are fields. Pressures are maps of pitch*height; all memory is the caller's.
class FramePress {
  public:
    // threads: 0 = one per core.
    FramePress(model::StreamedSkin skin, int threads, const simd::Isa& isa = simd::best());
    // response: where each response begins, in the order of kernels/layout.h; null: not asked for. response_pitch:
    // cells from row to row of a response; 0: as in a map. Large responses are streamed past the caches if all of them
    // begin at cache lines. Returns false, and changes nothing, if a coefficient of the step is beyond float. Allocates
    // nothing.
    bool press(const model::FrameStep& step, const float* from, const float* to,
               float* const (&response)[RESPONSE_MAPS], size_t response_pitch = 0) {
        return press_frames(step, from, to, 1, true, response, response_pitch);
    }
    // Presses with each of `count` frames, maps that stand one after another. answers: whether the last press writes
    // the responses; the presses before it write none.
    bool press_frames(const model::FrameStep&, const float* from, const float* frames, size_t count, bool answers,
                      float* const (&response)[RESPONSE_MAPS], size_t response_pitch);
    // Makes the coefficients of the next step. Returns false if one of them is beyond float.
    bool prepare(const model::FrameStep&);
    // Of a uniform material, the same number as before.
    void set_elements(const std::vector<model::Element>& elements) { tables_.set_elements({}, elements); }
    Cells<f32>& cells() { return cells_; }

  private:
    static constexpr size_t together = 8; // steps that a band of rows takes while it is in a cache
    model::StreamedSkin streamed_;
    const Plane<float> rest_;
    model::StepTables tables_;
    Cells<f32> cells_;
    std::vector<CellsPress<f32>> presses_; // not yet pressed
};

// A stream of a batch of pads, or of a single skin as one pad. Each thread takes whole pads.
std::unique_ptr<model::Stream> pad_stream(const model::StreamedSkin&, int threads, const simd::Isa&);
// A stream of a skin or batch that answers by signals. signals: the stream of model::signals_of() the skin, of any
// backend.
std::unique_ptr<model::Stream> deep_stream(const model::StreamedSkin&, std::unique_ptr<model::Stream> signals,
                                           int threads, const simd::Isa& isa = simd::best());
// The stream that is faster for this skin or batch. threads: 0 = one per core.
std::unique_ptr<model::Stream> stream(const model::StreamedSkin&, int threads, const simd::Isa& isa = simd::best());

} // namespace dermis::cpu
