// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

namespace dermis::scene {

// Perlin's improved gradient noise in two dimensions: four octaves, values of about -1..1. Whatever depends on the
// column alone is computed once.
class Noise {
  public:
    // length: cells between the lattice points of the first octave.
    Noise(int width, double length);
    // Computes the noise of the cells of row y. values: one per column, 0 before the call.
    void row(int y, double* values) const;

  private:
    // The place of a column or a row: the lattice point before it, the offset from it, and the weight of the next one.
    struct Place {
        explicit Place(double at);
        int point;
        double offset, weight;
    };
    // Columns first .. last - 1, which have the same lattice point before them.
    struct Span {
        int first, last, point;
        bool below_one; // every weight is below 1
    };
    struct Octave {
        std::vector<double> offset, weight; // of each column's Place
        std::vector<Span> spans;
    };
    template <bool below_one>
    static void add(const Octave&, const Span&, const Place& y, double amplitude, double* values);

    double length_;
    std::array<Octave, 4> octaves_;
};

} // namespace dermis::scene
