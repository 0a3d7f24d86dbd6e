// SPDX-License-Identifier: MIT
// The nerve fibres of a skin that is pressed frame by frame: their inputs from the skin's state, their presses, their
// spikes.
#pragma once

#include "host/core/model/felt.hpp"
#include "host/core/model/stream.hpp"

namespace dermis {

class Spiking {
  public:
    Spiking(const plan::StreamedSkin&, plan::Backend&);

    bool any() const { return fibres_ != nullptr; }
    // Makes room for the spikes of so many presses of these steps. Sets `refused` to null, or to a step that fibres
    // cannot take. Returns whether such a press takes several blocks of substeps, so that it looks. Changes no state.
    bool prepare(const plan::PadList&, const plan::StepLengths&, size_t presses, const double** refused);
    // Takes the pressures that were pressed last as the inputs at the end of the step, and steps the fibres of these
    // pads. frame: counts the frames of a call; the first one forgets the spikes of the call before. Calls look(); if
    // that throws, the fibres' states are of no time, and spikes() has the spikes of the frames before.
    void press(const plan::PadList&, const plan::StepLengths&, plan::Stream&, size_t frame = 0);
    const std::vector<Spike>& spikes() const { return spikes_; }

    void reset(const plan::PadList&);
    // Gives pads other elements in series, all of them the same.
    void set_elements(const plan::PadList&, const std::vector<plan::Element>&);

    size_t state_bytes() const { return any() ? fibres_->state_size() * sizeof(float) : 0; } // of a pad
    void save(int pad, char* state) const;
    // Throws Error::bad_input for a number that no press makes, in the states of so many pads.
    void need_possible(const char* states, size_t pads) const;
    void load(int pad, const char* state);

  private:
    void read_inputs(const plan::PadList&, plan::Stream&);

    // The cells of one ending of each fibre of a kind: their places in `cells_`.
    struct Source {
        size_t kind, ending;
        bool stress;
        std::vector<uint32_t> cells;
    };
    plan::Felt felt_;
    std::vector<plan::FibreKind> kinds_;
    size_t planes_;                     // of a state
    std::vector<plan::HeldCell> cells_; // that any fibre feels, ascending
    std::vector<Source> sources_;
    std::vector<double> springs_;                        // the modulus of each pad's spring in series, Pa; 0: none
    std::vector<double> moduli_;                         // at which each pad's material comes to rest, Pa
    std::unique_ptr<plan::FibrePopulation<f32>> fibres_; // null: there are none
    std::vector<float> read_;                            // of the states of all pads
    mutable std::vector<float> state_;
    std::vector<Spike> spikes_;
};

} // namespace dermis
