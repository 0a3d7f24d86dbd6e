// SPDX-License-Identifier: MIT
// The memory of a skin that is pressed frame by frame, whoever owns it, and presses recorded over it.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/vulkan/press_kernel.hpp"
#include "host/vulkan/sites_kernel.hpp"

#include <optional>

namespace dermis::vulkan {

constexpr size_t most_materials = 65536 / sizeof(f32::Coefficients); // what one vkCmdUpdateBuffer takes

// The coefficients of one press, by material: up to 64 KiB of the stack, so that any number of threads may record.
struct PressTable {
    std::array<f32::Coefficients, most_materials> of;
    PressTable() {} // filled before it is read
};

class Recorder {
  public:
    // Throws Error::bad_input naming the limit that something exceeds.
    Recorder(Pipelines&, plan::StreamedSkin&&, uint32_t max_bindings);
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    const plan::StreamedSkin& skin() const { return streamed_; } // without its maps: they stand in the constants
    const plan::ResponseLayout& layout() const { return layout_; }
    const MemoryNeeds& needs() const { return needs_; }
    bool writes_constants() const { return table_.bytes > 0; }
    void bind(size_t binding, const Buffers&); // as needs() says: nothing is checked
    // False where a coefficient of such a press is beyond float.
    bool fill(PressTable&, double dt) const noexcept;
    void record(VkCommandBuffer, size_t binding, const PressTable&) const noexcept;

  private:
    struct Slice { // of the constants
        VkDeviceSize offset = 0, bytes = 0;
    };
    template <class T> Slice append(const std::vector<T>&);
    const std::vector<plan::Element>& materials() const {
        return sites_ ? sites_->materials() : streamed_.skin.materials;
    }
    void fill_needs();
    void check_limits() const;
    void update_table(VkCommandBuffer, size_t binding, const f32::Coefficients*) const noexcept;

    const DeviceTable& device_;
    plan::StreamedSkin streamed_;
    const plan::ResponseLayout layout_;
    std::optional<PressKernel> fields_; // either
    std::optional<SitesKernel> sites_;
    MemoryNeeds needs_;
    Slice rest_, material_, table_, cells_, stencils_;
    std::vector<BufferRange> tables_; // of each binding
};

} // namespace dermis::vulkan
