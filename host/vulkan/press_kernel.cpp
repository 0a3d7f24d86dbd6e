// SPDX-License-Identifier: MIT
#include "host/vulkan/press_kernel.hpp"

#include <algorithm>

namespace dermis::vulkan {

namespace {

// Which are asked for, as the kernels have it.
uint32_t responses_of(const plan::Plan& plan) {
    uint32_t responses = 0;
    for (int q = 1; q < REDUCED_MAPS; ++q) responses |= uint32_t(plan.wanted[q]) << (q - 1);
    return responses;
}

} // namespace

static_assert(sizeof(f32::Constants) <= 128, "push constants: 128 bytes are what every device has");

uint32_t groups(int cells, int size) { return uint32_t((cells + size - 1) / size); }

int state_planes(const plan::Plan& plan) { return STATE_PLANES(int(plan.compensated), responses_of(plan)); }

std::vector<uint32_t> variant_of(const plan::Plan& plan) {
    return {uint32_t(plan.stencil), uint32_t(plan.edges), plan.compensated,
            !plan.material.empty(), plan.framed,          responses_of(plan)};
}

std::vector<Band> bands(const plan::Plan& plan, int begin, int end, int rows, VkDeviceSize max_bytes) {
    const int height = plan.constants.height, reach = plan.stencil == STENCIL_FIVE_POINT ? 1 : 2;
    const VkDeviceSize row = VkDeviceSize(plan.pitch) * VkDeviceSize(rows) * sizeof(float);
    const int most = int(std::min<VkDeviceSize>(max_bytes / row, VkDeviceSize(height)));
    if (most == height) return {{0, height, begin, end}};
    const int step = most - 2 * reach - WINDOW_ROWS;
    std::vector<Band> list;
    for (int first = begin; first < end || list.empty(); first += std::max(step, 1)) {
        const int last = std::min(first + std::max(step, 1), end);
        int low = first, high = last - 1;
        for (int y = first; y < last; ++y) {
            const f64::Axis a = f64::axis(y, height, plan.stencil, plan.edges);
            low = std::min({low, a.low, a.high});
            high = std::max({high, a.low, a.high});
            if (reach == 1) continue;
            low = std::min({low, a.far_low, a.far_high});
            high = std::max({high, a.far_low, a.far_high});
        }
        const Band band{low / WINDOW_ROWS * WINDOW_ROWS, std::max(high + 1, 1), first, last};
        if (band.end - band.base > most)
            throw Error(
                Error::Code::bad_input, "curvature.edges",
                "a grid of " + std::to_string(plan.constants.width) + " x " + std::to_string(height) +
                    " is worked on in bands of rows, which do not fit; periodic edges join the first and the last: "
                    "maxStorageBufferRange = " +
                    std::to_string(max_bytes) + "; allowed: maps up to that, other edges, or device cpu");
        list.push_back(band);
    }
    return list;
}

Press::Press(Pipelines& pipelines, const plan::Plan& plan, uint32_t max_bindings)
    : plan_(plan), bands_(vulkan::bands(plan, plan.pressed.first_row, plan.pressed.last_row, state_planes(plan),
                                        pipelines.gpu().limits.maxStorageBufferRange)),
      kernel_(pipelines, press_module(pipelines.gpu().rounds), PRESS_BINDINGS, sizeof(f32::Constants), variant_of(plan),
              max_bindings * uint32_t(bands_.size())) {}

void Press::bind(size_t binding, const Maps& m) {
    const int pitch = plan_.pitch, rows = state_planes(plan_);
    size_t set = binding * bands_.size();
    for (const Band& band : bands_) {
        const auto map = [&](const Piece& p) { return band.of(p, pitch); };
        std::vector<Piece> pieces = {map(m.pressure_from), plan_.framed ? map(m.pressure_to) : m.pressure_to,
                                     map(m.rest), band.of(m.state_from, pitch, rows), band.of(m.state_to, pitch, rows)};
        for (int q = 1; q < REDUCED_MAPS; ++q)
            pieces.push_back(plan_.wanted[q] ? map(m.response[q - 1]) : m.response[q - 1]);
        pieces.insert(pieces.end(), {m.rows, plan_.material.empty() ? m.material : map(m.material), m.invalid});
        kernel_.bind(set++, pieces);
    }
}

void Press::record(VkCommandBuffer commands, size_t binding, const f32::Constants& constants) const noexcept {
    f32::Constants c = constants;
    const int columns = plan_.pressed.last_tile * TILE_CELLS - c.first_column;
    for (size_t i = 0; i < bands_.size(); ++i) {
        const Band& band = bands_[i];
        c.first_row = band.first;
        c.base_row = band.base;
        if (band.last > band.first) // vkCmdDispatch of 0 groups is allowed, but not by every layer
            kernel_.record(commands, binding * bands_.size() + i, &c, groups(columns, PRESS_CELLS * PRESS_X),
                           groups(band.last - band.first, PRESS_Y));
    }
}

} // namespace dermis::vulkan
