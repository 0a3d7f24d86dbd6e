// SPDX-License-Identifier: MIT
// Nerve fibres on the CPU. Threads take them in shares.
#pragma once

#include "host/core/base/pool.hpp"
#include "host/core/model/fibres.hpp"
#include "host/core/simd/isa.hpp"

namespace dermis::cpu {

template <class K> class Fibres : public model::FibrePopulation<K> {
  public:
    using real = typename K::real;
    static constexpr size_t line = 64 / sizeof(real); // numbers of a cache line

    Fibres(const std::vector<model::FibreKind>&, size_t pads, int threads, const simd::Isa&);

  private:
    struct Task {
        size_t pad, kind, first, last; // fibres of the kind
        int fired;
    };
    // Where the spikes of a task begin in raw_, which has room for the spikes of every ending.
    size_t raw_at(const Task& t) const {
        const auto& kind = this->kinds_[t.kind];
        return (this->at(t.pad, kind, 0) + t.first * kind.endings) * room_;
    }
    void grow(size_t most) override { raw_.resize(this->plane_ * most), room_ = most; }
    void step(size_t first_pad, size_t pads, int part, int parts) override;

    const simd::Isa& isa_;
    simd::Pool pool_;
    std::vector<real> memory_;
    size_t room_ = 0; // for spikes of each number of a plane
    std::vector<typename K::FibreEntry> raw_;
    std::vector<Task> tasks_;
};

} // namespace dermis::cpu
