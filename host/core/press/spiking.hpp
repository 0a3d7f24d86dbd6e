// SPDX-License-Identifier: MIT
// The nerve fibres of a skin that is pressed frame by frame: their inputs from the skin's state, their presses, their
// spikes.
#pragma once

#include "host/core/base/float_environment.hpp"
#include "host/core/base/refusal.hpp"
#include "host/core/cpu/spreading.hpp"
#include "host/core/press/pressed_cells.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

namespace dermis {

class Spiking : public Stage {
  public:
    Spiking(const model::StreamedSkin& s, model::Backend& backend, PressedCells& pressed)
        : pressed_(pressed), planes_(s.skin.chain.elements() * (s.variant().compensated ? 2 : 1)) {
        if (s.afferents.empty()) return;
        std::ranges::transform(s.afferents, std::back_inserter(kinds_), model::kind_of);
        fibres_ = backend.fibres(kinds_, size_t(s.pads));
        const std::vector<size_t>& held = pressed.read();
        std::set<size_t> felt;
        for (const Afferents& a : s.afferents)
            for (const Cell& c : a.cells) felt.insert(s.skin.number_of(c));
        const std::vector<std::optional<size_t>> depths = take_depths(s, backend.threads());
        for (size_t cell = 0; spreading_ && cell < s.skin.cells(); ++cell)
            cells_.push_back({.held = cell, .cell = cell});
        for (const size_t cell : spreading_ ? std::set<size_t>() : felt) {
            const size_t among = size_t(std::ranges::lower_bound(held, cell) - held.begin());
            cells_.push_back({.held = held.empty() ? cell : among, .cell = cell});
        }
        for (size_t kind = 0; kind < kinds_.size(); ++kind)
            for (size_t ending = 0; ending < kinds_[kind].endings; ++ending) {
                const Afferents& a = s.afferents[kind];
                Source& source = sources_.emplace_back(Source{.kind = kind,
                                                              .ending = ending,
                                                              .stress = a.follow == Signal::stress,
                                                              .deep = depths[kind],
                                                              .cells = {}});
                for (size_t i = ending; i < a.cells.size(); i += kinds_[kind].endings)
                    source.cells.push_back(uint32_t(
                        std::ranges::lower_bound(cells_, s.skin.number_of(a.cells[i]), {}, &model::HeldCell::cell) -
                        cells_.begin()));
            }
        read_.resize(size_t(s.pads) * cells_.size() * (planes_ + 1));
        state_.resize(fibres_->state_size());
        if (s.skin.uniform()) moduli_ = moduli_at_rest(s);
        moduli_.resize(size_t(s.pads));
    }

    bool any() const { return fibres_ != nullptr; }
    void prepare(const model::PadList& pads, const model::StepLengths& dt, size_t presses) override {
        if (!any()) return;
        double longest = 0;
        size_t work = 0;
        for (size_t i = 0; i < (dt.each ? pads.count : 1); ++i) {
            if (!fibres_->prepare(dt[i]))
                scene::refuse("dt", shortest(dt[i]),
                              "at most 65536 refractory times or shortest time constants of the afferents, and "
                              "coefficients of their steps below 3.4e38");
            longest = std::max(longest, dt[i]);
            work += fibres_->work_of_pad() * (dt.each ? 1 : pads.count);
        }
        spikes_.reserve(fibres_->most_spikes(longest, presses));
        in_blocks_ = work > model::FibrePopulation<f32>::work_of_block;
    }
    bool in_blocks() const { return in_blocks_; } // the press that was prepared looks, between blocks of substeps
    // Takes what cells feel at the end of the step as inputs. The first frame forgets the spikes of the call before.
    // Calls look(); if that throws, the fibres' states are of no time, and spikes() has the spikes of the frames
    // before.
    void press(const model::PadList& pads, const model::StepLengths& dt, size_t frame, bool) override {
        if (!any()) return;
        if (frame == 0) spikes_.clear();
        fibres_->forget_spikes();
        read_inputs(pads);
        for (size_t i = 0, n; i < pads.count; i += n) { // neighbours with the same step at once
            for (n = 1; i + n < pads.count && pads[i + n] == pads[i] + int(n) && dt[i + n] == dt[i];) ++n;
            (void)fibres_->prepare(dt[i]); // true: it was asked before, and has made room
            fibres_->press(size_t(pads[i]), n);
        }
        for (const auto& s : fibres_->spikes())
            spikes_.push_back({.pad = s.pad, .afferent = s.fibre, .frame = int(frame), .share = s.share});
    }
    const std::vector<Spike>& spikes() const { return spikes_; }

    void reset(const model::PadList& pads) override {
        for (size_t i = 0; any() && i < pads.count; ++i) fibres_->reset(size_t(pads[i]));
    }
    void set_elements(const model::PadList& pads, const std::vector<model::Element>& elements) override {
        for (size_t i = 0; any() && i < pads.count; ++i) moduli_[size_t(pads[i])] = scene::modulus_at_rest(elements);
    }

