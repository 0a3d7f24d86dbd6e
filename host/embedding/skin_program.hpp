// SPDX-License-Identifier: MIT
#pragma once

#include "dermis/vulkan.hpp"
#include "host/plan/streamed_skin.hpp"

namespace dermis::vulkan {

// Makes a SkinProgram of a skin that is prepared already.
SkinProgram program_of(const Handles&, const plan::StreamedSkin&, uint32_t max_bindings);
// Gives pads of a program other elements, which have been checked.
void set_elements(SkinProgram&, const plan::PadList&, const std::vector<plan::Element>&);

} // namespace dermis::vulkan
