// SPDX-License-Identifier: MIT
#include "host/vulkan/recorder.hpp"

#include "host/plan/float_environment.hpp"
#include "host/plan/laplacian.hpp"

#include <cstring>

namespace dermis::vulkan {
namespace {

constexpr VkDeviceSize slice_alignment = 256; // the greatest minStorageBufferOffsetAlignment that Vulkan allows

} // namespace

Recorder::Recorder(Pipelines& pipelines, plan::StreamedSkin&& streamed, uint32_t max_bindings)
    : device_(pipelines.device()), streamed_(std::move(streamed)), layout_(response_layout_of(streamed_)) {
    const plan::PreparedSkin& skin = streamed_.skin;
    if (skin.description.sites.empty())
        fields_.emplace(pipelines, skin, streamed_.variant(), skin.whole(), max_bindings);
    else sites_.emplace(pipelines, streamed_, layout_, max_bindings);
    if (sites_) {
        cells_ = append(sites_->cells());
        stencils_ = append(sites_->sites());
    } else {
        rest_ = append(plan::padded_rest_curvature<float>(skin));
        material_ = append(skin.material_of);
    }
    if (skin.tabled()) table_ = append(std::vector<f32::Coefficients>(materials().size()));
    fill_needs();
    check_limits();
    plan::drop_maps(streamed_.skin);
}

void Recorder::fill_needs() {
    const VkDeviceSize map = streamed_.skin.padded_cells() * sizeof(float);
    const VkDeviceSize planes = VkDeviceSize(state_planes(streamed_.variant()));
    needs_.constants.bytes = needs_.constants.initial.size();
    needs_.state.bytes = planes * (sites_ ? sites_->cells().size() * sizeof(float) : map);
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
}

void Recorder::check_limits() const {
    const auto refuse = [](const char* parameter, const std::string& what, const char* limit, VkDeviceSize allowed) {
        throw Error(Error::Code::bad_input, parameter, what + "; allowed: " + limit + " = " + std::to_string(allowed));
    };
    if (writes_constants() && materials().size() > most_materials)
        refuse("material", std::to_string(materials().size()) + " different materials in modulus and viscosity",
               "what vkCmdUpdateBuffer takes at once", most_materials);
    const VkDeviceSize most = device_.limits.maxStorageBufferRange;
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
    if (tables_.size() <= binding) tables_.resize(binding + 1);
    tables_[binding] = constant(table_);
    if (sites_)
        return sites_->bind(binding, {.pressure_from = range(b.pressure_from, needs_.pressure),
                                      .pressure_to = range(b.pressure_to, needs_.pressure),
                                      .cells = constant(cells_),
                                      .sites = constant(stencils_),
                                      .state_from = range(b.state_from, needs_.state),
                                      .state_to = range(b.state_to, needs_.state),
                                      .response = response,
                                      .coefficients = writes_constants() ? tables_[binding] : constant(cells_),
                                      .invalid = invalid});
    PressKernel::Maps m{.pressure_from = range(b.pressure_from, needs_.pressure),
                        .pressure_to = range(b.pressure_to, needs_.pressure),
                        .rest_curvature = constant(rest_),
                        .state_from = range(b.state_from, needs_.state),
                        .state_to = range(b.state_to, needs_.state),
                        .response = {},
                        .coefficients = writes_constants() ? tables_[binding] : invalid,
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
}

bool Recorder::fill(PressTable& table, double dt) const noexcept {
    const DefaultFloats guard;
    const plan::PreparedSkin& skin = streamed_.skin;
    return plan::fill_table(materials(), skin.chain, skin.rule, dt, table.of_material.data());
}

void Recorder::record(VkCommandBuffer commands, size_t binding, const PressTable& table) const noexcept {
    const DefaultFloats guard;
    if (writes_constants()) update_table(commands, binding, table.of_material.data());
    const f32::Constants c = plan::frame_constants(streamed_.skin, table.of_material.front());
    if (sites_) sites_->record(commands, binding, c);
    else fields_->record(commands, binding, c);
}

void Recorder::update_table(VkCommandBuffer commands, size_t binding, const f32::Coefficients* table) const noexcept {
    const auto barrier = [&](VkPipelineStageFlags from, VkPipelineStageFlags to, VkAccessFlags src, VkAccessFlags dst) {
        const VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, src, dst};
        device_.calls.vkCmdPipelineBarrier(commands, from, to, 0, 1, &memory, 0, nullptr, 0, nullptr);
    };
    constexpr VkPipelineStageFlags compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                   copy = VK_PIPELINE_STAGE_TRANSFER_BIT;
    // Earlier presses have read their coefficients; what they wrote is in memory before these are written.
    barrier(compute | copy, copy, VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_TRANSFER_WRITE_BIT);
    device_.calls.vkCmdUpdateBuffer(commands, tables_[binding].buffer, tables_[binding].offset, table_.bytes, table);
    barrier(copy, compute, VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_SHADER_READ_BIT);
}

} // namespace dermis::vulkan
