// SPDX-License-Identifier: MIT
// The stage that strains the cells of pads by their pressures: the backend's stream, and what is read from its states.
#pragma once

#include "host/core/model/felt.hpp"
#include "host/core/model/stream.hpp"
#include "host/core/press/stage.hpp"

namespace dermis {

// Throws Error::bad_input for a step whose coefficients do not fit a float; null: there is none.
void need_step(const double* refused);

class PressedCells : public Stage {
  public:
    PressedCells(const model::StreamedSkin&, model::Backend&);

    model::Stream& stream() { return *stream_; }
    size_t count() const { return cells_; } // of a pad
    bool fields() const { return fields_; } // whether every cell responds
    // The cells that a state holds, which sites read; empty: it holds all cells.
    const std::vector<size_t>& read() const { return read_; }
    model::Felt& felt() { return felt_; }

    void prepare(const model::PadList& pads, const model::StepLengths& dt, size_t) override {
        need_step(stream_->prepare(pads, dt));
    }
    void press(const model::PadList& pads, const model::StepLengths& dt, size_t, bool last) override {
        stream_->press(pads, dt, last);
    }
    bool rests(int pad) const override { return stream_->rests(pad); }
    void reset(const model::PadList& pads) override { stream_->reset(pads); }
    void set_elements(const model::PadList&, const std::vector<model::Element>&) override;
    // Copies strains and pressures. Pressures of cells that no site reads become 0, so that equal skins have equal
    // states, whatever pressed them.
    void save_cells(const model::PadList&, const model::StateMemory<char>&);

    // What states of pads hold, pad by pad: the planes, the pressure of each cell, and the strain of each held cell.
    struct States {
        std::vector<float> planes, pressures, strains;
    };
    // Allocates nothing where as many pads have been read into these before.
    void read(const model::PadList&, States&);
    // Strain, indentation or curvature of all pads; the same memory until the next call. rest_curvature: of each cell,
    // where a state holds all cells.
    const std::vector<float>& told(Quantity, const float* rest_curvature);
    // A response of the last press: count() numbers of all pads; nothing if the skin does not have it.
    std::optional<Skin::Response> response(Quantity);

  private:
    const size_t pads_, cells_;
    const bool fields_;
    const model::Wanted wanted_;
    const model::StateLayout layout_;
    const std::array<size_t, RESPONSE_MAPS> counts_; // of each response, in a pad
    std::vector<size_t> read_;
    model::Felt felt_;
    std::unique_ptr<model::Stream> stream_;
    std::array<std::vector<float>, 3> told_; // strain, indentation and curvature, once they are asked for
};

} // namespace dermis
