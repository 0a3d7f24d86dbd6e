// SPDX-License-Identifier: MIT
// One cell, alone, in K = f32 or f64: a step of its elements in series by the kernels' functions.
#pragma once

#include "host/core/model/skin.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace dermis::plan {

// The state of a cell: the strain of each element but a spring, the integral of the cell's strain, and the rate of a
// spring, where the variant carries it.
struct CellShape {
    Chain chain;
    bool compensated = false, rate = false;
    size_t integral() const { return chain.elements(); }
    size_t sums() const { return chain.elements() + 1 + rate; }
};

inline CellShape shape_of(const Variant& variant) {
    return {.chain = variant.chain, .compensated = variant.compensated, .rate = variant.carries_rate()};
}

// Returns the motion at the end of a step from one state to another. k: the coefficients of each element.
template <class K>
typename K::Motion motion_between(const typename K::Sum* before, const typename K::Sum* after,
                                  const typename K::Load& load, const typename K::LaneCoefficients* k,
                                  const CellShape& shape) {
    const size_t spring = shape.chain.elements();
    typename K::Motion m = K::motion_of(before[0].value, after[0].value, load, k[0]);
    for (size_t e = 1; e < spring; ++e) m = K::with_element(m, before[e].value, after[e].value, load, k[e]);
    if (shape.chain.spring) m.strain = K::in_series(m.strain, K::spring_strain(load, k[spring]));
    const size_t rate = shape.integral() + 1;
    return shape.rate ? K::with_spring_rates(m, before[rate].value, after[rate].value, k[spring]) : m;
}

// Steps a cell to the state `after`. Returns its motion.
template <class K>
typename K::Motion press_cell(const typename K::Sum* before, typename K::Sum* after, const typename K::Load& load,
                              const typename K::LaneCoefficients* k, const CellShape& shape) {
    const size_t integral = shape.integral();
    for (size_t e = 0; e < shape.chain.elements(); ++e)
        after[e] = K::advanced_strain(before[e], load, k[e], shape.compensated);
    if (shape.rate) after[integral + 1].value = K::spring_rate(before[integral + 1].value, load, k[integral]);
    const typename K::Motion m = motion_between<K>(before, after, load, k, shape);
    after[integral] = K::advanced_integral(before[integral], m.gained, k[0], shape.compensated);
    return m;
}

// A cell under unit pressure that is stepped for all others: the strain of another cell is this one's times its
// pressure.
template <class K> class ProductCell {
  public:
    // elements: of the shape's chain. duration: of the run, s.
    ProductCell(const CellShape& shape, const Element* elements, double duration)
        : shape_(shape), before_(shape.sums()), after_(before_) {
        double strain = 0;
        for (size_t e = 0; e < shape.chain.length; ++e) strain += scene::strain_after(elements[e], 1, duration);
        const bool plain = strain > 0x1p-200 && strain < 0x1p200;
        if (std::isnormal(strain) && !plain) scale_ = std::ldexp(1, -std::ilogb(strain));
    }

    void press(const typename K::Load& load, const typename K::Coefficients* k) {
        std::array<typename K::LaneCoefficients, scene::most_in_series> lanes;
        std::transform(k, k + shape_.chain.length, lanes.begin(), K::lanes_of);
        const typename K::Load scaled = K::load(load.s0 * scale_, load.ds * scale_, load.sj * scale_);
        const typename K::Motion m = press_cell<K>(before_.data(), after_.data(), scaled, lanes.data(), shape_);
        for (int q = 0; q < REDUCED_MAPS; ++q)
            signals_[size_t(q)] = K::signal(q, m, after_[shape_.integral()].value) / scale_;
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
    CellShape shape_;
    double scale_ = 1; // Pa: a power of two under which strains stay far from what is stored as 0
    std::vector<typename K::Sum> before_, after_;
    std::array<typename K::real, REDUCED_MAPS> signals_{}, kept_{};
};

} // namespace dermis::plan
