// SPDX-License-Identifier: MIT
#include "host/core/vulkan/modules.hpp"

#include "host/core/simd/model.hpp"

#include "fibres_spv.h"
#include "halve_spv.h"
#include "halve_texels_spv.h"
#include "press_signals_spv.h"
#include "press_signals_texels_spv.h"
#include "press_sites_spv.h"
#include "press_sites_texels_spv.h"
#include "press_spv.h"
#include "press_texels_spv.h"
#include "reduce_spv.h"
#include "reduce_texels_spv.h"
#include "spread_spv.h"
#include "spread_texels_spv.h"

#include <span>
#include <utility>

namespace dermis::vulkan {

Module press_module() { return {.code = press_spv, .bytes = sizeof press_spv}; }
Module reduce_module() { return {.code = reduce_spv, .bytes = sizeof reduce_spv}; }
Module halve_module() { return {.code = halve_spv, .bytes = sizeof halve_spv}; }
Module spread_module() { return {.code = spread_spv, .bytes = sizeof spread_spv}; }
Module fibres_module() { return {.code = fibres_spv, .bytes = sizeof fibres_spv}; }

constexpr uint32_t press_texels =
    1u << PRESS_PRESSURE_FROM | 1u << PRESS_PRESSURE_TO | 1u << PRESS_REST_CURVATURE | 1u << PRESS_STATE_FROM;
Module press_texels_module() {
    return {.code = press_texels_spv, .bytes = sizeof press_texels_spv, .texels = press_texels};
}
Module press_signals_module() { return {.code = press_signals_spv, .bytes = sizeof press_signals_spv}; }
Module press_signals_texels_module() {
    return {.code = press_signals_texels_spv, .bytes = sizeof press_signals_texels_spv, .texels = press_texels};
}
Module press_sites_module() { return {.code = press_sites_spv, .bytes = sizeof press_sites_spv}; }
Module press_sites_texels_module() {
    return {.code = press_sites_texels_spv, .bytes = sizeof press_sites_texels_spv, .texels = press_texels};
}

Module reduce_texels_module() {
    return {.code = reduce_texels_spv, .bytes = sizeof reduce_texels_spv, .texels = 1u << REDUCE_MAP};
}

Module halve_texels_module() {
    return {.code = halve_texels_spv, .bytes = sizeof halve_texels_spv, .texels = 1u << SPREAD_FINE};
}

Module spread_texels_module() {
    return {.code = spread_texels_spv,
            .bytes = sizeof spread_texels_spv,
            .texels = 1u << SPREAD_FINE | 1u << SPREAD_COARSE | 1u << SPREAD_GAIN};
}

std::vector<uint32_t> declare_rounding(const Module& module) {
    constexpr uint32_t header_words = 5, op_capability = 17, op_entry_point = 15;
    constexpr uint32_t capability[] = {2 << 16 | op_capability, 4467}; // RoundingModeRTE
    // OpExtension and its name, SPV_KHR_float_controls.
    constexpr uint32_t extension[] = {0x7000a, 0x5f565053, 0x5f52484b, 0x616f6c66, 0x6f635f74, 0x6f72746e, 0x736c};
    const std::span<const uint32_t> code(module.code, module.bytes / sizeof(uint32_t));
    std::vector<uint32_t> words(code.begin(), code.begin() + header_words);
    bool extended = false;
    for (size_t at = header_words, length = 0; at < code.size(); at += length) {
        const uint32_t op = code[at] & 0xffff;
        length = code[at] >> 16;
        if (op != op_capability && !std::exchange(extended, true)) {
            words.insert(words.end(), std::begin(capability), std::end(capability));
            words.insert(words.end(), std::begin(extension), std::end(extension));
        }
        words.insert(words.end(), &code[at], &code[at] + length);
        if (op == op_entry_point) // OpExecutionMode of this entry point: RoundingModeRTE of 32 bits
            words.insert(words.end(), {4 << 16 | 16, code[at + 2], 4462, 32});
    }
    return words;
}

} // namespace dermis::vulkan
