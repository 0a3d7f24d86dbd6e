// SPDX-License-Identifier: MIT
#include "host/core/base/float_environment.hpp"
#include "host/core/cpu/spreading.hpp"
#include "host/core/cpu/stream.hpp"

namespace dermis::cpu {
namespace {

// A skin whose receptors lie at depths, or follow the stress: another stream presses it and answers by the signals,
// which are spread here.
class DeepStream : public model::Stream {
  public:
    DeepStream(const model::StreamedSkin& s, std::unique_ptr<model::Stream> signals, int threads, const simd::Isa& isa)
        : signals_(std::move(signals)), gained_(s.skin.constants.curvature_length != 0), cells_(s.skin.cells()),
          spreading_(s.skin, classes_of(s), size_t(s.skin.width()), size_t(s.pads), gained_, threads, isa) {
        for (const auto& c : spreading_.classes()) {
            const size_t r = size_t(c.quantity) - QUANTITY_SA1;
            fields_[r] = simd::map_of(cells_ * size_t(s.pads), 0.0f);
            to_.push_back(fields_[r].data());
        }
        from_.resize(to_.size());
        for (const Site& site : s.picked) {
            const size_t r = size_t(site.type) - QUANTITY_SA1;
            sites_[r].push_back(s.skin.number_of(site.cell));
            picked_[r].resize(picked_[r].size() + size_t(s.pads));
        }
        if (!s.follows) return;
        signals_->reserve_states(); // which read() needs
        moduli_ = moduli_at_rest(s);
        stress_ = simd::map_of(cells_ * size_t(s.pads), 0.0f);
        pressure_.resize(stress_.size());
        for (size_t i = 0; i < cells_; ++i) all_.push_back({i, i});
    }

    bool take(const model::PadList& pads, const float* pressures, bool by_number) override {
        return signals_->take(pads, pressures, by_number);
    }
    bool rests(int pad) const override { return signals_->rests(pad); }
    const double* prepare(const model::PadList& pads, const model::StepLengths& dt) override {
        return signals_->prepare(pads, dt);
    }
    void press(const model::PadList& pads, const model::StepLengths& dt, bool answers) override {
        signals_->press(pads, dt, answers);
        if (answers) answer(pads);
    }
    bool copy(const float* numbers, size_t count, float* to) override { return signals_->copy(numbers, count, to); }
    bool joins_frames() const override { return signals_->joins_frames(); }
    void press_frames(const model::PadList& pads, const float* frames, size_t count, size_t numbers,
                      const model::StepLengths& dt) override {
        signals_->press_frames(pads, frames, count, numbers, dt);
        answer(pads);
    }
    const float* response(Quantity q) override {
        const size_t r = size_t(q) - QUANTITY_SA1;
        return (sites_[r].empty() ? fields_[r] : picked_[r]).data();
    }
    void reset(const model::PadList& pads) override {
        signals_->reset(pads);
        answer(pads); // of signals that are 0
    }
    void save(const model::PadList& pads, const model::StateMemory<char>& to) override { signals_->save(pads, to); }
    void load(const model::PadList& pads, const model::StateMemory<const char>& from) override {
        signals_->load(pads, from);
    }
    void read(const model::PadList& pads, const std::vector<model::HeldCell>& cells, size_t planes,
              float* to) override {
        signals_->read(pads, cells, planes, to);
    }
    void reserve_states() override { signals_->reserve_states(); }
    void set_elements(const model::PadList& pads, const std::vector<model::Element>& elements) override {
        signals_->set_elements(pads, elements);
        for (size_t i = 0; !moduli_.empty() && i < pads.count; ++i)
            moduli_[size_t(pads[i])] = scene::modulus_at_rest(elements);
    }

  private:
    static std::vector<Spreading<f32>::Class> classes_of(const model::StreamedSkin& s) {
        std::vector<Spreading<f32>::Class> classes;
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            if (s.wanted[size_t(q)]) classes.push_back({q, s.spread[size_t(q)]});
        return classes;
    }

    // The pressure of these pads over the modulus.
    void make_stress(const model::PadList& pads) {
        const DefaultFloats guard;
        signals_->read(pads, all_, 0, pressure_.data());
        for (size_t i = 0; i < pads.count; ++i) {
            const float* const pressure = pressure_.data() + i * cells_;
            const float modulus = float(moduli_[size_t(pads[i])]);
            float* const stress = stress_.data() + size_t(pads[i]) * cells_;
            for (size_t k = 0; k < cells_; ++k) stress[k] = f32::flush(pressure[k] / modulus);
        }
    }

    void answer(const model::PadList& pads) {
        if (!stress_.empty()) make_stress(pads);
        for (size_t i = 0; i < from_.size(); ++i) {
            const auto q = Quantity(spreading_.classes()[i].quantity);
            from_[i] = q == Quantity::sa1 && !stress_.empty() ? stress_.data() : signals_->response(q);
        }
        spreading_.spread(pads, from_.data(), to_.data(), gained_ ? signals_->response(Quantity::sa1) : nullptr);
        for (size_t r = 0; r < RESPONSE_MAPS; ++r)
            for (size_t i = 0; !sites_[r].empty() && i < pads.count; ++i) {
                const float* const field = fields_[r].data() + size_t(pads[i]) * cells_;
                float* const to = picked_[r].data() + size_t(pads[i]) * sites_[r].size();
                std::ranges::transform(sites_[r], to, [field](size_t cell) { return field[cell]; });
            }
    }

    std::unique_ptr<model::Stream> signals_;
    const bool gained_; // by the curvature
    const size_t cells_;
    Spreading<f32> spreading_;
    std::array<std::vector<float>, RESPONSE_MAPS> fields_, picked_; // of the sites: empty without them
    std::array<std::vector<size_t>, RESPONSE_MAPS> sites_;          // the cells of the sites of each class
    std::vector<const float*> from_;
    std::vector<float*> to_;
    // Where SA1 follows the stress: of each pad its modulus at rest, and its stress over that; else empty.
    std::vector<double> moduli_;
    std::vector<float> stress_, pressure_;
    std::vector<model::HeldCell> all_; // every cell
};

} // namespace

std::unique_ptr<model::Stream> deep_stream(const model::StreamedSkin& s, std::unique_ptr<model::Stream> signals,
                                           int threads, const simd::Isa& isa) {
    return std::make_unique<DeepStream>(s, std::move(signals), threads, isa);
}

} // namespace dermis::cpu
