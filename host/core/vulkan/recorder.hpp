// SPDX-License-Identifier: MIT
// Records the presses of a streamed skin over memory that the caller owns, and tells what memory that is.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/vulkan/press_kernel.hpp"
#include "host/core/vulkan/spread_kernel.hpp"

#include <optional>
#include <span>

namespace dermis::vulkan {

// Coefficients of one press, at most what one vkCmdUpdateBuffer takes. The table is on the caller's stack, so that
// several threads may record at once.
struct PressTable {
    static constexpr size_t update_bytes = 65536;
    std::array<f32::Coefficients, update_bytes / sizeof(f32::Coefficients)> coefficients;
    bool whole;     // it holds all of the press; otherwise Recorder::record makes them a part at a time
    PressTable() {} // leaves its members to Recorder::fill
};

class Recorder {
  public:
    // Throws Error::bad_input, naming the device limit that is exceeded.
    Recorder(Pipelines&, model::StreamedSkin&&, uint32_t max_bindings);
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    const model::StreamedSkin& skin() const { return streamed_; } // without its maps, which stand in the constants
    const model::ResponseLayout& layout() const { return layout_; }
    const MemoryNeeds& needs() const { return needs_; }
    bool writes_constants() const { return table_.bytes > 0; }
    void bind(size_t binding, const Buffers&); // trusts that the buffers are what needs() asks for
    struct Press {
        model::PadList pads; // their numbers ascend
        model::StepLengths dt;
        bool answers = true; // whether responses are computed
    };
    // Fills the table for a press. Returns false where a coefficient is beyond float.
    bool fill(PressTable&, const Press&) const noexcept;
    // Records a press. The table has been filled for it. In a batch this also copies the states and pressures of pads
    // that are not pressed. own: see PressKernel::record(); if it is null, nothing is thrown.
    void record(VkCommandBuffer, size_t binding, const Press&, PressTable&, Recording* own = nullptr) const;
    // The most work of a pad's press.
    double work_of_pad() const { return press_->work_of_pad() + (spread_ ? spread_->work_of_pad() : 0); }
    bool copies() const { return spread_ && spread_->copies(); } // a press ends with a copy
    // Gives pads other elements, the same number as before.
    void set_elements(const model::PadList&, const std::vector<model::Element>&);

  private:
    struct Slice { // a part of the constants
        VkDeviceSize offset = 0, bytes = 0;
    };
    template <class T> Slice append(const std::vector<T>&);
    // The coefficients of a pad's table.
    size_t table_length() const {
        return model::entries_of(streamed_.hold) *
               (streamed_.elements_of_pad.empty() ? materials_.size() : streamed_.skin.chain.length);
    }
    size_t pads_of_group() const { return press_->pads_of_group(); } // of a workgroup
    // The index of the first coefficients behind a list of all pads, counted in Coefficients.
    size_t behind_list() const;
    bool pads_alike(const Press& press) const {
        return streamed_.elements_of_pad.empty() && !press.dt.each && press.dt.alike(press.pads);
    }
    // The elements of a pad's table.
    std::span<const model::Element> elements_of(int pad) const;
    // Pads first .. last - 1 of a press, by their places in its list.
    struct Slots {
        size_t first, last;
    };
    // Computes the coefficients of some slots, as many at a time as the table holds, and calls f(index of the first
    // one, coefficients, their number) each time. Returns false if a coefficient is beyond float.
    template <class F> bool each_update(PressTable&, const Press&, const Slots&, F f) const;
    void update_list(VkCommandBuffer, size_t binding, const Press&, const Slots&) const;
    void update_tables(VkCommandBuffer, size_t binding, const Press&, const Slots&, PressTable&) const;
    void update(VkCommandBuffer, size_t binding, size_t offset, const void* from, size_t bytes) const;
    void copy_others(VkCommandBuffer, size_t binding, const model::PadList&) const;
    void fill_needs();
    void check_limits() const;
    // Calls `update` between the barriers that keep it apart from earlier and later presses.
    template <class F> void between_presses(VkCommandBuffer, F update) const;

    const DeviceTable& device_;
    model::StreamedSkin streamed_;
    const model::ResponseLayout layout_;
    std::optional<PressKernel> press_;
    std::optional<PressKernel> alike_;   // set for pads that all have the same single element
    std::optional<SpreadKernel> spread_; // set where receptors lie at depths: `press` then makes their signals
    MemoryNeeds needs_;
    Slice rest_, material_, table_, sites_, weights_;
    std::vector<model::Element> materials_; // the elements of all, or of a pad without elements of its own
    struct Bound {                          // by a binding
        BufferRange table;                  // list and coefficients
        VkDescriptorBufferInfo state_from, state_to, pressure_from, pressure_to;
    };
    std::vector<Bound> bound_;
};

} // namespace dermis::vulkan
