// SPDX-License-Identifier: MIT
#include "host/vulkan/recorder.hpp"

#include "host/plan/laplacian.hpp"
#include "host/scene/float_environment.hpp"

#include <algorithm>
#include <cstring>
#include <span>

namespace dermis::vulkan {
namespace {

constexpr VkDeviceSize slice_alignment = 256; // the greatest minStorageBufferOffsetAlignment that Vulkan allows
constexpr size_t of_update = 65536;           // bytes that one vkCmdUpdateBuffer takes

} // namespace

Recorder::Recorder(Pipelines& pipelines, plan::StreamedSkin&& streamed, uint32_t max_bindings)
    : device_(pipelines.device()), streamed_(std::move(streamed)), layout_(response_layout_of(streamed_)) {
    const plan::PreparedSkin& skin = streamed_.skin;
    if (skin.description.sites.empty())
        fields_.emplace(pipelines, skin, streamed_.variant(), skin.whole(), max_bindings);
    else sites_.emplace(pipelines, streamed_, layout_, max_bindings);
    if (fields_ && streamed_.pads > 1 && !skin.tabled() && streamed_.elements_of_pad.empty()) {
        plan::Variant alike = streamed_.variant();
        alike.pads = plan::Variant::Pads::alike;
        alike_.emplace(pipelines, skin, alike, skin.whole(), max_bindings);
    }
    materials_ = sites_ ? sites_->materials() : skin.materials;
    if (sites_) {
        cells_ = append(sites_->cells());
        stencils_ = append(sites_->sites());
    } else {
        rest_ = append(plan::padded_rest_curvature<float>(skin));
        material_ = append(skin.material_of);
    }
    if (streamed_.pads > 1)
        table_ = append(std::vector<f32::Coefficients>(behind_list() + size_t(streamed_.pads) * table_length()));
    else if (skin.tabled()) table_ = append(std::vector<f32::Coefficients>(materials().size()));
    fill_needs();
    check_limits();
    plan::drop_maps(streamed_.skin);
}

void Recorder::fill_needs() {
    const VkDeviceSize pads = VkDeviceSize(streamed_.pads), map = pads * streamed_.skin.padded_cells() * sizeof(float);
    const VkDeviceSize planes = VkDeviceSize(state_planes(streamed_.variant()));
    needs_.constants.bytes = needs_.constants.initial.size();
    needs_.state.bytes = planes * (sites_ ? pads * sites_->cells().size() * sizeof(float) : map);
    needs_.pressure.bytes = map;
    needs_.response.bytes = layout_.all * sizeof(float);
    needs_.invalid.bytes = sizeof(uint32_t);
    for (Memory* m : {&needs_.constants, &needs_.state, &needs_.pressure, &needs_.response, &needs_.invalid}) {
        m->alignment = std::max<VkDeviceSize>(device_.limits.minStorageBufferOffsetAlignment, sizeof(float));
        m->usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    }
    if (fields_ && device_.texels)
        for (Memory* m : {&needs_.constants, &needs_.state, &needs_.pressure})
            m->usage |= VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    if (writes_constants()) needs_.constants.usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (streamed_.pads > 1)
        for (Memory* m : {&needs_.state, &needs_.pressure})
            m->usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
}

void Recorder::check_limits() const {
    const auto refuse = [](const char* parameter, const std::string& what, const char* limit, VkDeviceSize allowed) {
        throw Error(Error::Code::bad_input, parameter, what + "; allowed: " + limit + " = " + std::to_string(allowed));
    };
    if (writes_constants() && materials().size() > most_materials)
        refuse("material", std::to_string(materials().size()) + " different materials in modulus and viscosity",
               "what vkCmdUpdateBuffer takes at once", most_materials);
    const VkDeviceSize most = device_.limits.maxStorageBufferRange;
    if (streamed_.pads > 1) {
        const std::string pads = std::to_string(streamed_.pads) + " pads";
        if (uint32_t(streamed_.pads) > device_.limits.maxComputeWorkGroupCount[2])
            refuse("count", pads, "maxComputeWorkGroupCount[2]", device_.limits.maxComputeWorkGroupCount[2]);
        for (VkDeviceSize bytes : {table_.bytes, needs_.state.bytes, needs_.pressure.bytes, needs_.response.bytes})
            if (bytes > most)
                refuse("count", pads + " need " + std::to_string(bytes) + " bytes", "maxStorageBufferRange", most);
    }
    if (!sites_) return; // fields are bound in row windows
    for (VkDeviceSize bytes : {cells_.bytes, stencils_.bytes, needs_.state.bytes})
        if (bytes > most)
            refuse("sites",
                   std::to_string(streamed_.skin.description.sites.size()) + " sites need " + std::to_string(bytes) +
                       " bytes",
                   "maxStorageBufferRange", most);
}

template <class T> Recorder::Slice Recorder::append(const std::vector<T>& values) {
    std::vector<unsigned char>& all = needs_.constants.initial;
    const Slice slice{(all.size() + slice_alignment - 1) / slice_alignment * slice_alignment,
                      values.size() * sizeof(T)};
    if (values.empty()) return slice;
    all.resize(slice.offset + slice.bytes);
    std::memcpy(all.data() + slice.offset, values.data(), slice.bytes);
    return slice;
}

void Recorder::bind(size_t binding, const Buffers& b) {
    const auto range = [](const VkDescriptorBufferInfo& i, const Memory& m) {
        return BufferRange{i.buffer, i.offset, m.bytes};
    };
    const auto constant = [&](const Slice& s) {
        return BufferRange{b.constants.buffer, b.constants.offset + s.offset, s.bytes};
    };
    const BufferRange response = range(b.response, needs_.response), invalid = range(b.invalid, needs_.invalid);
    if (bound_.size() <= binding) bound_.resize(binding + 1);
    bound_[binding] = {constant(table_), b.state_from, b.state_to, b.pressure_from, b.pressure_to};
    if (sites_)
        return sites_->bind(binding, {.pressure_from = range(b.pressure_from, needs_.pressure),
                                      .pressure_to = range(b.pressure_to, needs_.pressure),
                                      .cells = constant(cells_),
                                      .sites = constant(stencils_),
                                      .state_from = range(b.state_from, needs_.state),
                                      .state_to = range(b.state_to, needs_.state),
                                      .response = response,
                                      .coefficients = writes_constants() ? bound_[binding].table : constant(cells_),
                                      .invalid = invalid});
    PressKernel::Maps m{.pressure_from = range(b.pressure_from, needs_.pressure),
                        .pressure_to = range(b.pressure_to, needs_.pressure),
                        .rest_curvature = constant(rest_),
                        .state_from = range(b.state_from, needs_.state),
                        .state_to = range(b.state_to, needs_.state),
                        .response = {},
                        .coefficients = writes_constants() ? bound_[binding].table : invalid,
                        .material = streamed_.skin.uniform() ? invalid : constant(material_),
                        .invalid = invalid};
    for (size_t i = 0; i < m.response.size(); ++i) {
        const plan::ResponseLayout::Range& r = layout_.of[QUANTITY_SA1 + i];
        m.response[i] =
            streamed_.wanted[QUANTITY_SA1 + i]
                ? BufferRange{response.buffer, response.offset + r.first * sizeof(float), r.count * sizeof(float)}
                : invalid;
    }
    fields_->bind(binding, m);
    if (alike_) alike_->bind(binding, m);
}

bool Recorder::fill(PressTable& table, double dt) const noexcept {
    const DefaultFloats guard;
    return fill_table(table.of_material.data(), 0, dt);
}

void Recorder::record(VkCommandBuffer commands, size_t binding, const PressTable& table) const noexcept {
    const DefaultFloats guard;
    if (writes_constants()) update_table(commands, binding, table.of_material.data());
    const f32::Constants c = plan::frame_constants(streamed_.skin, table.of_material.front());
    if (sites_) sites_->record(commands, binding, c);
    else fields_->record(commands, binding, c);
}

template <class F> void Recorder::between_presses(VkCommandBuffer commands, F update) const noexcept {
    const auto barrier = [&](VkPipelineStageFlags from, VkPipelineStageFlags to, VkAccessFlags src, VkAccessFlags dst) {
        const VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, src, dst};
        device_.calls.vkCmdPipelineBarrier(commands, from, to, 0, 1, &memory, 0, nullptr, 0, nullptr);
    };
    constexpr VkPipelineStageFlags compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                   copy = VK_PIPELINE_STAGE_TRANSFER_BIT;
    // Earlier presses have read their coefficients; what they wrote is in memory before these are written.
    barrier(compute | copy, copy, VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_TRANSFER_WRITE_BIT);
    update();
    barrier(copy, compute, VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);
}

