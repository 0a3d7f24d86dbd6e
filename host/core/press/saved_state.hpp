// SPDX-License-Identifier: MIT
// The states of pads as bytes. A header is followed by parts, each with its name and its length, so that a skin with
// more to remember adds a part and the version stays. Version 2, which had no parts, is read too.
#pragma once

#include "host/core/press/stage.hpp"

#include <cstdint>

namespace dermis {

// Where the numbers of a state are: those of the pressed cells, and the parts of the other stages, null if a stage has
// none. Byte: char or const char.
template <class Byte> struct StateParts {
    model::StateMemory<Byte> cells;
    Byte *steps = nullptr, *fibres = nullptr, *shear = nullptr;
    operator StateParts<const Byte>() const { return {cells, steps, fibres, shear}; }
};

class SavedState {
  public:
    SavedState(const model::StreamedSkin&, const Stage& steps, const Stage& fibres, const Stage& shear);

    // The bytes of so many pads.
    size_t bytes(size_t pads) const;
    // Writes all but the numbers of so many pads. Returns where the numbers go. Throws Error::bad_input where `bytes`
    // is another number than bytes(pads).
    StateParts<char> write(void* state, size_t bytes, size_t pads) const;
    // Returns where the numbers of so many pads are. Throws Error::bad_input naming the first thing in which the state
    // differs from the skin's, and where a number is not finite.
    StateParts<const char> read(const void* state, size_t bytes, size_t pads) const;

  private:
    // What a state is of; in version 3 a part of it.
    struct Shape {
        uint32_t width, height, cells, elements, spring, compensated, integral, rate, sites;
    };
    enum Part { shape_part, steps_part, strains_part, pressure_part, fibres_part, shear_part, part_count };

    template <class Byte> StateParts<Byte> all_of(Byte* const (&parts)[part_count]) const;
    size_t bytes_of(Part, size_t pads) const;
    bool find_parts(const char* at, size_t left, size_t pads, const char* (&parts)[part_count]) const;
    std::string part_list() const;
    void check(const Shape&) const;

    bool has(int part) const { return part == shape_part || of_pad_[part] > 0; }

    Shape shape_;
    size_t of_pad_[part_count]{}; // bytes of a pad in each part but the shape
};

} // namespace dermis
