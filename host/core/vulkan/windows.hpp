// SPDX-License-Identifier: MIT
// Row windows. A grid is bound and computed in several windows if its maps exceed the largest storage buffer range of a
// device, and computed in several windows if it is too much work for one submission.
#pragma once

#include "host/core/model/skin.hpp"
#include "host/core/vulkan/kernel.hpp"

namespace dermis::vulkan {

// Consecutive rows of a grid, at most what a device binds at once. `end` and `last` are exclusive.
struct RowWindow {
    int base, end;   // the rows that are bound
    int first, last; // the rows that are computed; all rows that their stencils read are bound
    int rows() const { return last - first; }
    // The range of a map that is bound. The map has `planes` rows for each row of cells.
    BufferRange of(const BufferRange& map, int pitch, int planes = 1) const {
        const VkDeviceSize row = VkDeviceSize(pitch) * VkDeviceSize(planes) * sizeof(float);
        return {map.buffer, map.offset + VkDeviceSize(base) * row, VkDeviceSize(end - base) * row};
    }
};

struct WindowOptions {
    int first, last; // the rows that are computed; `last` is exclusive
    int planes;      // rows of a map for each row of cells
    double work;     // of a cell (see DeviceTable::most_work)
    // The rows of a workgroup. Every window but the last has a multiple of them: a workgroup that reached into the next
    // window would write its rows from cells that are not bound.
    int group_rows = 1;
};
// Divides the rows into at least one window. Throws Error::bad_input where the edges join rows too far apart.
std::vector<RowWindow> row_windows(const DeviceTable&, const model::PreparedSkin&, const WindowOptions&);

// The numbers that a press writes for each cell.
int numbers_of_press(const model::Variant&);

// The number of workgroups of `size` cells that cover `cells`.
uint32_t groups(int cells, int size);

// The specialization constants of a variant, in the order of their numbers in kernels/layout.h.
std::vector<uint32_t> specialization(const model::Variant&);

} // namespace dermis::vulkan
