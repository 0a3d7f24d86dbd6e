// SPDX-License-Identifier: MIT
#include "host/vulkan/press_kernel.hpp"

namespace dermis::vulkan {

static_assert(sizeof(f32::Constants) <= 128, "push constants: every device has 128 bytes");

Module press_module_for(const DeviceTable& device) {
    return device.texels ? press_texels_module(device.rounds) : press_module(device.rounds);
}

PressKernel::PressKernel(Pipelines& pipelines, const plan::PreparedSkin& skin, const plan::Variant& variant,
                         const plan::PressedBox& pressed, uint32_t max_bindings)
    : variant_(variant), pressed_(pressed), pitch_(skin.pitch),
      windows_(row_windows(skin, {.first = pressed.first_row,
                                  .last = pressed.last_row,
                                  .planes = state_planes(variant),
                                  .max_bytes = pipelines.device().limits.maxStorageBufferRange})),
      kernel_(pipelines, press_module_for(pipelines.device()),
              {.bindings = PRESS_BINDINGS,
               .constants_bytes = sizeof(f32::Constants),
               .specialization = specialization(variant),
               .max_sets = max_bindings * uint32_t(windows_.size())}) {}

void PressKernel::bind(size_t binding, const Maps& m) {
    const int planes = state_planes(variant_);
    size_t set = binding * windows_.size();
    for (const RowWindow& window : windows_) {
        const auto map = [&](const BufferRange& range, bool used = true) {
            return used ? window.of(range, pitch_) : range;
        };
        std::vector<BoundRange> bound = {
            {PRESS_PRESSURE_FROM, map(m.pressure_from)},
            {PRESS_PRESSURE_TO, map(variant_.framed ? m.pressure_to : m.pressure_from)},
            {PRESS_REST_CURVATURE, map(m.rest_curvature)},
            {PRESS_STATE_FROM, window.of(m.state_from, pitch_, planes)},
            {PRESS_STATE_TO, window.of(m.state_to, pitch_, planes)},
            {PRESS_COEFFICIENTS, m.coefficients},
            {PRESS_MATERIAL, map(m.material, variant_.materials)},
            {PRESS_INVALID, m.invalid},
        };
        for (size_t i = 0; i < m.response.size(); ++i)
            bound.push_back(
                {PRESS_RESPONSE(QUANTITY_SA1 + uint32_t(i)), map(m.response[i], variant_.wanted[QUANTITY_SA1 + i])});
        kernel_.bind(set++, bound);
    }
}

void PressKernel::record(VkCommandBuffer commands, size_t binding, const f32::Constants& constants) const noexcept {
    f32::Constants c = constants;
    const int columns = pressed_.last_tile * TILE_CELLS - c.first_column;
    for (size_t i = 0; i < windows_.size(); ++i) {
        const RowWindow& window = windows_[i];
        c.first_row = window.first;
        c.base_row = window.base;
        if (window.rows() > 0) // Vulkan allows a dispatch of 0 groups, but some layers do not.
            kernel_.record(commands, binding * windows_.size() + i, &c, groups(columns, PRESS_CELLS * PRESS_X),
                           groups(window.rows(), PRESS_Y));
    }
}

} // namespace dermis::vulkan
