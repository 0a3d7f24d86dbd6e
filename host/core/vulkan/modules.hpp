// SPDX-License-Identifier: MIT
// The kernels' SPIR-V modules.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace dermis::vulkan {

struct Module {
    const uint32_t* code;
    size_t bytes;
    uint32_t texels = 0; // a bit for each binding that is a texel buffer of four cells each; others are storage buffers
};

Module press_module();
Module reduce_module();
Module press_signals_module(); // for receptors at depths
Module press_sites_module();   // for sites
Module halve_module();
Module spread_module();
Module fibres_module();
// The same kernels, which read their maps as texel buffers.
Module press_texels_module();
Module reduce_texels_module();
Module press_signals_texels_module();
Module press_sites_texels_module();
Module halve_texels_module();
Module spread_texels_module();

// The words of a module that also declares round-to-nearest-even, for devices that offer this
// (shaderRoundingModeRTEFloat32).
std::vector<uint32_t> declare_rounding(const Module& module);

} // namespace dermis::vulkan
