// SPDX-License-Identifier: MIT
// How deep bodies reach below the cells of a pad.
#pragma once

#include "host/core/contact/cells.hpp"
#include "host/core/contact/landing.hpp"

namespace dermis::contact {

// Throws Error::bad_input. number: of a list named `name`; -1: there is no list.
void check(const Body&, const char* name, int number = -1);

// The lines from places of a pad's surface along its inward normals, in the frame of a body.
class Lines {
  public:
    Lines(const Pad&, const Pose& pad, const Pose& body);
    // depth[i]: the greater of what it holds and how far the line from place i leads to where it leaves the body, m.
    void deepen(const Body&, const Places&, double* depth);
    void deepen(const Body&, const CellBlock&, double* depth); // of a block of cells

    // How far a cell extends from its centre along the body's axes, m; of a round pad at most.
    Vector half_cell() const;

  private:
    void fill(const Places&);
    Vector vector(const Vector& v) const { return {dot(rows_[0], v), dot(rows_[1], v), dot(rows_[2], v)}; }

    const Pad pad_;
    Vector rows_[3] = {}, offset_ = {}; // turn the frame of the pad's middle into the body's
    LineRow lines_;
};

} // namespace dermis::contact