void Recorder::update_table(VkCommandBuffer commands, size_t binding, const f32::Coefficients* table) const noexcept {
    const BufferRange& to = bound_[binding].table;
    between_presses(commands,
                    [&] { device_.calls.vkCmdUpdateBuffer(commands, to.buffer, to.offset, table_.bytes, table); });
}

size_t Recorder::behind_list() const {
    const size_t bytes = size_t(streamed_.pads) * sizeof(f32::PadEntry);
    return (bytes + sizeof(f32::Coefficients) - 1) / sizeof(f32::Coefficients);
}

bool Recorder::fill_table(f32::Coefficients* table, int pad, double dt) const noexcept {
    const plan::PreparedSkin& skin = streamed_.skin;
    const std::vector<plan::Element>& own = streamed_.elements_of_pad;
    const std::span<const plan::Element> elements =
        own.empty() ? std::span(materials_) : std::span(own).subspan(size_t(pad) * table_length(), table_length());
    return plan::fill_table(elements, skin.chain, skin.rule, dt, table);
}

void Recorder::update(VkCommandBuffer commands, size_t binding, size_t offset, const void* from,
                      size_t bytes) const noexcept {
    const BufferRange& to = bound_[binding].table;
    device_.calls.vkCmdUpdateBuffer(commands, to.buffer, to.offset + offset, bytes, from);
}

