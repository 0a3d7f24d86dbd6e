// SPDX-License-Identifier: MIT
// The model `march`: all cells of a skin take the steps of a run, on the CPU path or on a device.
#pragma once

#include "host/core/press/device.hpp"
#include "host/lab/march/stepper.hpp"

namespace dermis {

namespace model {

// The skin, load and outputs of a march. Its references outlive the march.
struct MarchPlan {
    const PreparedSkin& skin;
    Variant variant;
    Precision precision = Precision::f32;
    PressedBox pressed;
    const std::vector<double>& pressure; // Pa, width*height: the map that steps scale; unused if framed
    const std::vector<Cell>& points;
    bool keeps_maps = false; // maps() is asked for responses
};

// One skin, stepped by a run.
class March {
  public:
    virtual ~March() = default;
    // Framed: from the next step on the pressure runs to this map (width*height, Pa) from the previous one, at first
    // from 0.
    virtual void frame(const std::vector<double>& pressure) = 0;
    // Takes a step at once, or later together with others. Returns whether no step waits any more. Step and sample are
    // the caller's until settle(), which fills the sample; null: not asked for.
    virtual bool press(const Step&, Sample*) = 0;
    // Takes all steps that wait, and fills their samples. Returns the bits simd::strain_changed and
    // simd::integral_changed of the last step; all bits if they are not known.
    virtual int settle() = 0;
    // Returns the strain and responses at the end of the last step, maps whose rows are a pitch apart, of floats or, in
    // f64, of doubles. They last until the next step or call.
    virtual std::vector<const void*> maps(const std::vector<Quantity>&) = 0;
    virtual long long dispatches() const { return 0; }
};

// The constants of a step. skin: those of every step; k: the step's first coefficients.
template <class K>
typename K::Constants constants_of(const typename K::Constants& skin, const typename K::Coefficients* k,
                                   const Step& step) {
    const auto r = [](double x) { return static_cast<typename K::scalar>(x); };
    typename K::Constants c = skin;
    if (k) c.coefficients = *k;
    c.start = r(step.constant_start());
    c.rise = r(step.constant_rise());
    c.jump = r(step.jump);
    c.respond = step.respond();
    return c;
}

} // namespace model

// Skin and schedule must outlive the stepper. Throws Error::bad_input if a value or size is beyond the backend's
// limits, and Error::no_device if the bits of a march differ and the device was not named: the first march of a variant
// tests it.
std::unique_ptr<model::Stepper> march(const Device&, const model::PreparedSkin&, const model::Schedule&, Precision,
                                      model::Stepper::Sink);

namespace model {

// The same on a backend, without a test of its bits.
std::unique_ptr<Stepper> march(Backend&, const PreparedSkin&, const Schedule&, Precision, Stepper::Sink);
std::unique_ptr<March> march(Backend&, const MarchPlan&);

// The march of a skin whose receptors lie at depths that spread.
std::unique_ptr<March> deep_march(Backend&, const MarchPlan&, const HalfSpaces&);

} // namespace model

namespace cpu {
std::unique_ptr<model::March> march(const model::MarchPlan&, int threads, const simd::Isa&);
}

namespace vulkan {
// Throws Error::bad_input if a value or size is beyond the device's limits, before anything is allocated.
std::unique_ptr<model::March> march(const model::MarchPlan&, const model::Backend&);
// Returns whether marches of this variant have the CPU path's bits. The first call for a variant tests it.
bool exact(model::Backend&, const model::Variant&);
} // namespace vulkan

} // namespace dermis
