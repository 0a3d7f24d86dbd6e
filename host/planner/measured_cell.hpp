// SPDX-License-Identifier: MIT
// A cell that is stepped for all others, as models of products do: by the run's own operations in double, and once more
// in long double. How far the two are apart is known then, and needs no count of roundings.
#pragma once

#include "host/plan/cell.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace dermis::planner {

// The cell in K = f64 or extended.
template <class K> struct ProductCell {
    std::vector<typename K::Sum> before, after;
    std::array<typename K::real, REDUCED_MAPS> signals{}, signals_before{};

    explicit ProductCell(const plan::CellShape& shape) : before(shape.sums()), after(shape.sums()) {}

    void press(const typename K::Load& load, const typename K::Coefficients* k, const plan::CellShape& shape) {
        std::array<typename K::LaneCoefficients, scene::most_in_series> lanes;
        std::transform(k, k + shape.chain.length, lanes.begin(), K::lanes_of);
        const typename K::Motion m = plan::press_cell<K>(before.data(), after.data(), load, lanes.data(), shape);
        for (int q = 0; q < REDUCED_MAPS; ++q) signals[size_t(q)] = K::signal(q, m, after[shape.integral()].value);
    }
    void keep() {
        before = after;
        signals_before = signals;
    }
};

class MeasuredCell {
  public:
    explicit MeasuredCell(const plan::Chain& chain)
        : shape_{.chain = chain, .compensated = true}, run_(shape_), reference_(shape_) {}

    void press(const f64::Load& load, const f64::Coefficients* k, const extended::Load& exact,
               const extended::Coefficients* exact_k) {
        run_.press(load, k, shape_);
        reference_.press(exact, exact_k, shape_);
    }
    // The mean acceleration of the reference becomes the change of its rate over the step of `length` seconds, without
    // the rounding of terms that cancel.
    void take_change_of_rate(long double length) {
        reference_.signals[QUANTITY_FA2] =
            (reference_.signals[QUANTITY_FA1] - reference_.signals_before[QUANTITY_FA1]) / length;
    }
    // The step leads to the state from which the next one starts.
    void keep() {
        run_.keep();
        reference_.keep();
    }
    // The error of a signal of the run after the step, but for that of its reference.
    double off(int q) const { return double(std::abs(run_.signals[size_t(q)] - reference_.signals[size_t(q)])); }

  private:
    plan::CellShape shape_;
    ProductCell<f64> run_;
    ProductCell<extended> reference_;
};

} // namespace dermis::planner
