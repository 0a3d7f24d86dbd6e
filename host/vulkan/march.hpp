// SPDX-License-Identifier: MIT
#pragma once

#include "host/plan/marcher.hpp"
#include "host/vulkan/context.hpp"

namespace dermis::vulkan {

// f32 on a Vulkan device. Throws Error::bad_input where the grid does not fit the device, naming the limit.
// `plan` outlives the marcher.
std::unique_ptr<plan::Marcher> march(const plan::Plan& plan, std::shared_ptr<Context>, plan::Marcher::Sink);

} // namespace dermis::vulkan
