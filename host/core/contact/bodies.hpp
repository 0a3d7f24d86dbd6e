// SPDX-License-Identifier: MIT
// How deep bodies reach below the cells of a pad.
#pragma once

#include "host/core/contact/landing.hpp"

namespace dermis::contact {

constexpr double not_below = -1e6; // m, the depth of a cell that is neither above nor below a body

// Throws Error::bad_input. name: the argument's, "body".
void check(const Body&, const std::string& name);

// Places of a pad's surface, in cells from the centre of cell (0, 0).
struct Places {
    static constexpr int most = 64;
    double x[most], y[most];
    int count = 0;

    void add(double at_x, double at_y) { x[count] = at_x, y[count++] = at_y; }
};

// Calls each(places, first) for `count` cells of row y from column x on, in pieces: `first` is a piece's first cell,
// from 0 on.
template <class Each> void each_piece(int x, int y, int count, const Each& each) {
    for (int first = 0; first < count; first += Places::most) {
        Places places;
        places.count = std::min(Places::most, count - first);
        for (int i = 0; i < places.count; ++i) places.x[i] = x + first + i, places.y[i] = y;
        each(places, first);
    }
}

// The lines from places of a pad's surface along its inward normals, in the frame of a body.
class Lines {
  public:
    Lines(const Pad&, const Pose& pad, const Pose& body);
    // depth[i]: the greater of what it holds and how far the line from place i leads to where it leaves the body, m.
    void deepen(const Body&, const Places&, double* depth);

  private:
    using Row = double[3][Places::most];
    void fill(const Places&);
    Vector vector(const Vector& v) const { return {dot(rows_[0], v), dot(rows_[1], v), dot(rows_[2], v)}; }

    const Pad pad_;
    Vector rows_[3] = {}, offset_ = {}; // turn the frame of the pad's middle into the body's
    double deepest_;                    // m: what is deeper is on a round pad's other side
    Row from_, along_;                  // of each line its place and its direction
};

} // namespace dermis::contact
