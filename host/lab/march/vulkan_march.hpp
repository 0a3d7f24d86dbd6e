// SPDX-License-Identifier: MIT
// The model `march` on a Vulkan device, in f32.
#pragma once

#include "host/core/vulkan/context.hpp"
#include "host/lab/march/stepper.hpp"

namespace dermis::vulkan {

// Throws Error::bad_input where the grid does not fit the device, naming the limit. Skin and schedule outlive the
// stepper.
std::unique_ptr<plan::Stepper> stepper(const plan::PreparedSkin&, const plan::Schedule&, Precision,
                                       std::shared_ptr<Context>, plan::Stepper::Sink);

} // namespace dermis::vulkan
