// SPDX-License-Identifier: MIT
// The kernels' SPIR-V modules.
#pragma once

#include <cstddef>
#include <cstdint>

namespace dermis::vulkan {

struct Module {
    const uint32_t* code;
    size_t bytes;
    uint32_t texels = 0; // a bit for each binding that is a texel buffer of four cells each; others are storage buffers
};

// rounds: the module declares round-to-nearest-even, which the device must offer (shaderRoundingModeRTEFloat32).
Module press_module(bool rounds);
Module fields_module(bool rounds);
Module reduce_module(bool rounds);
Module sites_module(bool rounds);
Module fibres_module(bool rounds);
// The same kernels, which read their maps as texel buffers.
Module press_texels_module(bool rounds);
Module reduce_texels_module(bool rounds);

} // namespace dermis::vulkan
