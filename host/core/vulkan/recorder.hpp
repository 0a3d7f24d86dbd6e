// SPDX-License-Identifier: MIT
// Records the presses of a streamed skin over memory that the caller owns, and tells what memory that is.
#pragma once

#include "dermis/vulkan.hpp"
#include "host/core/base/float_environment.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/vulkan/press_kernel.hpp"
#include "host/core/vulkan/spread_kernel.hpp"

#include <algorithm>
#include <cstring>
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
    Recorder(Pipelines& pipelines, model::StreamedSkin&& streamed, uint32_t max_bindings)
        : device_(pipelines.device()), streamed_(std::move(streamed)), layout_(response_layout_of(streamed_)) {
        const model::PreparedSkin& skin = streamed_.skin;
        const model::Variant variant = streamed_.variant();
        const model::SiteCells needed = model::site_cells_of(skin);
        const std::vector<f32::SiteEntry> sites = site_entries(streamed_, layout_, needed);
        press_.emplace(pipelines, skin, variant, skin.whole(), max_bindings, sites);
        if (streamed_.pads > 1 && !variant.tabled() && streamed_.elements_of_pad.empty()) {
            model::Variant alike = variant;
            alike.pads = model::Variant::Pads::alike;
            alike_.emplace(pipelines, skin, alike, skin.whole(), max_bindings, sites);
        }
        if (streamed_.deep()) spread_.emplace(pipelines, streamed_, layout_, pads_of_group(), max_bindings);
        rest_ = append(model::padded_rest_curvature<float>(skin));
        sites_ = append(press_->sites());
        materials_ = variant.sites ? needed.materials : skin.materials;
        material_ = append(variant.sites ? materials_of(skin, needed) : skin.material_of);
        if (spread_) weights_ = append(spread_->weights());
        if (streamed_.pads > 1)
            table_ = append(std::vector<f32::Coefficients>(behind_list() + size_t(streamed_.pads) * table_length()));
        else if (streamed_.variant().tabled()) table_ = append(std::vector<f32::Coefficients>(table_length()));
        fill_needs();
        check_limits();
        model::drop_maps(streamed_.skin);
    }
    Recorder& operator=(Recorder&&) = delete; // and no copies

    const model::StreamedSkin& skin() const { return streamed_; } // without its maps, which stand in the constants
    const model::ResponseLayout& layout() const { return layout_; }
    const MemoryNeeds& needs() const { return needs_; }
    bool writes_constants() const { return table_.bytes > 0; }
    // trusts that the buffers are what needs() asks for
    void bind(size_t binding, const Buffers& b) {
        const auto range = [](const VkDescriptorBufferInfo& i, const Memory& m) {
            return BufferRange{i.buffer, i.offset, m.bytes};
        };
        const auto constant = [&](const Slice& s) {
            return BufferRange{b.constants.buffer, b.constants.offset + s.offset, s.bytes};
        };
        const BufferRange response = range(b.response, needs_.response), invalid = range(b.invalid, needs_.invalid);
        if (bound_.size() <= binding) bound_.resize(binding + 1);
        bound_[binding] = {constant(table_), b.state_from, b.state_to, b.pressure_from, b.pressure_to};
        PressKernel::Maps m{.pressure_from = range(b.pressure_from, needs_.pressure),
                            .pressure_to = range(b.pressure_to, needs_.pressure),
                            .rest_curvature = constant(rest_),
                            .state_from = range(b.state_from, needs_.state),
                            .state_to = range(b.state_to, needs_.state),
                            .response = {},
                            .sites = constant(sites_),
                            .responses = response,
                            .coefficients = writes_constants() ? bound_[binding].table : invalid,
                            .material = streamed_.skin.uniform() ? invalid : constant(material_),
                            .invalid = invalid};
        const BufferRange scratch = range(b.scratch, needs_.scratch);
        if (spread_) m.material = spread_->gain(scratch);
        for (size_t i = 0; i < m.response.size(); ++i) {
            const model::ResponseLayout::Range& r = layout_.of[QUANTITY_SA1 + i];
            m.response[i] = !streamed_.wanted[QUANTITY_SA1 + i] ? invalid
                            : spread_                           ? spread_->signal(QUANTITY_SA1 + int(i), scratch)
                                      : BufferRange{response.buffer, response.offset + r.first * sizeof(float),
                                                    r.count * sizeof(float)};
        }
        press_->bind(binding, m);
        if (alike_) alike_->bind(binding, m);
        if (spread_)
            spread_->bind(binding, {.scratch = scratch,
                                    .weights = constant(weights_),
                                    .response = response,
                                    .pads = streamed_.pads > 1 ? bound_[binding].table : constant(weights_)});
    }
    struct Press {
        model::PadList pads; // their numbers ascend
        model::StepLengths dt;
        bool answers = true; // whether responses are computed
    };
    // Fills the table for a press. Returns false where a coefficient is beyond float.
    bool fill(PressTable& table, const Press& press) const noexcept {
        const DefaultFloats guard;
        int updates = 0;
        const Slots all{0, pads_alike(press) ? 1 : press.pads.count};
        const bool floats = each_update(table, press, all, [&](auto...) { ++updates; });
        table.whole = updates == 1;
        return floats;
    }
    // Records a press. The table has been filled for it. In a batch this also copies the states and pressures of pads
    // that are not pressed. own: see PressKernel::record(); if it is null, nothing is thrown.
    void record(VkCommandBuffer commands, size_t binding, const Press& press, PressTable& table,
                Recording* own = nullptr) const {
        const DefaultFloats guard;
        const size_t count = press.pads.count;
        const bool batch = streamed_.pads > 1,
                   from_constants = batch ? alike_ && pads_alike(press) : !writes_constants();
        const double most_pads = double(device_.limits.maxComputeWorkGroupCount[2]) * double(pads_of_group());
        const size_t most = size_t(std::clamp(device_.most_work / work_of_pad(), 1.0, most_pads));
        for (size_t first = 0; first == 0 || first < count; first += most) {
            const Slots slots{first, std::min(first + most, count)};
            if (writes_constants())
                between_presses(commands, [&] {
                    if (batch && first == 0) copy_others(commands, binding, press.pads);
                    if (batch) update_list(commands, binding, press, slots);
                    if (from_constants || count == 0) return;
                    if (!pads_alike(press)) update_tables(commands, binding, press, slots, table);
                    else if (first == 0) update_tables(commands, binding, press, {0, 1}, table);
                });
            if (count == 0) return;
            f32::Constants c = model::frame_constants(streamed_.skin, table.coefficients.front());
            c.respond = press.answers;
            const uint32_t pads = uint32_t(slots.last - slots.first);
            (batch && from_constants ? alike_ : press_)->record(commands, binding, c, pads, own);
            if (spread_ && press.answers) spread_->record(commands, binding, press.pads, slots.first, slots.last, own);
        }
    }
    // The most work of a pad's press.
    double work_of_pad() const { return press_->work_of_pad() + (spread_ ? spread_->work_of_pad() : 0); }
    bool copies() const { return spread_ && spread_->copies(); } // a press ends with a copy
    // Gives pads other elements, the same number as before.
    void set_elements(const model::PadList& pads, const std::vector<model::Element>& elements) {
        if (streamed_.elements_of_pad.empty()) materials_ = elements;
        else
            for (size_t i = 0; i < pads.count; ++i)
                std::ranges::copy(elements,
                                  streamed_.elements_of_pad.begin() + long(size_t(pads[i]) * elements.size()));
    }

  private:
    static constexpr VkDeviceSize slice_alignment =
        256; // the greatest minStorageBufferOffsetAlignment that Vulkan allows

    // A map of the materials of these cells, which no other cell needs.
    static std::vector<int> materials_of(const model::PreparedSkin& skin, const model::SiteCells& needed) {
        const size_t width = size_t(skin.width());
        std::vector<int> map(skin.uniform() ? 0 : skin.padded_cells());
        for (size_t i = 0; i < needed.cells.size() && !map.empty(); ++i)
            map[needed.cells[i] / width * size_t(skin.pitch) + needed.cells[i] % width] = needed.material_of[i];
        return map;
    }

    struct Slice { // a part of the constants
        VkDeviceSize offset = 0, bytes = 0;
    };
    template <class T> Slice append(const std::vector<T>& values) {
        std::vector<unsigned char>& all = needs_.constants.initial;
        const Slice slice{(all.size() + slice_alignment - 1) / slice_alignment * slice_alignment,
                          values.size() * sizeof(T)};
        if (values.empty()) return slice;
        all.resize(slice.offset + slice.bytes);
        std::memcpy(all.data() + slice.offset, values.data(), slice.bytes);
        return slice;
    }
    // The coefficients of a pad's table.
    size_t table_length() const {
        return model::entries_of(streamed_.hold) *
               (streamed_.elements_of_pad.empty() ? materials_.size() : streamed_.skin.chain.length);
    }
    size_t pads_of_group() const { return press_->pads_of_group(); } // of a workgroup
    // The index of the first coefficients behind a list of all pads, counted in Coefficients.
    size_t behind_list() const {
        if (streamed_.pads == 1) return 0;
        const size_t bytes = (size_t(streamed_.pads) + pads_of_group() - 1) * sizeof(f32::PadEntry);
        return (bytes + sizeof(f32::Coefficients) - 1) / sizeof(f32::Coefficients);
    }
    bool pads_alike(const Press& press) const {
        return streamed_.elements_of_pad.empty() && !press.dt.each && press.dt.alike(press.pads);
    }
    // The elements of a pad's table.
    std::span<const model::Element> elements_of(int pad) const {
        const std::vector<model::Element>& own = streamed_.elements_of_pad;
        const size_t chain = streamed_.skin.chain.length;
        return own.empty() ? std::span(materials_) : std::span(own).subspan(size_t(pad) * chain, chain);
    }
    // Pads first .. last - 1 of a press, by their places in its list.
    struct Slots {
        size_t first, last;
    };
    // Computes the coefficients of some slots, as many at a time as the table holds, and calls f(index of the first
    // one, coefficients, their number) each time. Returns false if a coefficient is beyond float.
    template <class F> bool each_update(PressTable& table, const Press& press, const Slots& slots, F f) const {
        const model::PreparedSkin& skin = streamed_.skin;
        const size_t entries = model::entries_of(streamed_.hold), length = table_length(),
                     chain = entries * skin.chain.length,
                     most = table.coefficients.size() / chain * chain; // whole materials
        f32::Coefficients* const begin = table.coefficients.data();
        size_t done = 0, n = 0;
        for (size_t i = slots.first; i < slots.last; ++i)
            for (size_t at = 0, more; at < length; at += more) {
                more = std::min(length - at, most - n);
                const std::span<const model::Element> elements =
                    elements_of(press.pads.count ? press.pads[i] : 0).subspan(at / entries, more / entries);
                if (!model::fill_table<f32>(elements, skin.chain, skin.rule, press.dt.of(press.pads, i), begin + n))
                    return false;
                n += more;
                if (n < most && (at + more < length || i + 1 < slots.last)) continue;
                f(done, begin, n);
                done += std::exchange(n, 0);
            }
        return true;
    }
    void update_list(VkCommandBuffer commands, size_t binding, const Press& press, const Slots& slots) const {
        const size_t length = pads_alike(press) ? 0 : table_length(), tables = behind_list(), group = pads_of_group(),
                     count = (slots.last - slots.first + group - 1) / group * group;
        std::array<f32::PadEntry, PressTable::update_bytes / sizeof(f32::PadEntry)> entries;
        for (size_t place = 0, n = 0; place < count; ++place) {
            const size_t i = slots.first + place;
            entries[n].pad = i < slots.last ? press.pads[i] : -1;
            entries[n++].table = int(tables + place * length);
            if (n < entries.size() && place + 1 < count) continue;
            update(commands, binding, (place + 1 - n) * sizeof(f32::PadEntry), entries.data(),
                   n * sizeof(f32::PadEntry));
            n = 0;
        }
    }
    void update_tables(VkCommandBuffer commands, size_t binding, const Press& press, const Slots& slots,
                       PressTable& table) const {
        const size_t length = table_length();
        const auto put = [&](size_t index, const f32::Coefficients* from, size_t count) {
            update(commands, binding, (behind_list() + index) * sizeof *from, from, count * sizeof *from);
        };
        if (table.whole) put(0, table.coefficients.data() + slots.first * length, (slots.last - slots.first) * length);
        else (void)each_update(table, press, slots, put); // true: it was checked
    }
    void update(VkCommandBuffer commands, size_t binding, size_t offset, const void* from, size_t bytes) const {
        const BufferRange& to = bound_[binding].table;
        device_.calls.vkCmdUpdateBuffer(commands, to.buffer, to.offset + offset, bytes, from);
    }
    void copy_others(VkCommandBuffer commands, size_t binding, const model::PadList& pads) const {
        const Bound& b = bound_[binding];
        const auto copy = [&](const VkDescriptorBufferInfo& from, const VkDescriptorBufferInfo& to, const Memory& needs,
                              size_t first, size_t last) {
            const VkDeviceSize pad = needs.bytes / VkDeviceSize(streamed_.pads);
            const VkBufferCopy region{from.offset + first * pad, to.offset + first * pad, (last - first) * pad};
            device_.calls.vkCmdCopyBuffer(commands, from.buffer, to.buffer, 1, &region);
        };
        for (size_t i = 0, first = 0; i <= pads.count; ++i) { // pads first .. last - 1 are not pressed
            const size_t last = i < pads.count ? size_t(pads[i]) : size_t(streamed_.pads);
            if (first < last) {
                copy(b.state_from, b.state_to, needs_.state, first, last);
                const bool held =
                    b.pressure_from.buffer == b.pressure_to.buffer && b.pressure_from.offset == b.pressure_to.offset;
                if (!held) copy(b.pressure_from, b.pressure_to, needs_.pressure, first, last);
            }
            first = last + 1;
        }
    }
    void fill_needs() {
        const VkDeviceSize pads = VkDeviceSize(streamed_.pads),
                           map = pads * streamed_.skin.padded_cells() * sizeof(float);
        const VkDeviceSize planes = VkDeviceSize(streamed_.variant().state().planes());
        needs_.constants.bytes = needs_.constants.initial.size();
        needs_.state.bytes = planes * map;
        needs_.pressure.bytes = map;
        needs_.response.bytes = layout_.all * sizeof(float);
        needs_.invalid.bytes = sizeof(uint32_t);
        needs_.scratch.bytes = spread_ ? spread_->scratch_bytes() : 0;
        for (Memory* m :
             {&needs_.constants, &needs_.state, &needs_.pressure, &needs_.response, &needs_.invalid, &needs_.scratch}) {
            m->alignment = std::max<VkDeviceSize>(device_.limits.minStorageBufferOffsetAlignment, sizeof(float));
            m->usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
        }
        if (device_.texels)
            for (Memory* m : {&needs_.constants, &needs_.state, &needs_.pressure, &needs_.scratch})
                m->usage |= VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
        if (writes_constants()) needs_.constants.usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
        if (copies()) needs_.scratch.usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
        if (copies()) needs_.response.usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
        if (streamed_.pads > 1)
            for (Memory* m : {&needs_.state, &needs_.pressure})
                m->usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    }
    void check_limits() const {
        const auto refuse = [](const char* parameter, const std::string& what, const char* limit,
                               VkDeviceSize allowed) {
            throw Error(Error::Code::bad_input, parameter,
                        what + "; allowed: " + limit + " = " + std::to_string(allowed));
        };
        const VkDeviceSize most = device_.limits.maxStorageBufferRange;
        if (streamed_.pads == 1 && table_.bytes > most)
            refuse("material",
                   std::to_string(materials_.size() / streamed_.skin.chain.length) +
                       " different materials in modulus and viscosity need " + std::to_string(table_.bytes) + " bytes",
                   "maxStorageBufferRange", most);
        if (streamed_.pads > 1) {
            const std::string pads = std::to_string(streamed_.pads) + " pads";
            for (VkDeviceSize bytes : {table_.bytes, needs_.state.bytes, needs_.pressure.bytes, needs_.response.bytes})
                if (bytes > most)
                    refuse("count", pads + " need " + std::to_string(bytes) + " bytes", "maxStorageBufferRange", most);
        }
        for (VkDeviceSize bytes : {sites_.bytes, needs_.response.bytes}) // fields are bound in row windows
            if (sites_.bytes > 0 && bytes > most)
                refuse("sites",
                       std::to_string(streamed_.skin.description.sites.size()) + " sites need " +
                           std::to_string(bytes) + " bytes",
                       "maxStorageBufferRange", most);
    }
    // Calls `update` between the barriers that keep it apart from earlier and later presses.
    template <class F> void between_presses(VkCommandBuffer commands, F update) const {
        constexpr VkPipelineStageFlags compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                       copy = VK_PIPELINE_STAGE_TRANSFER_BIT;
        // Earlier presses have read their coefficients, and their writes are in memory, before the new coefficients are
        // written.
        const Access written{copy, VK_ACCESS_TRANSFER_WRITE_BIT};
        barrier(device_.calls, commands, {compute | copy, VK_ACCESS_TRANSFER_WRITE_BIT}, written);
        update();
        barrier(device_.calls, commands, written, {compute, VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT});
    }

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
