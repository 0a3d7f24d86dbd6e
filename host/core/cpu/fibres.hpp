// SPDX-License-Identifier: MIT
// Nerve fibres of several kinds in each of several pads, on the CPU.
#pragma once

#include "host/core/base/pool.hpp"
#include "host/core/model/fibres.hpp"
#include "host/core/simd/isa.hpp"

#include <span>

namespace dermis::cpu {

// Fibres of one model, numbered from the fibres of the kinds before on.
struct FibreKind {
    AfferentModel model;
    size_t count;
};

// A spike of a press; fibre: its number in its pad.
template <class real> struct FibreFires {
    int pad, fibre;
    real share; // of the press
};

// K: f32 or f64, the numbers of states and times.
template <class K> class Fibres {
  public:
    using real = typename K::real;

    Fibres(const std::vector<FibreKind>&, size_t pads, int threads, const simd::Isa&);

    size_t count() const { return count_; } // fibres of a pad
    // The input of each fibre of a pad at the end of its next press. It is kept until it is changed.
    void set_input(size_t pad, const real* inputs);
    // Makes the constants of steps of dt seconds. Returns false if a constant does not fit, and nothing has changed
    // then. Allocates where a step of this length may have more spikes than those before.
    bool prepare(double dt);
    // Presses one pad, or all pads, over a step of the dt that was prepared last, and appends to spikes(). A dt of 0
    // takes the inputs alone.
    void press(size_t first_pad, size_t pads);
    size_t most_spikes() const { return spikes_.size(); } // of a press of all pads
    void forget_spikes() { fired_ = 0; }
    // The spikes of presses since forget_spikes(): by pad in the order of presses, then by fibre, then by time.
    std::span<const FibreFires<real>> spikes() const { return {spikes_.data(), fired_}; }

    void reset(size_t pad);
    // The numbers of a pad's state, fibre by fibre.
    size_t state_size() const { return count_ * simd::fibre_planes; }
    void save(size_t pad, real* state) const;
    void load(size_t pad, const real* state);

  private:
    struct Kind {
        AfferentModel model;
        size_t count, padded, first, offset; // first: fibre of a pad; offset: of its fibres in a plane of a pad
        typename K::FibreConstants constants;
    };
    struct Task {
        size_t pad, kind, first, last; // fibres of the kind
        int fired;
    };
    static constexpr size_t line = 64 / sizeof(real), share = 4096;

    size_t at(size_t pad, const Kind& k, size_t fibre) const { return pad * padded_ + k.offset + fibre; }
    template <class One> void each_number(size_t pad, One one) const;

    std::vector<Kind> kinds_;
    size_t count_ = 0, padded_ = 0, pads_; // fibres of a pad, and their room in a plane
    double dt_ = 0;
    const simd::Isa& isa_;
    simd::Pool pool_;
    size_t plane_;                      // numbers of a plane
    std::vector<real> memory_, inputs_; // planes and inputs begin at a cache line
    real *state_ = nullptr, *input_ = nullptr;
    int most_substeps_ = 0;
    std::vector<simd::FibreSpike<real>> raw_;
    std::vector<Task> tasks_;
    std::vector<FibreFires<real>> spikes_;
    size_t fired_ = 0;
};

} // namespace dermis::cpu
