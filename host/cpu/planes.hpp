// SPDX-License-Identifier: MIT
// Maps of one number per cell, and the planes of a state.
#pragma once

#include "host/simd/isa.hpp"
#include "host/simd/pool.hpp"

#include <algorithm>
#include <array>
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

// The state of every cell.
template <class real> class State {
  public:
    State() = default;
    State(size_t cells, bool compensated) {
        int place = 0;
        for (Plane<real>& plane : value_) plane = Plane<real>(cells, place++);
        for (Plane<real>& plane : lost_)
            if (compensated) plane = Plane<real>(cells, place++);
    }
    bool empty() const { return !strain(); }
    const real* strain() const { return value_[simd::sum_strain].data(); }
    // Each plane from column 0 on.
    simd::StateRow<real> row(int y, int pitch) const {
        simd::StateRow<real> row;
        for (size_t s = 0; s < simd::state_sums; ++s) {
            row.value[s] = value_[s].row(y, pitch);
            row.lost[s] = lost_[s].row(y, pitch);
        }
        return row;
    }
    // Puts the first `cells` at rest.
    void rest(size_t cells) {
        for (const auto* planes : {&value_, &lost_})
            for (const Plane<real>& plane : *planes)
                if (plane.data()) std::fill_n(plane.data(), cells, real(0));
    }

  private:
    std::array<Plane<real>, simd::state_sums> value_, lost_; // see simd::StateRow
};

} // namespace dermis::cpu
