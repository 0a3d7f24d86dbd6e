// SPDX-License-Identifier: MIT
// The states of pads as bytes. A header is followed by parts, each with its name and its length, so that a skin with
// more to remember adds a part and the version stays. Version 2, which had no parts, is read too.
#pragma once

#include "host/core/model/streamed_skin.hpp"

#include <cstdint>

namespace dermis {

class SavedState {
  public:
    // fibres, shear: bytes of the state of a pad's nerve fibres, and of its shear; 0: it has none.
    SavedState(const plan::StreamedSkin&, size_t fibres, size_t shear);

    // The bytes of so many pads.
    size_t bytes(size_t pads) const;
    // Writes all but the numbers of so many pads. Returns where the numbers go. Throws Error::bad_input where `bytes`
    // is another number than bytes(pads).
    plan::StateMemory<char> write(void* state, size_t bytes, size_t pads) const;
    // Returns where the numbers of so many pads are. Throws Error::bad_input naming the first thing in which the state
    // differs from the skin's, and where a number is not finite.
    plan::StateMemory<const char> read(const void* state, size_t bytes, size_t pads) const;

  private:
    // What a state is of; in version 3 a part of it.
    struct Shape {
        uint32_t width, height, cells, elements, spring, compensated, integral, rate, sites;
    };
    // steps: the last step of each pad, s, a double each; only under parabolic hold. fibres, shear: only where there
    // are any.
    enum Part { shape_part, steps_part, strains_part, pressure_part, fibres_part, shear_part, part_count };

    template <class Byte> plan::StateMemory<Byte> memory_of(Byte* const (&parts)[part_count]) const;
    size_t bytes_of(Part, size_t pads) const;
    bool find_parts(const char* at, size_t left, size_t pads, const char* (&parts)[part_count]) const;
    std::string part_list() const;
    void check(const Shape&) const;

    bool has(int part) const { return part == shape_part || of_pad_[part] > 0; }

    Shape shape_;
    size_t of_pad_[part_count]{}; // bytes of a pad in each part but the shape
};

} // namespace dermis
