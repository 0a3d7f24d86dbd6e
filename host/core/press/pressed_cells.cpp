// SPDX-License-Identifier: MIT
#include "host/core/press/pressed_cells.hpp"

#include "host/core/base/refusal.hpp"
#include "host/core/cpu/stream.hpp"

#include <cstring>

namespace dermis {

void need_step(const double* refused) {
    if (refused)
        scene::refuse("dt", shortest(*refused), "seconds over which the coefficients of a step stay below 3.4e38");
}

// A device knows no stress that is followed: it gives the signals, and the host answers.
static std::unique_ptr<model::Stream> stream_of(const model::StreamedSkin& s, model::Backend& backend) {
    if (backend.threads() > 0 || !s.follows) return backend.stream(s);
    return cpu::deep_stream(s, backend.stream(signals_of(s)), 0);
}

PressedCells::PressedCells(const model::StreamedSkin& s, model::Backend& backend)
    : pads_(size_t(s.pads)), cells_(s.skin.cells()), fields_(s.sites().empty()), wanted_(s.wanted),
      layout_(state_layout_of(s)), counts_(model::response_counts(s)), read_(model::site_cells_of(s.skin).cells),
      felt_(s), stream_(stream_of(s, backend)) {}

void PressedCells::set_elements(const model::PadList& pads, const std::vector<model::Element>& elements) {
    stream_->set_elements(pads, elements);
    felt_.set_elements(pads, elements);
}

void PressedCells::save_cells(const model::PadList& pads, const model::StateMemory<char>& to) {
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

void PressedCells::read(const model::PadList& pads, States& to) {
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

const std::vector<float>& PressedCells::told(Quantity q, const float* rest_curvature) {
    std::vector<float>& all = told_[q == Quantity::strain ? 0 : q == Quantity::indentation ? 1 : 2];
    all.resize(pads_ * felt_.count());
    States states;
    read({.count = pads_}, states);
    for (size_t pad = 0; pad < pads_; ++pad)
        felt_.read(q, std::span(states.strains).subspan(pad * layout_.cells, layout_.cells), rest_curvature,
                   all.data() + pad * felt_.count());
    return all;
}

std::optional<Skin::Response> PressedCells::response(Quantity q) {
    if (!scene::is_receptor_class(q) || !wanted_[size_t(q)]) return {};
    const float* data = stream_->response(q); // throws if the device is lost
    return Skin::Response{data, pads_ * counts_[size_t(q) - QUANTITY_SA1]};
}

LastSteps::LastSteps(const model::StreamedSkin& skin)
    : parabolic_(skin.hold == Hold::parabolic), steps_(size_t(skin.pads)) {}

void LastSteps::reset(const model::PadList& pads) {
    for (size_t i = 0; i < pads.count; ++i) steps_[size_t(pads[i])] = 0;
}

void LastSteps::save(const model::PadList& pads, char* to) {
    for (size_t i = 0; i < pads.count; ++i) model::copy_state(to, &steps_[size_t(pads[i])], 1);
}

void LastSteps::load(const model::PadList& pads, const char* from) {
    for (size_t i = 0; i < pads.count; ++i) model::copy_state(from, &steps_[size_t(pads[i])], 1);
}

} // namespace dermis
