// SPDX-License-Identifier: MIT
// Nerve fibres of several kinds in each of several pads: the constants of their steps, and the interface of what steps
// them.
#pragma once

#include "dermis/afferents.hpp"
#include "host/core/simd/model.hpp"

#include <bit>
#include <span>

namespace dermis::model {

// How closely a step of fibres follows the continuous model.
struct FibreAccuracy {
    double tolerance;  // s: of the place of a spike in a substep; the next spikes inherit the errors of those before
    double resolution; // most that a substep may be of the shortest time constant
};
template <class K> constexpr FibreAccuracy fibre_accuracy = {.tolerance = 2e-8, .resolution = 1.6};
template <> inline constexpr FibreAccuracy fibre_accuracy<f64> = {.tolerance = 1e-12, .resolution = 0.25};

// Fills in the constants of a step of dt seconds. Returns false where it has more than 65536 substeps, or where a
// constant does not fit a number of K.
template <class K> bool fill_fibre_constants(const AfferentModel&, double dt, typename K::FibreConstants&);

// The most passes through the loops of kernels/afferent.h that a substep of an ending takes.
template <class Constants> int passes_of_substep(const Constants& k) {
    return k.events * (140 + 2 * k.bisections + std::popcount(unsigned(k.outputs)) * (50 + 2 * k.turn_bisections)) + 10;
}

// Fibres of one model, numbered from the fibres of the kinds before on.
struct FibreKind {
    AfferentModel model; // whose sensitivity is in its rate
    size_t count;
    size_t endings = 1;               // of each
    std::vector<double> factors = {}; // of each fibre's inputs, for those who set them
};
FibreKind kind_of(const Afferents&); // that were validated

// A spike of a press; fibre: its number in its pad; share: of the press.
template <class real> struct FibreFires {
    int pad, fibre;
    real share;
};

// Fibres that are pressed step by step. K: f32 or f64, the numbers of states and times.
template <class K> class FibrePopulation {
  public:
    using real = typename K::real;

    // line: the first fibre of each kind stands in a plane at a multiple of this.
    FibrePopulation(const std::vector<FibreKind>&, size_t pads, size_t line);
    virtual ~FibrePopulation() = default;
    FibrePopulation(const FibrePopulation&) = delete;

    size_t count() const { return count_; } // fibres of a pad
    // The inputs of a kind's fibres in a pad at the end of its next press, at one of their endings. They are kept until
    // they are changed.
    real* inputs(size_t pad, size_t kind, size_t ending = 0) { return input_ + at(pad, kinds_[kind], 0, ending); }
    void set_input(size_t pad, const real* inputs); // of all endings, fibre by fibre
    // Makes the constants of steps of dt seconds. Returns false where fill_fibre_constants() does, and nothing has
    // changed then. Allocates where a step of this length may have more spikes than those before.
    bool prepare(double dt);
    // Presses neighbouring pads over a step of the dt that was prepared last, and appends to spikes(). A dt of 0 takes
    // the inputs alone. Calls look() between blocks of substeps; if that throws, the states of these pads are of no
    // time, and the spikes are to be forgotten.
    void press(size_t first_pad, size_t pads);
    size_t work_of_pad() const { return size_t(substeps_) * padded_; } // of such a press: substeps of endings
    static constexpr size_t work_of_block = 1 << 20;                   // some ms
    void forget_spikes() { spikes_.clear(), work_ = 0; }
    // The spikes of presses since forget_spikes(): by press, by pad, by fibre, then by time.
    std::span<const FibreFires<real>> spikes() const { return spikes_; }
    // The number of spikes of so many presses of all pads, of at most dt seconds each, is not above this.
    size_t most_spikes(double dt, size_t presses) const;

    void reset(size_t pad);
    // The numbers of a pad's state, fibre by fibre and ending by ending.
    size_t state_size() const { return endings_ * FIBRE_PLANES; }
    void save(size_t pad, real* state) const;
    void load(size_t pad, const real* state);

  protected:
    struct Kind {
        AfferentModel model;
        size_t count, endings, padded, first; // padded: numbers from ending to ending; first: fibre of a pad
        size_t offset;                        // of its fibres in a plane of a pad
        typename K::FibreConstants constants;
    };
    size_t at(size_t pad, const Kind& k, size_t fibre, size_t ending = 0) const {
        return pad * padded_ + k.offset + ending * k.padded + fibre;
    }
    void fire(size_t pad, const Kind& k, size_t fibre, real share) {
        spikes_.push_back({int(pad), int(k.first + fibre), share});
    }
    // Makes room for so many spikes of each number in a plane; takes new constants; steps the fibres of pads through
    // substeps from `part` on, as many as these, or as are left. Spikes are fired in any order.
    virtual void grow(size_t most) = 0;
    virtual void take_constants() {}
    virtual void step(size_t first_pad, size_t pads, int part, int parts) = 0;

    std::vector<Kind> kinds_;
    size_t count_ = 0, endings_ = 0, padded_ = 0; // fibres of a pad, their endings, and the room of these in a plane
    size_t pads_, plane_ = 0;
    size_t most_substeps_ = 0;
    int substeps_ = 0, together_ = 0;          // the most of a press, and those of a block
    real *state_ = nullptr, *input_ = nullptr; // the planes, and one more; of those who step them

  private:
    template <class One> void each_ending(size_t pad, One one) const;

    double dt_ = 0;
    std::vector<typename K::FibreConstants> next_; // of each kind, while prepare() makes them
    std::vector<FibreFires<real>> spikes_;
    size_t work_ = 0; // since the last look()
};

} // namespace dermis::model
