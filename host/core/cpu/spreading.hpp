// SPDX-License-Identifier: MIT
// Spreads maps of pads to the depths of receptors, where they answer: the passes of kernels/spread.h, in K = f32 or
// f64. Threads share the rows of one pad; of many pads each thread takes whole ones, small pads side by side.
#pragma once

#include "host/core/base/pool.hpp"
#include "host/core/model/skin.hpp"
#include "host/core/model/spread.hpp"
#include "host/core/model/streamed_skin.hpp"
#include "host/core/simd/isa.hpp"

#include <atomic>

namespace dermis::cpu {

template <class K> class Spreading {
  public:
    using real = typename K::real;
    // What answers, by its number in kernels/layout.h, and where it lies; null: at the surface.
    struct Class {
        int quantity;
        std::shared_ptr<const model::Spread> spread;
    };
    // pitch: numbers from row to row of the maps that are given. gained: answers have the gain of the skin's curvature.
    Spreading(const model::PreparedSkin&, std::vector<Class>, size_t pitch, size_t pads, bool gained, int threads,
              const simd::Isa&);
    // Spreads maps of these pads, each class its own: from[class], pitch*height numbers for each pad, one pad after
    // another, to to[class]. strain: likewise, from which the gain follows; read if answers have it. Allocates nothing.
    void spread(const model::PadList&, const real* const* from, real* const* to, const real* strain);
    const std::vector<Class>& classes() const { return classes_; }

  private:
    // A level of a class in memory, with zeros around its nodes.
    struct NodeMap {
        NodeMap(const model::SpreadLevel&, int beside);
        real* row(int y) { return all.data() + size_t(y - low) * pitch + front; }
        int low;
        size_t pitch, front;
        std::vector<real> all;
    };
    // The levels of each class, of one pad or of pads side by side; and where its maps begin.
    struct Unit {
        int beside = 1;
        size_t pitch = 0;
        std::vector<std::vector<NodeMap>> down, up;
        std::vector<const real*> from;
        std::vector<real*> to;
        const real* strain = nullptr;
        std::vector<real> gain, in, out, in_strain; // the last three of pads side by side
    };
    // Rows that a thread makes and uses again.
    struct Rows {
        std::vector<real> memory;
        real *column, *even, *odd, *fold[simd::most_radius + 1], *wide[4], *zeros;
    };
    Rows rows_of(int beside) const;
    Unit unit_of(int beside) const;
    void take(Unit&, size_t of, int first, int last);
    void halve(Unit&, size_t of, int level, int first, int last, Rows&);
    void raise(Unit&, size_t of, int level, int first, int last, Rows&);
    template <class Share> void pass(Unit&, size_t first, size_t last, Share share);
    template <class Share> void bend(Unit&, Share share);
    void spread_alone(int pad, const real* const* from, real* const* to, const real* strain);
    void spread_beside(int thread, const int* pads, size_t count, const real* const* from, real* const* to,
                       const real* strain);

    const std::vector<Class> classes_;
    const simd::Loops<K>& loops_;
    const int width_, height_, stencil_, edges_;
    const size_t pitch_;
    const typename K::Constants constants_;
    std::vector<real> rest_;                              // curvature at rest, padded; empty: the gain is 1
    std::vector<std::vector<std::vector<real>>> weights_; // [class][level]
    size_t rest_pitch_;
    simd::Pool pool_;
    std::vector<Unit> units_; // one that threads share, or one for each thread
    std::vector<Rows> of_threads_;
    std::atomic<size_t> next_{0};
};

} // namespace dermis::cpu
