// SPDX-License-Identifier: MIT
// Maps of one number per cell, and the planes of a state.
#pragma once

#include "host/simd/pool.hpp"

#include <algorithm>
#include <memory>
#include <new>

namespace dermis::cpu {

// Values that begin at a cache line, and so do their rows. Planes that are walked side by side have different `place`s:
// all beginning at the same bits of an address they would compete for the same lines of a cache.
template <class real> class Plane {
  public:
    Plane() = default;
    Plane(size_t cells, int place) : shift_(size_t(place) * 5 * size_t(line) / sizeof(real)) {
        const size_t all = cells + shift_;
        values_.reset(static_cast<real*>(::operator new(all * sizeof(real), line)));
        simd::prefer_large_pages(values_.get(), all * sizeof(real));
        std::fill_n(values_.get(), all, real(0));
    }
    real* data() const { return values_ ? values_.get() + shift_ : nullptr; }
    real* row(int y, int pitch) const { return values_ ? data() + size_t(y) * size_t(pitch) : nullptr; }

  private:
    static constexpr std::align_val_t line{64};
    struct Free {
        void operator()(real* p) const { ::operator delete(p, line); }
    };
    std::unique_ptr<real[], Free> values_;
    size_t shift_ = 0;
};

// One row of a state, each plane from column 0 on; null: what sums have lost unless they are compensated.
template <class real> struct StateRow { real *strain, *integral, *strain_lost, *integral_lost; };

// The state of every cell.
template <class real> class State {
  public:
    State() = default;
    State(size_t cells, bool compensated) : strain_(cells, 0), integral_(cells, 1) {
        if (compensated) strain_lost_ = Plane<real>(cells, 2), integral_lost_ = Plane<real>(cells, 3);
    }
    bool empty() const { return !strain_.data(); }
    const real* strain() const { return strain_.data(); }
    StateRow<real> row(int y, int pitch) const {
        return {strain_.row(y, pitch), integral_.row(y, pitch), strain_lost_.row(y, pitch),
                integral_lost_.row(y, pitch)};
    }
    // Puts the first `cells` at rest.
    void rest(size_t cells) {
        for (const Plane<real>* plane : {&strain_, &integral_, &strain_lost_, &integral_lost_})
            if (plane->data()) std::fill_n(plane->data(), cells, real(0));
    }

  private:
    Plane<real> strain_, integral_, strain_lost_, integral_lost_;
};

} // namespace dermis::cpu
