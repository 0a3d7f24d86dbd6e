// SPDX-License-Identifier: MIT
// Presses of a plan on whatever memory, band by band.
#pragma once

#include "host/plan/plan.hpp"
#include "host/vulkan/kernel.hpp"

namespace dermis::vulkan {

// Some rows of a grid, no more than what a device binds at once.
struct Band {
    int base, end;   // rows bound
    int first, last; // rows worked on; what they look at is bound
    // So many rows of a map per row of cells.
    Piece of(const Piece& map, int pitch, int rows = 1) const {
        const VkDeviceSize row = VkDeviceSize(pitch) * VkDeviceSize(rows) * sizeof(float);
        return {map.buffer, map.offset + VkDeviceSize(base) * row, VkDeviceSize(end - base) * row};
    }
};

// Of rows first .. last - 1, so that none has more than max_bytes of a map with `rows` rows per row of cells; at least
// one band. Throws Error::bad_input where edges join rows too far apart.
std::vector<Band> bands(const plan::Plan&, int first, int last, int rows, VkDeviceSize max_bytes);

// Of a state per row of cells, as the kernels have it.
int state_planes(const plan::Plan&);

// The kernel `press`, and the memory of its bindings.
class Press {
  public:
    struct Maps {
        Piece pressure_from, pressure_to, rest, state_from, state_to;
        Piece response[4];             // any small piece in place of what is not asked for
        Piece rows, material, invalid; // any in place of rows and material under a uniform material
    };
    Press(Pipelines&, const plan::Plan&, uint32_t max_bindings);
    void bind(size_t binding, const Maps&);
    void record(VkCommandBuffer, size_t binding, const f32::Constants&) const noexcept;
    const std::vector<Band>& bands() const { return bands_; }

  private:
    const plan::Plan& plan_;
    std::vector<Band> bands_;
    Kernel kernel_;
};

uint32_t groups(int cells, int size);

// Specialization constants of press, fields and sites.
std::vector<uint32_t> variant_of(const plan::Plan&);

} // namespace dermis::vulkan
