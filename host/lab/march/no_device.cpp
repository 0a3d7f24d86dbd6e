// SPDX-License-Identifier: MIT
// A build with -DDERMIS_VULKAN=OFF, where no device marches.
#include "host/lab/march/march.hpp"

namespace dermis::vulkan {

std::unique_ptr<model::March> march(const model::MarchPlan&, const model::Backend&) { return nullptr; }
bool exact(model::Backend&, const model::Variant&) { return true; }

} // namespace dermis::vulkan
