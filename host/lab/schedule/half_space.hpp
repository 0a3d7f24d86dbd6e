// SPDX-License-Identifier: MIT
// The stress at a depth below a grid of pressed cells, as sums over all cells and by Fourier transforms.
#pragma once

#include "host/core/base/pool.hpp"
#include "host/core/model/spread.hpp"
#include "host/core/simd/model.hpp"

#include <limits>

namespace dermis::model {

// The pressures at a depth that evenly pressed cells cause, cell by cell: integrals over squares (Love 1929).
class HalfSpace {
  public:
    HalfSpace(const Grid&, const Depth&); // a grid with spacing
    const Depth& depth() const { return depth_; }
    // What spreads maps to this depth; fitted when it is first asked for.
    bool spreads() const { return in_cells_.depth >= least_depth && in_cells_.depth <= most_depth; }
    std::shared_ptr<const Spread> spread() const;
    // What a cell adds at a cell `x` columns and `y` rows away, per unit of its pressure.
    double weight(int x, int y) const { return weights_[size_t(std::abs(y)) * size_t(width_) + size_t(std::abs(x))]; }
    // What all cells of a map (Pa, width*height) add at one cell, Pa: the sum itself.
    template <class T> T at(const std::vector<double>& map, Cell) const; // in T = double or long double
    // How far at() is off the sum, at most, relative to the sum of magnitudes.
    template <class T> double roundings() const {
        return double(std::numeric_limits<T>::epsilon()) / 2 * (0.25 * width_ + height_ + 4);
    }
    // What the weights of the cells that a map presses may be off in sum, beyond 1.1 half units of double's last place,
    // of a map with a greatest |pressure| of 1. `magnitudes`: at least the sum of |weight*pressure|. `sum`: of
    // |pressure|. The weights are computed in numbers with that many binary digits.
    double excess(double magnitudes, double sum, int digits = std::numeric_limits<long double>::digits) const;
    // The sum of all |weights|: no stress exceeds it times the greatest |pressure|. Also the sum of their squares, and
    // the greatest one.
    double norm() const { return norm_; }
    double squares() const { return squares_; }
    double most() const { return most_; }

  private:
    Depth depth_, in_cells_;
    int width_, height_;
    mutable std::shared_ptr<const Spread> spread_;
    std::vector<double> weights_; // of a quarter of the plane, row 0 first
    double norm_ = 0, squares_ = 0, most_ = 0;
};

using HalfSpaces = std::array<std::shared_ptr<const HalfSpace>, REDUCED_MAPS>; // of each class; null: none

// What all cells of a map add at every cell, below each half-space, by fast Fourier transforms where cells are many.
// Pa, width*height.
std::vector<std::vector<double>> stresses_of(const std::vector<double>& map, const Grid&,
                                             const std::vector<const HalfSpace*>&, simd::Pool&);
// A bound of how far stresses_of() is off the sums before they are rounded to double, Pa.
double error_of_stresses(const std::vector<double>& map, const Grid&, const HalfSpace&);

} // namespace dermis::model
