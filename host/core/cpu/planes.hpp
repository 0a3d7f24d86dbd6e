// SPDX-License-Identifier: MIT
// Maps of one number per cell, and the planes of a state.
#pragma once

#include "host/core/base/pool.hpp"
#include "host/core/model/skin.hpp"
#include "host/core/simd/isa.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <new>
#include <vector>

namespace dermis::cpu {

// For each line of PITCH_CELLS cells of a padded map: the number that all its cells have, or -1 if they differ.
inline std::vector<int> shared_in_lines(const std::vector<int>& map) {
    std::vector<int> lines(map.size() / PITCH_CELLS);
    for (size_t i = 0; i < lines.size(); ++i) {
        const auto first = map.begin() + std::ptrdiff_t(i * PITCH_CELLS);
        lines[i] = std::all_of(first, first + PITCH_CELLS, [&](int n) { return n == *first; }) ? *first : -1;
    }
    return lines;
}

// One number per cell. The plane and each of its rows begin at a cache line. A plane of more than a large page begins
// at a large page, because at random small pages a step of 4096 x 4096 cells takes up to a quarter longer. Planes that
// are walked side by side have different `place`s: if all began at the same bits of an address, they would compete for
// the same lines of a cache.
template <class real> class Plane {
  public:
    Plane() = default;
    static constexpr size_t shift = 5 * 64 / sizeof(real); // from place to place
    Plane(size_t cells, int place) : shift_(size_t(place) * shift), all_(cells + shift_) {
        const size_t bytes = all_ * sizeof(real);
        const std::align_val_t boundary{bytes < simd::large_page ? size_t(64) : simd::large_page};
        values_ = {static_cast<real*>(::operator new(bytes, boundary)), Free{boundary}};
        simd::prefer_large_pages(values_.get(), bytes);
        clear();
    }
    void clear() { std::fill_n(values_.get(), all_, real(0)); }
    real* data() const { return values_ ? values_.get() + shift_ : nullptr; }
    real* row(int y, int pitch) const { return values_ ? data() + size_t(y) * size_t(pitch) : nullptr; }

  private:
    struct Free {
        std::align_val_t boundary{64};
        void operator()(real* p) const { ::operator delete(p, boundary); }
    };
    std::unique_ptr<real[], Free> values_;
    size_t shift_ = 0, all_ = 0;
};

// The state of every cell.
template <class real> class State {
  public:
    State() = default;
    State(size_t cells, const model::StateShape& shape) : shape_(shape), element_(cells + gap) {
        const int strains = int(shape.elements);
        int place = 0;
        for (auto* planes : {&value_, &lost_}) {
            if (planes == &lost_ && !shape.compensated) break;
            (*planes)[simd::sum_strain] = Plane<real>(shape.elements * element_, place);
            if (shape.integral) (*planes)[simd::sum_integral] = Plane<real>(cells, place + strains);
            place += strains + 1;
        }
        if (shape.strain) strain_ = Plane<real>(cells, place++);
        if (shape.rate) rate_ = Plane<real>(cells, place++);
        if (shape.previous) previous_ = Plane<real>(cells, place);
    }
    bool empty() const { return !value_[0].data(); }
    // The strain of every cell, where the state holds it.
    const real* strain() const { return strain_.data() ? strain_.data() : value_[simd::sum_strain].data(); }
    const real* strain_row(int y, int pitch) const { return strain() + size_t(y) * size_t(pitch); }
    real* integral_row(int y, int pitch) const { return value_[simd::sum_integral].row(y, pitch); }
    // Each plane from column 0 on.
    simd::StateRow<real> row(int y, int pitch) const {
        simd::StateRow<real> row;
        for (size_t s = 0; s < simd::state_sums; ++s) {
            row.value[s] = value_[s].row(y, pitch);
            row.lost[s] = lost_[s].row(y, pitch);
        }
        row.element = element_;
        row.strain = strain_.data() ? strain_.row(y, pitch) : row.value[simd::sum_strain];
        row.rate = rate_.row(y, pitch);
        row.previous = previous_.row(y, pitch);
        return row;
    }
    // Copies what strains follow from, of a row of another state, of `cells` cells.
    void take_strains(const simd::StateRow<real>& from, size_t cells) {
        const simd::StateRow<real> to = row(0, 0);
        for (size_t e = 0; e < shape_.elements; ++e) {
            std::copy_n(from.value[simd::sum_strain] + e * from.element, cells,
                        to.value[simd::sum_strain] + e * to.element);
            if (to.lost[simd::sum_strain])
                std::copy_n(from.lost[simd::sum_strain] + e * from.element, cells,
                            to.lost[simd::sum_strain] + e * to.element);
        }
        if (to.previous) std::copy_n(from.previous, cells, to.previous);
    }
    // Calls f with the first row of each plane that is saved, in the order of model::StateLayout.
    template <class F> void each_plane(F f) const {
        for (size_t e = 0; e < shape_.elements; ++e)
            for (const auto* planes : {&value_, &lost_})
                if (real* strain = (*planes)[simd::sum_strain].data()) f(strain + e * element_);
        for (const auto* planes : {&value_, &lost_})
            if (real* sum = (*planes)[simd::sum_integral].data()) f(sum);
        for (const Plane<real>* plane : {&rate_, &previous_})
            if (plane->data()) f(plane->data());
    }
    void rest() {
        for (Plane<real>* plane : {&value_[0], &value_[1], &lost_[0], &lost_[1], &strain_, &rate_, &previous_})
            plane->clear();
    }

    // Sets one row to rest.
    void rest_row(int y, int pitch) {
        const auto clear = [&](real* row) {
            if (row) std::fill_n(row, pitch, real(0));
        };
        const simd::StateRow<real> r = row(y, pitch);
        for (size_t e = 0; e < shape_.elements; ++e)
            for (real* strain : {r.value[simd::sum_strain], r.lost[simd::sum_strain]})
                if (strain) clear(strain + e * element_);
        for (real* plane : {r.value[simd::sum_integral], r.lost[simd::sum_integral], r.strain, r.rate, r.previous})
            clear(plane);
    }

  private:
    static constexpr size_t gap = Plane<real>::shift; // so that elements begin at different bits of an address
    model::StateShape shape_;
    size_t element_ = 0; // the distance from an element's strains to the next element's strains
    std::array<Plane<real>, simd::state_sums> value_, lost_; // see simd::StateRow
    Plane<real> strain_, rate_;                              // of chains
    Plane<real> previous_;
};

} // namespace dermis::cpu
