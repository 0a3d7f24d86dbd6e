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
    // Rows first .. last - 1, counted from 0, of a pass of a class: the gain, the copy of a map to level 0, or a level
    // that goes down or comes up. It begins when the `after` first steps have ended.
    struct Step {
        enum { bend, take, halve, raise } pass;
        size_t of;
        int level, first, last;
        size_t after;
    };
    Rows rows_of(int beside) const;
    Unit unit_of(int beside) const;
    std::vector<Step> steps_of(size_t first, size_t last, int together) const;
    void run(Unit&, const Step&, size_t begin, Rows&);
    void bend(Unit&, const Step&, size_t begin);
    void take(Unit&, const Step&, size_t begin);
    void halve(Unit&, const Step&, size_t begin, Rows&);
    void raise(Unit&, const Step&, size_t begin, Rows&);
    void spread_beside(int thread, const model::PadList&, size_t first, const real* const* from, real* const* to,
                       const real* strain);

    std::vector<Class> classes_;
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
    std::vector<std::vector<Step>> steps_; // of all classes together, or of each if pads stand side by side
    std::atomic<size_t> next_{0}, ended_{0};
};

} // namespace dermis::cpu
