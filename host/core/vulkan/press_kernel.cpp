// SPDX-License-Identifier: MIT
#include "host/core/vulkan/press_kernel.hpp"

#include <algorithm>

namespace dermis::vulkan {

static_assert(sizeof(f32::Constants) <= 128, "push constants: every device has 128 bytes");

namespace {

bool is_batch(const model::Variant& variant) { return variant.pads != model::Variant::Pads::none; }

std::vector<uint32_t> specialization_of(const model::Variant& variant, int x, int y, int z) {
    std::vector<uint32_t> constants = specialization(variant);
    constants[VARIANT_GROUP_X] = uint32_t(x);
    constants[VARIANT_GROUP_Y] = uint32_t(y);
    constants[VARIANT_GROUP_Z] = uint32_t(z);
    return constants;
}

} // namespace

Module press_module_for(const DeviceTable& device, bool signals) {
    if (signals) return device.texels ? press_signals_texels_module() : press_signals_module();
    return device.texels ? press_texels_module() : press_module();
}

PressKernel::PressKernel(Pipelines& pipelines, const model::PreparedSkin& skin, const model::Variant& variant,
                         const model::PressedBox& pressed, uint32_t max_bindings)
    : variant_(variant), pitch_(skin.pitch),
      columns_(is_batch(variant) ? skin.width() : pressed.last_tile * TILE_CELLS - pressed.first_column()),
      group_(group_of(skin, variant, pressed)), windows_(row_windows(pipelines.device(), skin,
                                                                     {.first = pressed.first_row,
                                                                      .last = pressed.last_row,
                                                                      .planes = variant.state().planes(),
                                                                      .work = double(numbers_of_press(variant)),
                                                                      .group_rows = group_.y})),
      kernel_(pipelines, press_module_for(pipelines.device(), variant.spreads),
              {.bindings = PRESS_BINDINGS,
               .constants_bytes = sizeof(f32::Constants),
               .specialization = specialization_of(variant, group_.x, group_.y, group_.z),
               .max_sets = max_bindings * uint32_t(windows_.size())}) {}

// A workgroup takes as many rows of a pad as fill it, shared evenly among the workgroups of the pad; or several pads.
// Of a skin that is pressed in part it takes one row, because no other row may be written.
PressKernel::Group PressKernel::group_of(const model::PreparedSkin& skin, const model::Variant& variant,
                                         const model::PressedBox& pressed) {
    if (!is_batch(variant) && (pressed.first_row > 0 || pressed.last_row < skin.height()))
        return {.x = PRESS_X * PRESS_Y, .y = 1, .z = 1};
    if (!is_batch(variant)) return {.x = PRESS_X, .y = PRESS_Y, .z = 1};
    constexpr int all = 128, deep = 64; // invocations that every device allows, in all and along z
    const int x = std::min((skin.width() + PRESS_CELLS - 1) / PRESS_CELLS, all), most = std::max(all / x, 1),
              count = (skin.height() + most - 1) / most, y = (skin.height() + count - 1) / count;
    return {.x = x, .y = y, .z = count > 1 ? 1 : std::clamp(all / (x * y), 1, deep)};
}

void PressKernel::bind(size_t binding, const Maps& m) {
    const int planes = variant_.state().planes();
    size_t set = binding * windows_.size();
    for (const RowWindow& window : windows_) {
        const auto map = [&](const BufferRange& range, bool used = true) {
            return used && !is_batch(variant_) ? window.of(range, pitch_) : range;
        };
        const auto state = [&](const BufferRange& range) {
            return is_batch(variant_) ? range : window.of(range, pitch_, planes);
        };
        std::vector<BoundRange> bound = {
            {PRESS_PRESSURE_FROM, map(m.pressure_from)},
            {PRESS_PRESSURE_TO, map(variant_.framed ? m.pressure_to : m.pressure_from)},
            {PRESS_REST_CURVATURE, map(m.rest_curvature)},
            {PRESS_STATE_FROM, state(m.state_from)},
            {PRESS_STATE_TO, state(m.state_to)},
            {PRESS_COEFFICIENTS, m.coefficients},
            {PRESS_MATERIAL, map(m.material, variant_.materials)},
            {PRESS_INVALID, m.invalid},
        };
        for (size_t i = 0; i < m.response.size(); ++i)
            bound.push_back({PRESS_RESPONSE(QUANTITY_SA1 + uint32_t(i)),
                             map(m.response[i], variant_.wanted[QUANTITY_SA1 + i] && !variant_.spreads)});
        kernel_.bind(set++, bound);
    }
}

void PressKernel::record(VkCommandBuffer commands, size_t binding, const f32::Constants& constants, uint32_t pads,
                         Recording* own) const {
    f32::Constants c = constants;
    for (size_t i = 0; i < windows_.size(); ++i) {
        const RowWindow& window = windows_[i];
        c.first_row = window.first;
        c.base_row = window.base;
        if (window.rows() == 0) continue; // Vulkan allows a dispatch of 0 groups, but some layers do not.
        if (own) own->add(work_of(window) * pads);
        kernel_.record(commands, binding * windows_.size() + i, &c, groups(columns_, PRESS_CELLS * group_.x),
                       groups(window.rows(), group_.y), groups(int(pads), group_.z));
    }
}

} // namespace dermis::vulkan
