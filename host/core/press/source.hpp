// SPDX-License-Identifier: MIT
// The numbers that a caller hands to a press: pressures, or depths, which become strains. They are checked and copied
// before anything is pressed.
#pragma once

#include "host/core/press/pressed_cells.hpp"

namespace dermis {

class Source {
  public:
    Source(const model::StreamedSkin&, const SkinOptions&);
    bool depths() const { return thickness_ > 0; } // SkinOptions::control
    // Throws Error::bad_input for a step, or a number of pressures, that no press takes.
    void need(size_t numbers, const model::StepLengths&, const model::PadList&, size_t cells_of_pad) const;
    // Hands pressures of all cells, or of the cells that sites read, to the stream. Throws Error::bad_input for one
    // that is not finite.
    void take(PressedCells&, const model::PadList&, const float* pressures, size_t numbers);
    void take_read(PressedCells&, const model::PadList&, const float* pressures, size_t numbers);
    // Returns a copy of frames, as pressures or strains. It calls look() from time to time. It is valid until the next
    // call.
    const float* copied(PressedCells&, const model::PadList&, const float* frames, size_t count, size_t numbers);
    // Throws Error::bad_input naming the first number that is not finite, or none if another thread has changed it
    // since. listed: the cells whose numbers these are; empty: all cells.
    [[noreturn]] void refuse(const char* argument, const float* numbers, const model::PadList&, size_t frames = 1,
                             const std::vector<size_t>& listed = {}) const;

  private:
    const float* to_take(const float* numbers, size_t count);
    void to_strains(const float* depths, size_t count, float* to) const;

    const size_t pads_, width_, cells_;
    const float thickness_;      // m, of a skin that is pressed by depths; otherwise 0
    std::vector<float> strains_; // of a frame of depths
    std::vector<float> taken_;   // copies of the frames of a call
};

} // namespace dermis
