// SPDX-License-Identifier: MIT
// The model `march` on a device.
#pragma once

#include "host/core/press/device.hpp"
#include "host/core/simd/isa.hpp"
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

} // namespace model

namespace cpu {

// threads: 0 = one per core. Skin and schedule outlive the stepper.
std::unique_ptr<model::Stepper> stepper(const model::PreparedSkin&, const model::Schedule&, Precision, int threads,
                                        model::Stepper::Sink, const simd::Isa& isa = simd::best());

} // namespace cpu

namespace vulkan {

class Context;
// In f32. Throws Error::bad_input where the grid does not fit the device, naming the limit. Skin and schedule outlive
// the stepper.
std::unique_ptr<model::Stepper> stepper(const model::PreparedSkin&, const model::Schedule&, Precision,
                                        std::shared_ptr<Context>, model::Stepper::Sink);

} // namespace vulkan
} // namespace dermis
