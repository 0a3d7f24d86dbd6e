// SPDX-License-Identifier: MIT
// The march of a run on a device.
#pragma once

#include "host/core/model/stream.hpp"
#include "host/core/vulkan/context.hpp"

namespace dermis::vulkan {

// Throws Error::bad_input if a value or size is beyond the device's limits, before anything is allocated.
std::unique_ptr<model::March> march(const model::MarchPlan&, std::shared_ptr<Context>);

} // namespace dermis::vulkan
