// SPDX-License-Identifier: MIT
#include "host/core/vulkan/modules.hpp"

#include "host/core/simd/model.hpp"

#include "fibres_rte_spv.h"
#include "fibres_spv.h"
#include "fields_rte_spv.h"
#include "fields_spv.h"
#include "press_rte_spv.h"
#include "press_spv.h"
#include "press_texels_rte_spv.h"
#include "press_texels_spv.h"
#include "reduce_rte_spv.h"
#include "reduce_spv.h"
#include "reduce_texels_rte_spv.h"
#include "reduce_texels_spv.h"
#include "sites_rte_spv.h"
#include "sites_spv.h"

namespace dermis::vulkan {
namespace {

template <size_t n, size_t m> Module one_of(bool rounds, const uint32_t (&rte)[n], const uint32_t (&plain)[m]) {
    return rounds ? Module{.code = rte, .bytes = sizeof rte} : Module{.code = plain, .bytes = sizeof plain};
}

} // namespace

Module press_module(bool rounds) { return one_of(rounds, press_rte_spv, press_spv); }
Module fields_module(bool rounds) { return one_of(rounds, fields_rte_spv, fields_spv); }
Module reduce_module(bool rounds) { return one_of(rounds, reduce_rte_spv, reduce_spv); }
Module fibres_module(bool rounds) { return one_of(rounds, fibres_rte_spv, fibres_spv); }
Module sites_module(bool rounds) { return one_of(rounds, sites_rte_spv, sites_spv); }

Module press_texels_module(bool rounds) {
    Module module = one_of(rounds, press_texels_rte_spv, press_texels_spv);
    module.texels =
        1u << PRESS_PRESSURE_FROM | 1u << PRESS_PRESSURE_TO | 1u << PRESS_REST_CURVATURE | 1u << PRESS_STATE_FROM;
    return module;
}

Module reduce_texels_module(bool rounds) {
    Module module = one_of(rounds, reduce_texels_rte_spv, reduce_texels_spv);
    module.texels = 1u << REDUCE_MAP;
    return module;
}

} // namespace dermis::vulkan