    size_t state_bytes() const override { return any() ? fibres_->state_size() * sizeof(float) : 0; }
    void save(const model::PadList& pads, char* states) override {
        for (size_t i = 0; i < pads.count; ++i) {
            fibres_->save(size_t(pads[i]), state_.data());
            model::copy_state(states, state_.data(), state_.size());
        }
    }
    // Throws Error::bad_input for a number that no press makes, in the states of so many pads.
    void need_possible(const char* states, size_t pads) const {
        static constexpr const char* names[FIBRE_PLANES] = {"y",     "y'",    "y''", "V", "refractory time",
                                                            "after", "after", "q"};
        for (size_t pad = 0, fibre = 0; pad < pads; ++pad, fibre = 0)
            for (const model::FibreKind& k : kinds_)
                for (size_t end = fibre + k.count; fibre < end; ++fibre)
                    for (size_t n = 0; n < k.endings * FIBRE_PLANES; ++n, states += sizeof(float)) {
                        float x = 0;
                        std::memcpy(&x, states, sizeof x);
                        const size_t plane = n % FIBRE_PLANES;
                        const auto [least, greatest] = range_of(k.model, plane);
                        if (!(least <= double(x) && double(x) <= greatest))
                            scene::refuse("state",
                                          "(" + std::string(names[plane]) + " = " + shortest(double(x)) +
                                              " of afferent " + std::to_string(fibre) + ")",
                                          shortest(least) + " .. " + shortest(greatest));
                    }
    }
    void load(const model::PadList& pads, const char* states) override {
        for (size_t i = 0; i < pads.count; ++i) {
            model::copy_state(states, state_.data(), state_.size());
            fibres_->load(size_t(pads[i]), state_.data());
        }
    }

  private:
    static constexpr double greatest_input = 1e12; // of a fibre; a greater one counts as this

    // The range of a number of an ending's state, by its plane: presses make no number beyond it.
    static std::pair<double, double> range_of(const AfferentModel& m, size_t plane) {
        constexpr double most = 1e30, most_output = 1e24, rounding = 1 + 1e-5;
        if (plane == FIBRE_INPUT) return {-greatest_input, greatest_input};
        if (plane == FIBRE_MEMBRANE) return {-most, rounding};
        if (plane == FIBRE_REST) return {0, rounding * m.refractory_time};
        if (plane < FIBRE_MEMBRANE) {
            double fastest =
                m.frequency ? 7 * *m.frequency * std::max(1.0, 1 / *m.quality) : 0; // rate of the filter, 1/s
            for (const double time : m.time_constants) fastest = std::max(fastest, 1 / time);
            const double y = most_output * std::pow(fastest, double(plane));
            return {-y, y};
        }
        const double current = rounding * m.after[plane - FIBRE_AFTER0].amplitude;
        return {std::min(current, 0.0), std::max(current, 0.0)};
    }

    // Lists the depths of fibres. Returns the place of each entry's depth in `deep_`; none: at the surface.
    std::vector<std::optional<size_t>> take_depths(const model::StreamedSkin& s, int threads) {
        std::vector<cpu::Spreading<f32>::Class> classes;
        std::vector<std::optional<size_t>> places;
        const size_t cells = s.skin.cells() * size_t(s.pads);
        for (const Afferents& a : s.afferents) {
            std::optional<size_t>& place = places.emplace_back();
            const std::shared_ptr<const model::Spread>& spread = s.spread[size_t(a.type)];
            const bool stress = a.follow == Signal::stress;
            if (!spread) continue;
            for (size_t i = 0; i < deep_.size(); ++i)
                if (classes[i].spread == spread && deep_[i].stress == stress) place = i;
            if (place) continue;
            place = deep_.size();
            classes.push_back({QUANTITY_SA1, spread});
            deep_.push_back({.stress = stress, .map = std::vector<float>(cells)});
            (stress ? stress_ : strain_).resize(cells);
        }
        for (Deep& d : deep_) from_.push_back((d.stress ? stress_ : strain_).data()), to_.push_back(d.map.data());
        if (deep_.empty()) return places;
        spreading_.emplace(s.skin, classes, size_t(s.skin.width()), size_t(s.pads), false, threads, simd::best());
        return places;
    }
    // The inputs of these pads: of the strain as a state holds it, or of the pressure of the last press.
    void read_inputs(const model::PadList& pads) {
        const DefaultFloats guard;
        const size_t n = cells_.size();
        pressed_.stream().read(pads, cells_, planes_, read_.data());
        if (spreading_) spread(pads);
        const float* planes = read_.data();
        for (size_t p = 0; p < pads.count; ++p, planes += n * (planes_ + 1)) {
            const size_t pad = size_t(pads[p]);
            const float* const pressure = planes + n * planes_;
            const float modulus = float(moduli_[pad]);
            for (const Source& s : sources_) {
                float* to = fibres_->inputs(pad, s.kind, s.ending);
                const double* factor = kinds_[s.kind].factors.data();
                for (const uint32_t i : s.cells) {
                    const float q =
                        s.deep     ? deep_[*s.deep].map[pad * n + i]
                        : s.stress ? pressure[i] / modulus
                                   : pressed_.felt().strain_at(pads[p], cells_[i].held, planes + i, n, pressure[i]);
                    *to++ = std::clamp(float(*factor++) * q, -float(greatest_input), float(greatest_input));
                }
            }
        }
    }
    // Makes `deep_` of the states that were read.
    void spread(const model::PadList& pads) {
        const size_t n = cells_.size();
        const float* planes = read_.data();
        for (size_t p = 0; p < pads.count; ++p, planes += n * (planes_ + 1)) {
            const size_t pad = size_t(pads[p]);
            const float* const pressure = planes + n * planes_;
            const float modulus = float(moduli_[pad]);
            if (!strain_.empty()) pressed_.felt().strain(pads[p], planes, pressure, strain_.data() + pad * n);
            for (size_t i = 0; !stress_.empty() && i < n; ++i) stress_[pad * n + i] = f32::flush(pressure[i] / modulus);
        }
        spreading_->spread(pads, from_.data(), to_.data(), nullptr);
    }

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
