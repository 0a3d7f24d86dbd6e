// SPDX-License-Identifier: MIT
// The nerve fibres of a skin that is pressed frame by frame: their inputs from the skin's state, their presses, their
// spikes.
#pragma once

#include "host/core/cpu/spreading.hpp"
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
    std::vector<std::optional<size_t>> take_depths(const model::StreamedSkin&, int threads);
    void read_inputs(const model::PadList&);
    void spread(const model::PadList&);

    // The cells of one ending of each fibre of a kind: their places in `cells_`.
    struct Source {
        size_t kind, ending;
        bool stress;
        std::optional<size_t> deep; // the place of their depth in `deep_`
        std::vector<uint32_t> cells;
    };
    // A depth of fibres, and what acts on them there: the strain, or the stress over the modulus.
    struct Deep {
        bool stress;
        std::vector<float> map; // of all cells of all pads
    };
    PressedCells& pressed_;
    std::vector<model::FibreKind> kinds_;
    size_t planes_;                      // of a state: those of strains
    std::vector<model::HeldCell> cells_; // that any fibre feels, ascending; of fibres at depths all cells
    std::vector<Source> sources_;
    std::vector<Deep> deep_;             // each depth once, the stress apart from the strain
    std::vector<float> strain_, stress_; // what is spread to them, of all cells of all pads
    std::vector<const float*> from_;
    std::vector<float*> to_;
    std::optional<cpu::Spreading<f32>> spreading_;        // from_ to to_, a class for each of `deep_`
    std::vector<double> moduli_;                          // at which each pad's material comes to rest, Pa
    std::unique_ptr<model::FibrePopulation<f32>> fibres_; // null: there are none
    std::vector<float> read_;                             // of the states of all pads
    std::vector<float> state_;
    bool in_blocks_ = false;
    std::vector<Spike> spikes_;
};

} // namespace dermis
