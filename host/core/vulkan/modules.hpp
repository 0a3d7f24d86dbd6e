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
    uint32_t bindings, constants_bytes; // buffers 0 .. bindings - 1; of the push constants
    uint32_t texels = 0; // a bit for each binding that is a texel buffer of four cells each; others are storage buffers
};

// texels: the same kernel, which reads its maps as texel buffers.
Module press_module(bool texels);
Module press_signals_module(bool texels); // for receptors at depths
Module press_sites_module(bool texels);   // for sites
Module reduce_module(bool texels);
Module halve_module(bool texels);
Module spread_module(bool texels);
Module fibres_module();

// The rules of floats that a device offers and kernels declare. Without the second a compiler may make a NaN a number.
struct FloatRules {
    bool rounds_to_even = false; // shaderRoundingModeRTEFloat32
    bool keeps_nans = false;     // shaderSignedZeroInfNanPreserveFloat32
};

// The words of a module that also declares these rules.
std::vector<uint32_t> declare(const FloatRules& rules, const Module& module);

} // namespace dermis::vulkan
