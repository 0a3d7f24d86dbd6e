// SPDX-License-Identifier: MIT
// The nerve fibres of a skin that is pressed frame by frame: their inputs from the skin's state, their presses, their
// spikes.
#pragma once

#include "host/core/press/pressed_cells.hpp"

namespace dermis {

class Spiking : public Stage {
  public:
    Spiking(const model::StreamedSkin&, model::Backend&, PressedCells&);

    bool any() const { return fibres_ != nullptr; }
    void prepare(const model::PadList&, const model::StepLengths&, size_t presses) override;
    bool in_blocks() const { return in_blocks_; } // the press that was prepared looks, between blocks of substeps
    // Takes what cells feel at the end of the step as inputs. The first frame forgets the spikes of the call before.
    // Calls look(); if that throws, the fibres' states are of no time, and spikes() has the spikes of the frames
    // before.
    void press(const model::PadList&, const model::StepLengths&, size_t frame, bool last) override;
    const std::vector<Spike>& spikes() const { return spikes_; }

    void reset(const model::PadList&) override;
    void set_elements(const model::PadList&, const std::vector<model::Element>&) override;

    size_t state_bytes() const override { return any() ? fibres_->state_size() * sizeof(float) : 0; }
    void save(const model::PadList&, char* states) override;
    // Throws Error::bad_input for a number that no press makes, in the states of so many pads.
    void need_possible(const char* states, size_t pads) const;
    void load(const model::PadList&, const char* states) override;

  private:
    void read_inputs(const model::PadList&);

    // The cells of one ending of each fibre of a kind: their places in `cells_`.
    struct Source {
        size_t kind, ending;
        bool stress;
        std::vector<uint32_t> cells;
    };
    PressedCells& pressed_;
    std::vector<model::FibreKind> kinds_;
    size_t planes_;                      // of a state: those of strains
    std::vector<model::HeldCell> cells_; // that any fibre feels, ascending
    std::vector<Source> sources_;
    std::vector<double> moduli_;                          // at which each pad's material comes to rest, Pa
    std::unique_ptr<model::FibrePopulation<f32>> fibres_; // null: there are none
    std::vector<float> read_;                             // of the states of all pads
    std::vector<float> state_;
    bool in_blocks_ = false;
    std::vector<Spike> spikes_;
};

} // namespace dermis
