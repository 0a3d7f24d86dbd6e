// SPDX-License-Identifier: MIT
// Windows of rows: a grid is bound and worked on in as many as a device's largest storage buffer asks for.
#pragma once

#include "host/plan/skin.hpp"
#include "host/vulkan/kernel.hpp"

namespace dermis::vulkan {

// Some rows of a grid, no more than what a device binds at once.
struct RowWindow {
    int base, end;   // rows bound
    int first, last; // rows worked on; the rows that their stencils read are bound
    int rows() const { return last - first; }
    // The part of a map that is bound; `planes` rows of the map for each row of cells.
    BufferRange of(const BufferRange& map, int pitch, int planes = 1) const {
        const VkDeviceSize row = VkDeviceSize(pitch) * VkDeviceSize(planes) * sizeof(float);
        return {map.buffer, map.offset + VkDeviceSize(base) * row, VkDeviceSize(end - base) * row};
    }
};

// Windows over rows first .. last - 1, none of which binds more than max_bytes of a map with `planes` rows for each row
// of cells; at least one window. Throws Error::bad_input where edges join rows too far apart.
std::vector<RowWindow> row_windows(const plan::PreparedSkin&, int first, int last, int planes, VkDeviceSize max_bytes);

// Planes of a state (see kernels/layout.h).
int state_planes(const plan::Variant&);

// The numbers of workgroups of `size` that cover `cells`.
uint32_t groups(int cells, int size);

// Specialization constants, by the numbers of kernels/layout.h.
std::vector<uint32_t> specialization(const plan::Variant&);

} // namespace dermis::vulkan
