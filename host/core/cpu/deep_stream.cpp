// SPDX-License-Identifier: MIT
#include "host/core/cpu/spreading.hpp"
#include "host/core/cpu/stream.hpp"

namespace dermis::cpu {
namespace {

// A skin whose receptors lie at depths: another stream presses it and answers by the signals, which are spread here.
class DeepStream : public model::Stream {
  public:
    DeepStream(const model::StreamedSkin& s, std::unique_ptr<model::Stream> signals, int threads, const simd::Isa& isa)
        : signals_(std::move(signals)), gained_(s.skin.constants.curvature_length != 0),
          spreading_(s.skin, classes_of(s), size_t(s.skin.width()), size_t(s.pads), gained_, threads, isa) {
        for (const auto& c : spreading_.classes()) {
            std::vector<float>& map = response_[size_t(c.quantity) - QUANTITY_SA1];
            map = simd::map_of(s.skin.cells() * size_t(s.pads), 0.0f);
            to_.push_back(map.data());
        }
        from_.resize(to_.size());
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
    const float* response(Quantity q) override { return response_[size_t(q) - QUANTITY_SA1].data(); }
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
    }

  private:
    static std::vector<Spreading<f32>::Class> classes_of(const model::StreamedSkin& s) {
        std::vector<Spreading<f32>::Class> classes;
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            if (s.wanted[size_t(q)]) classes.push_back({q, s.spread[size_t(q)]});
        return classes;
    }

    void answer(const model::PadList& pads) {
        for (size_t i = 0; i < from_.size(); ++i)
            from_[i] = signals_->response(Quantity(spreading_.classes()[i].quantity));
        spreading_.spread(pads, from_.data(), to_.data(), gained_ ? signals_->response(Quantity::sa1) : nullptr);
    }

    std::unique_ptr<model::Stream> signals_;
    const bool gained_; // by the curvature
    Spreading<f32> spreading_;
    std::array<std::vector<float>, RESPONSE_MAPS> response_; // fields
    std::vector<const float*> from_;
    std::vector<float*> to_;
};

} // namespace

std::unique_ptr<model::Stream> deep_stream(const model::StreamedSkin& s, int threads, const simd::Isa& isa) {
    return std::make_unique<DeepStream>(s, stream(signals_of(s), threads, isa), threads, isa);
}

} // namespace dermis::cpu
