// SPDX-License-Identifier: MIT
#include "host/core/vulkan/windows.hpp"

#include <algorithm>
#include <bit>

namespace dermis::vulkan {
namespace {

// The bit mask of the responses asked for (see RESPONSE_BIT).
uint32_t responses_of(const model::Variant& variant) {
    uint32_t responses = 0;
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
        if (variant.wanted[size_t(q)]) responses |= RESPONSE_BIT(q);
    return responses;
}

// The window that binds every row read by the stencils of rows first .. last - 1.
RowWindow window_around(const model::PreparedSkin& skin, int first, int last) {
    int low = first, high = last - 1;
    for (int y = first; y < last; ++y) {
        const f64::Axis a = f64::axis(y, skin.height(), skin.stencil, skin.edges);
        low = std::min({low, a.low, a.high});
        high = std::max({high, a.low, a.high});
        if (f64::reach(skin.stencil) == 1) continue;
        low = std::min({low, a.far_low, a.far_high});
        high = std::max({high, a.far_low, a.far_high});
    }
    return {.base = low / WINDOW_ROWS * WINDOW_ROWS, .end = std::max(high + 1, 1), .first = first, .last = last};
}

} // namespace

uint32_t groups(int cells, int size) { return uint32_t((cells + size - 1) / size); }

int numbers_of_press(const model::Variant& variant) {
    return variant.state().planes() + std::popcount(responses_of(variant));
}

std::vector<uint32_t> specialization(const model::Variant& variant) {
    std::vector<uint32_t> constants(VARIANT_CONSTANTS);
    constants[VARIANT_STENCIL] = uint32_t(variant.stencil);
    constants[VARIANT_EDGES] = uint32_t(variant.edges);
    constants[VARIANT_COMPENSATED] = variant.compensated;
    constants[VARIANT_MATERIALS] = variant.materials;
    constants[VARIANT_FRAMES] = variant.framed;
    constants[VARIANT_RESPONSES] = responses_of(variant);
    constants[VARIANT_ELEMENTS] = uint32_t(variant.chain.elements());
    constants[VARIANT_SPRING] = variant.chain.spring;
    constants[VARIANT_STRAIN] = variant.keeps_strain;
    constants[VARIANT_PADS] = uint32_t(variant.pads);
    constants[VARIANT_GROUP_X] = PRESS_X;
    constants[VARIANT_GROUP_Y] = PRESS_Y;
    constants[VARIANT_GROUP_Z] = 1;
    constants[VARIANT_HOLD] = variant.parabolic;
    return constants;
}

std::vector<RowWindow> row_windows(const DeviceTable& device, const model::PreparedSkin& skin,
                                   const WindowOptions& options) {
    const int height = skin.height();
    const VkDeviceSize row = VkDeviceSize(skin.pitch) * VkDeviceSize(options.planes) * sizeof(float),
                       max_bytes = device.limits.maxStorageBufferRange;
    const int most = int(std::min<VkDeviceSize>(max_bytes / row, VkDeviceSize(height)));
    const bool whole = most == height; // every row is bound
    const double rows = std::min(whole ? double(height) : double(most - 2 * f64::reach(skin.stencil) - WINDOW_ROWS),
                                 device.most_work / (options.work * skin.pitch));
    const int step = rows < height ? std::max(int(rows) / options.group_rows, 1) * options.group_rows : height;
    std::vector<RowWindow> windows;
    for (int first = options.first; first < options.last || windows.empty(); first += step) {
        const int last = std::min(first + step, options.last);
        const RowWindow window = whole ? RowWindow{.base = 0, .end = height, .first = first, .last = last}
                                       : window_around(skin, first, last);
        if (window.end - window.base > most)
            throw Error(
                Error::Code::bad_input, "curvature.edges",
                "a grid of " + std::to_string(skin.width()) + " x " + std::to_string(height) +
                    " is worked on in bands of rows, which do not fit; periodic edges join the first and the last: "
                    "maxStorageBufferRange = " +
                    std::to_string(max_bytes) + "; allowed: maps up to that, other edges, or device cpu");
        windows.push_back(window);
    }
    return windows;
}

} // namespace dermis::vulkan
