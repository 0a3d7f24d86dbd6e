// SPDX-License-Identifier: MIT
// The model `march` on a device.
#pragma once

#include "host/core/press/device.hpp"
#include "host/lab/march/stepper.hpp"

namespace dermis {

// Skin and schedule must outlive the stepper. Throws Error::bad_input if a value or size is beyond the backend's
// limits, and Error::no_device if the bits of a march differ and the device was not named: the first march of a variant
// tests it.
std::unique_ptr<model::Stepper> march(const Device&, const model::PreparedSkin&, const model::Schedule&, Precision,
                                      model::Stepper::Sink);

namespace model {

// The same on a backend, without a test of its bits.
std::unique_ptr<Stepper> march(Backend&, const PreparedSkin&, const Schedule&, Precision, Stepper::Sink);

// The march of a skin whose receptors lie at depths that spread.
std::unique_ptr<March> deep_march(Backend&, const MarchPlan&, const HalfSpaces&);

} // namespace model

} // namespace dermis