void Recorder::update_list(VkCommandBuffer commands, size_t binding, const plan::PadList& pads,
                           bool tables_alike) const noexcept {
    const size_t length = table_length(), tables = behind_list();
    std::array<f32::PadEntry, of_update / sizeof(f32::PadEntry)> entries;
    for (size_t i = 0, n = 0; i < pads.count; ++i) {
        entries[n].pad = pads[i];
        entries[n++].table = int(tables + (tables_alike ? 0 : i * length));
        if (n < entries.size() && i + 1 < pads.count) continue;
        update(commands, binding, (i + 1 - n) * sizeof(f32::PadEntry), entries.data(), n * sizeof(f32::PadEntry));
        n = 0;
    }
}

void Recorder::update_tables(VkCommandBuffer commands, size_t binding, const plan::PadList& pads,
                             const plan::StepLengths& dt) const noexcept {
    PressTable table;
    const size_t length = table_length(), at_once = std::max<size_t>(most_materials / length, 1),
                 count = pads_alike(dt) ? 1 : pads.count;
    for (size_t i = 0, n = 0; i < count; ++i) {
        (void)fill_table(table.of_material.data() + n++ * length, pads[i], dt[i]); // true: it was checked
        if (n < at_once && i + 1 < count) continue;
        update(commands, binding, (behind_list() + (i + 1 - n) * length) * sizeof(f32::Coefficients),
               table.of_material.data(), n * length * sizeof(f32::Coefficients));
        n = 0;
    }
}

void Recorder::copy_others(VkCommandBuffer commands, size_t binding, const plan::PadList& pads) const noexcept {
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

bool Recorder::accepts(const plan::PadList& pads, const plan::StepLengths& dt) const noexcept {
    const DefaultFloats guard;
    PressTable table;
    for (size_t i = 0; i < (pads_alike(dt) ? 1 : pads.count); ++i)
        if (!fill_table(table.of_material.data(), pads.count ? pads[i] : 0, dt[i])) return false;
    return true;
}

void Recorder::record(VkCommandBuffer commands, size_t binding, const plan::PadList& pads,
                      const plan::StepLengths& dt) const noexcept {
    const DefaultFloats guard;
    const bool from_constants = alike_ && pads_alike(dt);
    between_presses(commands, [&] {
        copy_others(commands, binding, pads);
        if (pads.count > 0) update_list(commands, binding, pads, pads_alike(dt));
        if (pads.count > 0 && !from_constants) update_tables(commands, binding, pads, dt);
    });
    if (pads.count == 0) return;
    f32::Coefficients only{};
    if (from_constants) (void)fill_table(&only, pads[0], dt[0]); // true: it was checked
    const f32::Constants c = plan::frame_constants(streamed_.skin, only);
    const uint32_t count = uint32_t(pads.count);
    if (sites_) sites_->record(commands, binding, c, count);
    else (from_constants ? alike_ : fields_)->record(commands, binding, c, count);
}

void Recorder::set_elements(const plan::PadList& pads, const std::vector<plan::Element>& elements) {
    if (streamed_.elements_of_pad.empty()) materials_ = elements;
    else
        for (size_t i = 0; i < pads.count; ++i)
            std::ranges::copy(elements, streamed_.elements_of_pad.begin() + long(size_t(pads[i]) * elements.size()));
}

} // namespace dermis::vulkan
