// SPDX-License-Identifier: MIT
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/model/streamed_skin.hpp"
#include "host/core/vulkan/recording.hpp"

namespace dermis::vulkan {

// Makes a SkinProgram for a prepared skin, with the pipelines of a context. It has no check.
SkinProgram program_of(Context&, const model::StreamedSkin&, uint32_t max_bindings);
// Records a press into the library's own command buffer, which is submitted whenever DeviceTable::most_work is reached.
Recorded record_press(const SkinProgram&, Recording&, Binding, const model::PadList&, const model::StepLengths&,
                      bool answers);
// The most work (see DeviceTable::most_work) of a press of one pad.
double work_of_press(const SkinProgram&);
// Gives pads of a program other elements, which have been checked.
void set_elements(SkinProgram&, const model::PadList&, const std::vector<model::Element>&);

} // namespace dermis::vulkan
