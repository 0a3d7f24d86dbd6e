// SPDX-License-Identifier: MIT
// One cell, alone, in K = f32, f64 or extended: a step of it by kernels/cell.h.
#pragma once

#include "host/core/model/skin.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace dermis::model {

// A cell for kernels/cell.h: its state, as an array of sums: of each element, the integral, the rate of a spring, and
// the pressure of the frame before. k: the coefficients of each element, a spring last, as they stand in a table.
template <class K> struct SingleCell {
    using Sum = typename K::Sum;
    using real = typename K::real;
    const StateShape& shape;
    const typename K::LaneCoefficients* k;
    const Sum* before;
    Sum* after; // null: the step is not kept

    static size_t sums(const StateShape& shape) { return shape.elements + 3; }

    friend int elements_of(const SingleCell& c) { return int(c.shape.elements); }
    friend bool has_spring(const SingleCell& c) { return c.shape.spring; }
    friend bool has_rate(const SingleCell& c) { return c.shape.rate; }
    friend bool has_integral(const SingleCell&) { return true; }
    friend int is_compensated(const SingleCell& c) { return c.shape.compensated; }
    friend bool has_past(const SingleCell& c) { return c.shape.previous; }
    friend const typename K::LaneCoefficients& element_of(const SingleCell& c, int e) {
        return c.k[(1 + c.shape.previous) * e];
    }
    friend const typename K::LaneCoefficients& past_of(const SingleCell& c, int e) { return c.k[2 * e + 1]; }
    friend Sum sum_from(const SingleCell& c, int s) { return c.before[s]; }
    friend real rate_from(const SingleCell& c) { return c.before[c.shape.elements + 1].value; }
    friend real previous_from(const SingleCell& c) { return c.before[c.shape.elements + 2].value; }
    friend void store_previous(const SingleCell& c, real p) {
        if (c.after) c.after[c.shape.elements + 2].value = p;
    }
    friend void store(const SingleCell& c, int s, Sum, Sum after) {
        if (c.after) c.after[s] = after;
    }
    friend void store_rate(const SingleCell& c, real rate) {
        if (c.after) c.after[c.shape.elements + 1].value = rate;
    }
};

// A cell under unit pressure that is stepped for all others: the strain of another cell is this one's times its
// pressure.
template <class K> class ProductCell {
  public:
    // elements: of the chain. duration: of the run, s.
    ProductCell(const Chain& chain, const Element* elements, double duration)
        : shape_{.elements = chain.elements(), .spring = chain.spring, .compensated = true}, length_(chain.length),
          before_(SingleCell<K>::sums(shape_)), after_(before_) {
        double strain = 0;
        for (size_t e = 0; e < length_; ++e) strain += scene::strain_after(elements[e], 1, duration);
        const bool plain = strain > 0x1p-200 && strain < 0x1p200;
        if (std::isnormal(strain) && !plain) scale_ = std::ldexp(1, -std::ilogb(strain));
    }

    void press(const typename K::Load& load, const typename K::Coefficients* k) {
        std::array<typename K::LaneCoefficients, scene::most_in_series> lanes;
        std::transform(k, k + length_, lanes.begin(), K::lanes_of);
        const typename K::Load scaled = K::load(load.s0 * scale_, load.ds * scale_, load.sj * scale_);
        const auto step = K::step_of(SingleCell<K>{shape_, lanes.data(), before_.data(), after_.data()}, scaled);
        for (int q = 0; q < REDUCED_MAPS; ++q) signals_[size_t(q)] = K::signal(q, step.motion, step.integral) / scale_;
    }
    // The step leads to the state from which the next one starts.
    void keep() {
        before_.swap(after_);
        kept_ = signals_;
    }
    // A signal at the end of the step, and at the end of the last one that was kept.
    typename K::real signal(int q) const { return signals_[size_t(q)]; }
    typename K::real kept(int q) const { return kept_[size_t(q)]; }

  private:
    StateShape shape_;
    size_t length_;    // elements in series, a spring included
    double scale_ = 1; // Pa: a power of two under which strains stay far from what is stored as 0
    std::vector<typename K::Sum> before_, after_;
    std::array<typename K::real, REDUCED_MAPS> signals_{}, kept_{};
};

} // namespace dermis::model
