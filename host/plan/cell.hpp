// SPDX-License-Identifier: MIT
// One cell, alone, in K = f32 or f64: a step of its elements in series by the kernels' functions.
#pragma once

#include "host/plan/skin.hpp"

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

} // namespace dermis::plan
