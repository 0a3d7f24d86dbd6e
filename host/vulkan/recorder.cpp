// SPDX-License-Identifier: MIT
#include "host/vulkan/recorder.hpp"

#include "host/plan/float_environment.hpp"
#include "host/plan/stepper.hpp"

#include <cstring>

namespace dermis::vulkan {
namespace {

constexpr VkDeviceSize part_alignment = 256;           // the most that a device may ask of an offset
constexpr size_t most_rows = 65536 / sizeof(f32::Coefficients); // what one vkCmdUpdateBuffer takes

} // namespace

Recorder::Recorder(Pipelines& pipelines, plan::Plan&& plan, uint32_t max_bindings)
    : device_(pipelines.gpu()), plan_(std::move(plan)), answers_(plan::response_layout_of(plan_)) {
    const bool sited = !plan_.scene.sites.empty();
    if (sited) sites_.emplace(pipelines, plan_, max_bindings);
    else fields_.emplace(pipelines, plan_, max_bindings);
    const bool uniform = plan_.material.empty();
    const VkDeviceSize map = VkDeviceSize(plan_.pitch) * VkDeviceSize(plan_.constants.height) * sizeof(float);
    VkDeviceSize state = VkDeviceSize(state_planes(plan_)) * map;
    if (sited) {
        cells_ = append(sites_->cells());
        looks_ = append(sites_->sites());
        state = VkDeviceSize(state_planes(plan_)) * sites_->cells().size() * sizeof(float);
    } else {
        rest_ = append(plan::padded<float>(plan_.maps.rest_curvature, plan_, "surface.relief"));
        material_ = append(plan_.material);
    }
    if (!uniform) table_ = append(std::vector<f32::Coefficients>(media().size()));
    needs_.constants.bytes = needs_.constants.initial.size();
    needs_.state.bytes = state;
    needs_.pressure.bytes = map;
    needs_.response.bytes = answers_.all * sizeof(float);
    needs_.invalid.bytes = sizeof(uint32_t);
    for (Memory* m : {&needs_.constants, &needs_.state, &needs_.pressure, &needs_.response, &needs_.invalid}) {
        m->alignment = std::max<VkDeviceSize>(device_.limits.minStorageBufferOffsetAlignment, sizeof(float));
        m->usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    }
    if (!uniform) needs_.constants.usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    check_limits();
    plan_.maps = {}; // they stand in the constants
}

void Recorder::check_limits() const {
    const auto refuse = [](const char* parameter, const std::string& what, const char* limit, VkDeviceSize allowed) {
        throw Error(Error::Code::bad_input, parameter, what + "; allowed: " + limit + " = " + std::to_string(allowed));
    };
    if (table_.bytes > 0 && media().size() > most_rows)
        refuse("material", std::to_string(media().size()) + " different materials in modulus and viscosity",
               "what vkCmdUpdateBuffer takes at once", most_rows);
    const VkDeviceSize most = device_.limits.maxStorageBufferRange;
    if (!sites_) return; // fields go in bands
    for (VkDeviceSize bytes : {cells_.bytes, looks_.bytes, needs_.state.bytes})
        if (bytes > most)
            refuse("sites",
                   std::to_string(plan_.scene.sites.size()) + " sites need " + std::to_string(bytes) + " bytes",
                   "maxStorageBufferRange", most);
}

template <class T> Recorder::Part Recorder::append(const std::vector<T>& values) {
    std::vector<unsigned char>& all = needs_.constants.initial;
    const Part part{(all.size() + part_alignment - 1) / part_alignment * part_alignment, values.size() * sizeof(T)};
    if (values.empty()) return part;
    all.resize(part.offset + part.bytes);
    std::memcpy(all.data() + part.offset, values.data(), part.bytes);
    return part;
}

void Recorder::bind(size_t binding, const Buffers& b) {
    const auto piece = [](const VkDescriptorBufferInfo& i, const Memory& m) {
        return Piece{i.buffer, i.offset, m.bytes};
    };
    const auto constant = [&](const Part& p) {
        return Piece{b.constants.buffer, b.constants.offset + p.offset, p.bytes};
    };
    const Piece from = piece(b.pressure_from, needs_.pressure), to = piece(b.pressure_to, needs_.pressure);
    const Piece state_from = piece(b.state_from, needs_.state), state_to = piece(b.state_to, needs_.state);
    const Piece response = piece(b.response, needs_.response), invalid = piece(b.invalid, needs_.invalid);
    if (tables_.size() <= binding) tables_.resize(binding + 1);
    tables_[binding] = constant(table_);
    if (sites_)
        return sites_->bind(binding, {from, to, constant(cells_), constant(looks_), state_from, state_to, response,
                                      table_.bytes ? tables_[binding] : constant(cells_), invalid});
    Press::Maps m{from, to, constant(rest_), state_from, state_to, {}, invalid, invalid, invalid};
    if (table_.bytes) m.rows = tables_[binding], m.material = constant(material_);
    for (int q = 1; q < REDUCED_MAPS; ++q) {
        const plan::ResponseLayout::Range& r = answers_.of[size_t(q)];
        m.response[q - 1] =
            plan_.wanted[q] ? Piece{response.buffer, response.offset + r.first * sizeof(float), r.count * sizeof(float)}
                            : invalid;
    }
    fields_->bind(binding, m);
}

bool Recorder::in_float(double dt) const noexcept {
    const DefaultFloats guard;
    return plan::in_float(media(), dt);
}

void Recorder::record(VkCommandBuffer commands, size_t binding, double dt) const noexcept {
    const DefaultFloats guard;
    if (table_.bytes) {
        const auto barrier = [&](VkPipelineStageFlags from, VkPipelineStageFlags to, VkAccessFlags src,
                                 VkAccessFlags dst) {
            const VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, src, dst};
            device_.calls.vkCmdPipelineBarrier(commands, from, to, 0, 1, &memory, 0, nullptr, 0, nullptr);
        };
        constexpr VkPipelineStageFlags compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                       copy = VK_PIPELINE_STAGE_TRANSFER_BIT;
        std::array<f32::Coefficients, most_rows> rows;
        for (size_t i = 0; i < media().size(); ++i) rows[i] = plan::rounded<f32::Coefficients>(plan::exact_coefficients(media()[i], dt));
        barrier(compute, copy, 0, 0); // presses before have read their rows
        device_.calls.vkCmdUpdateBuffer(commands, tables_[binding].buffer, tables_[binding].offset, table_.bytes,
                                     rows.data());
        barrier(copy, compute, VK_ACCESS_TRANSFER_WRITE_BIT, VK_ACCESS_SHADER_READ_BIT);
    }
    const auto c = plan::frame_constants<f32::Constants>(plan_, media().front(), dt);
    if (sites_) sites_->record(commands, binding, c);
    else fields_->record(commands, binding, c);
}

} // namespace dermis::vulkan
