// SPDX-License-Identifier: MIT
#pragma once

#include "host/core/vulkan/context.hpp"

namespace dermis::vulkan {

// Steps a few nerve fibres on the device and on the CPU path, once for each device. Throws Error::no_device where a bit
// differs, and Error::device.
void need_exact_fibres(const std::shared_ptr<Context>&);

} // namespace dermis::vulkan
