// SPDX-License-Identifier: MIT
// The stage that strains the cells of pads by their pressures: the backend's stream, and what is read from its states.
#pragma once

#include "host/core/base/refusal.hpp"
#include "host/core/cpu/stream.hpp"
#include "host/core/model/felt.hpp"
#include "host/core/model/stream.hpp"
#include "host/core/press/stage.hpp"

#include <cstring>

namespace dermis {

// Throws Error::bad_input for a step whose coefficients do not fit a float; null: there is none.
inline void need_step(const double* refused) {
    if (refused)
        scene::refuse("dt", shortest(*refused), "seconds over which the coefficients of a step stay below 3.4e38");
}

class PressedCells : public Stage {
  public:
    PressedCells(const model::StreamedSkin& s, model::Backend& backend)
        : pads_(size_t(s.pads)), cells_(s.skin.cells()), fields_(s.sites().empty()), wanted_(s.wanted),
          layout_(state_layout_of(s)), counts_(model::response_counts(s)), read_(model::site_cells_of(s.skin).cells),
          felt_(s), stream_(stream_of(s, backend)) {}

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
    void set_elements(const model::PadList& pads, const std::vector<model::Element>& elements) override {
        stream_->set_elements(pads, elements);
        felt_.set_elements(pads, elements);
    }
    // Copies strains and pressures. Pressures of cells that no site reads become 0, so that equal skins have equal
    // states, whatever pressed them.
    void save_cells(const model::PadList& pads, const model::StateMemory<char>& to) {
        stream_->save(pads, to);
        for (size_t i = 0; !read_.empty() && i < pads.count; ++i) {
            char* const pressure = to.pressure_of(i);
            size_t next = 0;
            const auto clear_until = [&](size_t cell) {
                std::memset(pressure + next * sizeof(float), 0, (cell - next) * sizeof(float));
                next = cell + 1;
            };
            for (const size_t cell : read_) clear_until(cell);
            clear_until(cells_);
        }
    }

    // What states of pads hold, pad by pad: the planes, the pressure of each cell, and the strain of each held cell.
    struct States {
        std::vector<float> planes, pressures, strains;
    };
    // Allocates nothing where as many pads have been read into these before.
    void read(const model::PadList& pads, States& to) {
        const size_t of_state = layout_.cells * layout_.planes;
        to.planes.resize(pads.count * of_state);
        to.pressures.resize(pads.count * cells_);
        to.strains.resize(pads.count * layout_.cells);
        stream_->save(pads, {.strains = reinterpret_cast<char*>(to.planes.data()),
                             .pressure = reinterpret_cast<char*>(to.pressures.data()),
                             .strains_step = of_state * sizeof(float),
                             .pressure_step = cells_ * sizeof(float)});
        for (size_t i = 0; i < pads.count; ++i)
            felt_.strain(pads[i], to.planes.data() + i * of_state, to.pressures.data() + i * cells_,
                         to.strains.data() + i * layout_.cells);
    }
    // Strain, indentation or curvature of all pads; the same memory until the next call. rest_curvature: of each cell,
    // where a state holds all cells.
    const std::vector<float>& told(Quantity q, const float* rest_curvature) {
        std::vector<float>& all = told_[q == Quantity::strain ? 0 : q == Quantity::indentation ? 1 : 2];
        all.resize(pads_ * felt_.count());
        States states;
        read({.count = pads_}, states);
        for (size_t pad = 0; pad < pads_; ++pad)
            felt_.read(q, std::span(states.strains).subspan(pad * layout_.cells, layout_.cells), rest_curvature,
                       all.data() + pad * felt_.count());
        return all;
    }
    // A response of the last press: count() numbers of all pads; nothing if the skin does not have it.
    std::optional<Skin::Response> response(Quantity q) {
        if (!scene::is_receptor_class(q) || !wanted_[size_t(q)]) return {};
        const float* data = stream_->response(q); // throws if the device is lost
        return Skin::Response{data, pads_ * counts_[size_t(q) - QUANTITY_SA1]};
    }

  private:
    // A device knows no stress that is followed: it gives the signals, and the host answers.
    static std::unique_ptr<model::Stream> stream_of(const model::StreamedSkin& s, model::Backend& backend) {
        if (backend.threads() > 0 || !s.follows) return backend.stream(s);
        return cpu::deep_stream(s, backend.stream(signals_of(s)), 0);
    }

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
