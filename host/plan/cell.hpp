// SPDX-License-Identifier: MIT
// One cell, alone, in K = f32 or f64: a step of its elements in series by the kernels' functions.
#pragma once

#include "host/plan/skin.hpp"

namespace dermis::plan {

// The state of a cell: the strain of each element but a spring, then the integral of their sum.
inline size_t sums_of(const Chain& chain) { return chain.elements() + 1; }

// Returns the motion at the end of a step from one state to another. k: the coefficients of each element.
template <class K>
typename K::Motion motion_between(const typename K::Sum* before, const typename K::Sum* after, const typename K::Load& load,
                                  const typename K::LaneCoefficients* k, const Chain& chain) {
    typename K::Motion m = K::motion_of(before[0].value, after[0].value, load, k[0]);
    for (size_t e = 1; e < chain.elements(); ++e)
        m = K::with_element(m, before[e].value, after[e].value, load, k[e]);
    if (chain.spring) m.strain = K::in_series(m.strain, K::spring_strain(load, k[chain.elements()]));
    return m;
}

// Steps a cell to the state `after`. Returns its motion.
template <class K>
typename K::Motion press_cell(const typename K::Sum* before, typename K::Sum* after, const typename K::Load& load,
                              const typename K::LaneCoefficients* k, const Chain& chain, int compensated) {
    const size_t integral = chain.elements();
    for (size_t e = 0; e < integral; ++e) after[e] = K::advanced_strain(before[e], load, k[e], compensated);
    const typename K::Motion m = motion_between<K>(before, after, load, k, chain);
    after[integral] = K::advanced_integral(before[integral], m.gained, k[0], compensated);
    return m;
}

} // namespace dermis::plan
