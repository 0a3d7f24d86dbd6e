// SPDX-License-Identifier: MIT
#pragma once

#include "host/plan/stepper.hpp"
#include "host/vulkan/context.hpp"

namespace dermis::vulkan {

// f32 on a Vulkan device. Throws Error::bad_input where the grid does not fit the device, naming the limit.
// `plan` outlives the stepper.
std::unique_ptr<plan::Stepper> march(const plan::Plan& plan, std::shared_ptr<Context>, plan::Stepper::Sink);

} // namespace dermis::vulkan
