// SPDX-License-Identifier: MIT
#include "host/core/vulkan/spread_kernel.hpp"

#include "host/core/vulkan/windows.hpp"

#include <algorithm>

namespace dermis::vulkan {

static_assert(sizeof(f32::SpreadConstants) <= 128, "push constants: every device has 128 bytes");

namespace {

constexpr uint32_t halve_key = ~0u; // in place of a radius
constexpr int four = 4;             // nodes of an invocation
constexpr size_t alignment = 64;    // floats: 256 bytes, the greatest offset alignment that Vulkan allows
constexpr size_t most_levels = 64;

const model::SpreadLevel& level_of(const model::Spread& levels, size_t l) {
    return levels[std::min(l, levels.size() - 1)];
}

} // namespace

SpreadKernel::SpreadKernel(Pipelines& pipelines, const model::StreamedSkin& s, const model::ResponseLayout& layout,
                           size_t pads_of_group, uint32_t max_bindings)
    : pipelines_(pipelines), device_(pipelines.device()), max_bindings_(max_bindings), stencil_(s.skin.stencil),
      edges_(s.skin.edges), pads_(s.pads) {
    constexpr int all = 128, most_x = 16; // invocations that every device allows
    const int x = std::min((s.skin.width() + four - 1) / four, most_x), z = int(pads_of_group);
    group_ = {x, std::clamp(all / (x * z), 1, pads_ > 1 ? s.skin.height() : 8), z};
    const model::SpreadLevel grid{{0, s.skin.width() - 1}, {0, s.skin.height() - 1}};
    const model::Wanted signals = s.signals();
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
        if (signals[size_t(q)]) signal_[size_t(q)] = take(grid);
    for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
        if (s.wanted[size_t(q)]) plan(s, q, s.picked.empty() ? int(layout.of[size_t(q)].first) : pick(s, layout, q));
    std::ranges::reverse(passes_);
    if (scratch_bytes() > device_.limits.maxStorageBufferRange)
        throw Error(Error::Code::bad_input, "receptors.depth",
                    "receptors.depth of " + std::to_string(s.pads) + " x " + std::to_string(s.skin.width()) + " x " +
                        std::to_string(s.skin.height()) + " cells takes " + std::to_string(scratch_bytes()) +
                        " bytes; allowed: maxStorageBufferRange = " +
                        std::to_string(device_.limits.maxStorageBufferRange) + "; or device cpu");
}

f32::NodeMap SpreadKernel::map_of(const model::SpreadLevel& level, int first) const {
    f32::NodeMap map{};
    map.first = first;
    map.pitch = (level.x.high + four) / four * four + 2 * SPREAD_MARGIN;
    map.pad = map.pitch * (level.y.high + 1 + 2 * SPREAD_MARGIN);
    return map;
}

// Takes memory for a level of all pads. Returns its first float.
int SpreadKernel::take(const model::SpreadLevel& level) {
    const size_t first = floats_;
    floats_ += size_t(map_of(level, 0).pad) * size_t(pads_) + SPREAD_MARGIN;
    floats_ = (floats_ + alignment - 1) / alignment * alignment;
    return int(std::min(first, size_t(INT32_MAX))); // more is refused
}

// Takes memory for the field of a class, and notes the sites that are picked from it. Returns its first float.
int SpreadKernel::pick(const model::StreamedSkin& s, const model::ResponseLayout& layout, int quantity) {
    const size_t field = floats_, cells = s.skin.padded_cells(),
                 of_pad = layout.of[size_t(quantity)].count / size_t(s.pads);
    floats_ = (floats_ + cells * size_t(s.pads) + alignment - 1) / alignment * alignment;
    for (size_t i = 0; i < s.picked.size(); ++i) {
        const auto& [type, cell] = s.picked[i];
        const size_t at = field + size_t(cell.y) * size_t(s.skin.pitch) + size_t(cell.x);
        for (size_t pad = 0; int(type) == quantity && pad < size_t(s.pads); ++pad)
            picks_.push_back(
                {(at + pad * cells) * sizeof(float), (layout.site[i] + pad * of_pad) * sizeof(float), sizeof(float)});
    }
    return int(std::min(field, size_t(INT32_MAX)));
}

const Kernel& SpreadKernel::kernel_of(const Module& module, int radius, bool coarser, bool answers) {
    std::vector<uint32_t> constants(SPREAD_CONSTANTS);
    constants[SPREAD_RADIUS] = uint32_t(radius);
    constants[SPREAD_COARSER] = coarser;
    constants[SPREAD_ANSWERS] = answers;
    constants[SPREAD_STENCIL] = uint32_t(stencil_);
    constants[SPREAD_EDGES] = uint32_t(edges_);
    constants[SPREAD_OF_PADS] = pads_ > 1;
    std::ranges::copy(group_, constants.begin() + SPREAD_GROUP_X);
    for (const auto& [known, kernel] : kernels_)
        if (known == constants) return kernel;
    return kernels_
        .emplace_back(std::piecewise_construct, std::forward_as_tuple(constants),
                      std::forward_as_tuple(pipelines_, module,
                                            KernelOptions{.bindings = SPREAD_BINDINGS,
                                                          .constants_bytes = sizeof(f32::SpreadConstants),
                                                          .specialization = constants,
                                                          .max_sets = max_bindings_}))
        .second;
}

void SpreadKernel::add(size_t pass, const Kernel& kernel, const f32::SpreadConstants& c, int radius) {
    if (passes_.size() <= pass) passes_.resize(pass + 1);
    const double work = double(c.x_high - c.x_low + 1) * (4 + (radius + 1) * (radius + 1) / 2);
    passes_[pass].push_back({&kernel, c, work});
    work_ += work * (c.y_high - c.y_low + 1);
}

// Plans the passes of a class, the last one first. response: its first float there.
void SpreadKernel::plan(const model::StreamedSkin& s, int quantity, int response) {
    const auto& constants = s.skin.constants;
    const model::SpreadLevel grid{{0, s.skin.width() - 1}, {0, s.skin.height() - 1}};
    const model::Spread levels = s.spread[size_t(quantity)] ? *s.spread[size_t(quantity)] : model::Spread{grid};
    const bool texels = device_.texels;
    std::vector<int> down{signal_[size_t(quantity)]}, up{0};
    for (size_t l = 1; l < levels.size(); ++l) down.push_back(take(levels[l])), up.push_back(take(levels[l]));
    f32::SpreadConstants c{};
    c.quantity = quantity;
    c.width = s.skin.width(), c.height = s.skin.height(), c.pitch = s.skin.pitch;
    c.bend = float(constants.bend), c.curvature_length = float(constants.curvature_length);
    c.gain_plus = float(constants.gain_plus), c.gain_minus = float(constants.gain_minus);
    c.strain = constants.curvature_length != 0 ? signal_[QUANTITY_SA1] : -1;
    const auto range = [&](const model::SpreadLevel& of) {
        c.x_low = of.x.low, c.x_high = of.x.high, c.y_low = of.y.low, c.y_high = of.y.high;
    };
    for (size_t l = 0; l < levels.size(); ++l) {
        const bool coarser = l + 1 < levels.size();
        const model::SpreadLevel &own = levels[l], &next = level_of(levels, l + 1);
        c.fine = map_of(own, down[l]);
        c.coarse = map_of(next, coarser ? up[l + 1] : 0);
        c.to = l == 0 ? response : up[l];
        c.weights = int(weights_.size());
        weights_.insert(weights_.end(), own.weights.begin(), own.weights.end());
        range(l == 0 ? grid : own);
        add(l, kernel_of(texels ? spread_texels_module() : spread_module(), own.radius, coarser, l == 0), c,
            own.radius);
    }
    for (size_t l = 0; l + 1 < levels.size(); ++l) {
        c.fine = map_of(levels[l], down[l]);
        c.coarse = map_of(levels[l + 1], down[l + 1]);
        c.to = down[l + 1];
        range(levels[l + 1]);
        add(most_levels - l, kernel_of(texels ? halve_texels_module() : halve_module(), int(halve_key), false, false),
            c, 3);
    }
}

void SpreadKernel::bind(size_t binding, const Maps& m) {
    if (bound_.size() <= binding) bound_.resize(binding + 1);
    bound_[binding] = {m.scratch, m.response};
    for (auto& [key, kernel] : kernels_)
        kernel.bind(binding, {{SPREAD_FROM, m.scratch},
                              {SPREAD_TO, m.scratch},
                              {SPREAD_WEIGHTS, m.weights},
                              {SPREAD_REST_CURVATURE, m.rest_curvature},
                              {SPREAD_RESPONSE, picks_.empty() ? m.response : m.scratch},
                              {SPREAD_PADS, m.pads}});
}

void SpreadKernel::record(VkCommandBuffer commands, size_t binding, uint32_t pads, Recording* own) const {
    constexpr VkPipelineStageFlags compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    for (const std::vector<Dispatch>& pass : passes_) {
        if (pass.empty()) continue;
        barrier(device_.calls, commands, {compute, VK_ACCESS_SHADER_WRITE_BIT},
                {compute, VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT});
        for (const Dispatch& d : pass) {
            f32::SpreadConstants c = d.constants;
            const int most = int(std::clamp(device_.most_work / (d.work_of_row * pads), 1.0, 1e9));
            for (int y = c.y_low, last = c.y_high; y <= last; y += most) {
                c.y_low = y, c.y_high = std::min(last, y + most - 1);
                if (own) own->add(d.work_of_row * (c.y_high - y + 1) * pads);
                const int first = c.x_low & ~(four - 1);
                d.kernel->record(commands, binding, &c, groups(c.x_high - first + 1, four * group_[0]),
                                 groups(c.y_high - y + 1, group_[1]), groups(int(pads), group_[2]));
            }
        }
    }
    if (picks_.empty()) return;
    const auto& [scratch, response] = bound_[binding];
    constexpr VkPipelineStageFlags copy = VK_PIPELINE_STAGE_TRANSFER_BIT;
    barrier(device_.calls, commands, {compute, VK_ACCESS_SHADER_WRITE_BIT}, {copy, VK_ACCESS_TRANSFER_READ_BIT});
    std::vector<VkBufferCopy> regions = picks_;
    for (VkBufferCopy& r : regions) r.srcOffset += scratch.offset, r.dstOffset += response.offset;
    device_.calls.vkCmdCopyBuffer(commands, scratch.buffer, response.buffer, uint32_t(regions.size()), regions.data());
    barrier(device_.calls, commands, {copy, VK_ACCESS_TRANSFER_READ_BIT}, {compute, VK_ACCESS_SHADER_WRITE_BIT});
}

} // namespace dermis::vulkan
