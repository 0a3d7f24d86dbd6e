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

// maps: a bit for each binding of a map.
#define DERMIS_MODULE(kernel, bindings, Constants, maps)                                                               \
    Module kernel##_module(bool texels) {                                                                              \
        if (texels) return {kernel##_texels_spv, sizeof kernel##_texels_spv, bindings, sizeof(f32::Constants), maps};  \
        return {kernel##_spv, sizeof kernel##_spv, bindings, sizeof(f32::Constants)};                                  \
    }
constexpr uint32_t press_maps =
    1u << PRESS_PRESSURE_FROM | 1u << PRESS_PRESSURE_TO | 1u << PRESS_REST_CURVATURE | 1u << PRESS_STATE_FROM;
DERMIS_MODULE(press, PRESS_BINDINGS, Constants, press_maps)
DERMIS_MODULE(press_signals, PRESS_BINDINGS, Constants, press_maps)
DERMIS_MODULE(press_sites, PRESS_BINDINGS, Constants, press_maps)
DERMIS_MODULE(reduce, REDUCE_BINDINGS, ReduceConstants, 1u << REDUCE_MAP)
DERMIS_MODULE(halve, SPREAD_BINDINGS, SpreadConstants, 1u << SPREAD_FINE)
DERMIS_MODULE(spread, SPREAD_BINDINGS, SpreadConstants, 1u << SPREAD_FINE | 1u << SPREAD_COARSE | 1u << SPREAD_GAIN)
#undef DERMIS_MODULE
Module fibres_module() { return {fibres_spv, sizeof fibres_spv, FIBRES_BINDINGS, sizeof(f32::FibreDispatch)}; }

std::vector<uint32_t> declare(const FloatRules& rules, const Module& module) {
    constexpr uint32_t header_words = 5, op_capability = 17, op_entry_point = 15, op_execution_mode = 16, bits = 32;
    struct Rule {
        bool declared;
        uint32_t capability, mode;
    };
    const Rule all[] = {{rules.keeps_nans, 4466, 4461},      // SignedZeroInfNanPreserve
                        {rules.rounds_to_even, 4467, 4462}}; // RoundingModeRTE
    // OpExtension and its name, SPV_KHR_float_controls.
    constexpr uint32_t extension[] = {0x7000a, 0x5f565053, 0x5f52484b, 0x616f6c66, 0x6f635f74, 0x6f72746e, 0x736c};
    const std::span<const uint32_t> code(module.code, module.bytes / sizeof(uint32_t));
    std::vector<uint32_t> words(code.begin(), code.begin() + header_words);
    bool extended = !rules.keeps_nans && !rules.rounds_to_even;
    for (size_t at = header_words, length = 0; at < code.size(); at += length) {
        const uint32_t op = code[at] & 0xffff;
        length = code[at] >> 16;
        if (op != op_capability && !std::exchange(extended, true)) {
            for (const Rule& r : all)
                if (r.declared) words.insert(words.end(), {2 << 16 | op_capability, r.capability});
            words.insert(words.end(), std::begin(extension), std::end(extension));
        }
        words.insert(words.end(), &code[at], &code[at] + length);
        for (const Rule& r : all)
            if (op == op_entry_point && r.declared)
                words.insert(words.end(), {4 << 16 | op_execution_mode, code[at + 2], r.mode, bits});
    }
    return words;
}

} // namespace dermis::vulkan
