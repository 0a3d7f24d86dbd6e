// SPDX-License-Identifier: MIT
// Records the presses of a streamed skin over memory that the caller owns, and tells what memory that is.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/vulkan/press_kernel.hpp"
#include "host/vulkan/sites_kernel.hpp"

#include <optional>

namespace dermis::vulkan {

constexpr size_t most_materials = 65536 / sizeof(f32::Coefficients); // the limit of one vkCmdUpdateBuffer, 64 KiB

// The coefficients of one press, by material. It stands on the caller's stack, so that several threads may record.
struct PressTable {
    std::array<f32::Coefficients, most_materials> of_material;
    PressTable() {} // leaves the array to Recorder::fill
};

class Recorder {
  public:
    // Throws Error::bad_input, naming the device limit that is exceeded.
    Recorder(Pipelines&, plan::StreamedSkin&&, uint32_t max_bindings);
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    const plan::StreamedSkin& skin() const { return streamed_; } // without its maps, which stand in the constants
    const plan::ResponseLayout& layout() const { return layout_; }
    const MemoryNeeds& needs() const { return needs_; }
    bool writes_constants() const { return table_.bytes > 0; }
    void bind(size_t binding, const Buffers&); // trusts that the buffers are as needs() says
    // Fills the table for a press of one skin by dt seconds. Returns false where a coefficient is beyond float.
    bool fill(PressTable&, double dt) const noexcept;
    void record(VkCommandBuffer, size_t binding, const PressTable&) const noexcept;
    // Returns whether all coefficients of a press of these pads are floats.
    bool accepts(const plan::PadList&, const plan::StepLengths&) const noexcept;
    // Records a press of some pads of a batch, whose numbers ascend, and copies the states and pressures of the others.
    void record(VkCommandBuffer, size_t binding, const plan::PadList&, const plan::StepLengths&) const noexcept;
    // Gives pads other elements, as many as before.
    void set_elements(const plan::PadList&, const std::vector<plan::Element>&);

  private:
    struct Slice { // a part of the constants
        VkDeviceSize offset = 0, bytes = 0;
    };
    template <class T> Slice append(const std::vector<T>&);
    // The elements of all materials of a skin, or of a pad without elements of its own.
    const std::vector<plan::Element>& materials() const { return materials_; }
    size_t table_length() const {
        return streamed_.elements_of_pad.empty() ? materials_.size() : streamed_.skin.chain.length;
    }
    // The index of the first coefficients behind a list of all pads, counted in Coefficients.
    size_t behind_list() const;
    bool fill_table(f32::Coefficients* table, int pad, double dt) const noexcept;
    bool pads_alike(const plan::StepLengths& dt) const { return streamed_.elements_of_pad.empty() && !dt.each; }
    void update_list(VkCommandBuffer, size_t binding, const plan::PadList&, bool tables_alike) const noexcept;
    void update_tables(VkCommandBuffer, size_t binding, const plan::PadList&, const plan::StepLengths&) const noexcept;
    void update(VkCommandBuffer, size_t binding, size_t offset, const void* from, size_t bytes) const noexcept;
    void copy_others(VkCommandBuffer, size_t binding, const plan::PadList&) const noexcept;
    void fill_needs();
    void check_limits() const;
    void update_table(VkCommandBuffer, size_t binding, const f32::Coefficients*) const noexcept;
    // Calls `update` between the barriers that keep it apart from earlier and later presses.
    template <class F> void between_presses(VkCommandBuffer, F update) const noexcept;

    const DeviceTable& device_;
    plan::StreamedSkin streamed_;
    const plan::ResponseLayout layout_;
    std::optional<PressKernel> fields_; // where every cell responds
    std::optional<PressKernel> alike_;  // for pads whose coefficients are those of one element, and the same
    std::optional<SitesKernel> sites_;  // where only sites respond
    MemoryNeeds needs_;
    Slice rest_, material_, table_, cells_, stencils_;
    std::vector<plan::Element> materials_;
    struct Bound {         // by a binding
        BufferRange table; // list and coefficients
        VkDescriptorBufferInfo state_from, state_to, pressure_from, pressure_to;
    };
    std::vector<Bound> bound_;
};

} // namespace dermis::vulkan
