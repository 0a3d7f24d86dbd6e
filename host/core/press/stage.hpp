// SPDX-License-Identifier: MIT
// A press of a skin is stages in a row: tractions, pressed cells, nerve fibres, last steps. All stages prepare before
// the first one steps, so that a press that is refused, or that runs out of memory, changes nothing.
#pragma once

#include "host/core/model/streamed_skin.hpp"

namespace dermis {

class Stage {
  public:
    virtual ~Stage() = default;
    // Does all of so many presses of these pads that can fail. Changes no state. Throws Error::bad_input for a step
    // that the stage cannot take.
    virtual void prepare(const model::PadList&, const model::StepLengths&, size_t /*presses*/) {}
    // Steps pads by steps that were prepared; it refuses and allocates nothing. frame: counts the presses of a call.
    // last: responses are read after it.
    virtual void press(const model::PadList&, const model::StepLengths&, size_t frame, bool last) = 0;
    // Whether a press of numbers that are all 0 leaves a pad as it is.
    virtual bool rests(int /*pad*/) const { return true; }
    virtual void reset(const model::PadList&) = 0; // back to skins at rest
    // Gives pads other elements in series, all of them the same.
    virtual void set_elements(const model::PadList&, const std::vector<model::Element>&) {}
    // The stage's part of a saved state: the bytes of a pad, 0 if it has none; copied to and from any address.
    virtual size_t state_bytes() const { return 0; }
    virtual void save(const model::PadList&, char* /*to*/) {}
    virtual void load(const model::PadList&, const char* /*from*/) {}
};

// The last step of each pad, s; 0: none, or not known. It is saved only under parabolic hold.
class LastSteps : public Stage {
  public:
    explicit LastSteps(const model::StreamedSkin& skin)
        : parabolic_(skin.hold == Hold::parabolic), steps_(size_t(skin.pads)) {}
    model::StepLengths of(const double* dt, bool each) {
        return {.dt = dt, .each = each, .before = steps_.data(), .parabolic = parabolic_};
    }
    // The last step of a pad if it tells the frequency of its frames, else 0.
    double frame_of(int pad) const { return parabolic_ ? 0 : steps_[size_t(pad)]; }
    void press(const model::PadList& pads, const model::StepLengths& dt, size_t = 0, bool = true) override {
        dt.taken(pads);
    }
    void reset(const model::PadList& pads) override {
        for (size_t i = 0; i < pads.count; ++i) steps_[size_t(pads[i])] = 0;
    }
    size_t state_bytes() const override { return parabolic_ ? sizeof(double) : 0; }
    void save(const model::PadList& pads, char* to) override {
        for (size_t i = 0; i < pads.count; ++i) model::copy_state(to, &steps_[size_t(pads[i])], 1);
    }
    void load(const model::PadList& pads, const char* from) override {
        for (size_t i = 0; i < pads.count; ++i) model::copy_state(from, &steps_[size_t(pads[i])], 1);
    }

  private:
    const bool parabolic_; // under parabolic hold
    std::vector<double> steps_;
};

} // namespace dermis
