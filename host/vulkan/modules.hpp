// SPDX-License-Identifier: MIT
// The kernels as SPIR-V.
#pragma once

#include <cstddef>
#include <cstdint>

namespace dermis::vulkan {

struct Module {
    const uint32_t* code;
    size_t bytes;
};

// `rounds`: declared to round to nearest even, which a device must offer (shaderRoundingModeRTEFloat32).
Module press_module(bool rounds);
Module fields_module(bool rounds);
Module reduce_module(bool rounds);
Module sites_module(bool rounds);

} // namespace dermis::vulkan
