// SPDX-License-Identifier: MIT
// The kernels `halve` and `spread` over memory of the caller's: they spread the signals of classes to their depths, and
// answer there.
#pragma once

#include "host/core/model/streamed_skin.hpp"
#include "host/core/vulkan/recording.hpp"
#include "host/core/vulkan/windows.hpp"

#include <algorithm>
#include <map>

namespace dermis::vulkan {

static_assert(sizeof(f32::SpreadConstants) <= 128, "push constants: every device has 128 bytes");

class SpreadKernel {
  public:
    struct Maps {
        BufferRange scratch, weights, response;
        BufferRange pads; // the list of pads of a press; any range for a single skin
    };
    // pads_of_group: the list of pads ends with a workgroup of so many. Throws Error::bad_input for maps beyond the
    // limits of the device.
    SpreadKernel(Pipelines& pipelines, const model::StreamedSkin& s, const model::ResponseLayout& layout,
                 size_t pads_of_group, uint32_t max_bindings)
        : device_(pipelines.device()), pads_(s.pads) {
        constexpr int all = 128, most_x = 16; // invocations that every device allows
        const int x = std::min((s.skin.width() + four - 1) / four, most_x), z = int(pads_of_group);
        group_ = {x, std::clamp(all / (x * z), 1, pads_ > 1 ? s.skin.height() : 8), z};
        gain_ = take(grid_of(s.skin));
        std::array<Part, REDUCED_MAPS> fields; // of all cells
        for (int q = QUANTITY_SA1; q < REDUCED_MAPS; ++q) {
            if (!s.wanted[size_t(q)]) continue;
            signal_[size_t(q)] = take(grid_of(s.skin));
            const model::ResponseLayout::Range& r = layout.of[size_t(q)];
            Part& to = fields[size_t(q)];
            to = s.picked.empty() ? Part{r.first * sizeof(float), r.count * sizeof(float)}
                                  : take(s.skin.padded_cells() * size_t(s.pads));
            plan(s, q, to);
        }
        pick(s, layout, fields);
        std::ranges::reverse(passes_);
        if (weights_.empty()) weights_.push_back(0); // no range that is bound may be empty
        const VkDeviceSize most = device_.limits.maxStorageBufferRange;
        if (gain_.bytes > most)
            throw Error(Error::Code::bad_input, "receptors.depth",
                        "receptors.depth takes maps of " + std::to_string(gain_.bytes) +
                            " bytes for this grid; allowed: maxStorageBufferRange = " + std::to_string(most) +
                            "; or device cpu");
        for (const auto& [kind, uses] : kinds_) {
            const bool halve = int(kind[SPREAD_RADIUS]) == halves;
            kernels_.try_emplace(kind, pipelines, halve ? halve_module(device_.texels) : spread_module(device_.texels),
                                 kind, max_bindings * uint32_t(uses));
        }
    }
    // Floats that presses work in, zeros at first.
    VkDeviceSize scratch_bytes() const { return scratch_bytes_; }
    // Where `press` writes the signal of a class.
    BufferRange signal(int quantity, const BufferRange& scratch) const {
        return part_of(scratch, signal_[size_t(quantity)]);
    }
    BufferRange gain(const BufferRange& scratch) const { return part_of(scratch, gain_); } // and the cells' gain
    const std::vector<float>& weights() const { return weights_; }                         // of all levels
    void bind(size_t binding, const Maps& m) {
        if (copies_.size() <= binding) copies_.resize(binding + 1);
        copies_[binding] = {m.scratch.buffer, m.response.buffer, picks_};
        for (VkBufferCopy& r : copies_[binding].regions)
            r.srcOffset += m.scratch.offset, r.dstOffset += m.response.offset;
        for (auto& [kind, kernel] : kernels_) {
            std::vector<const Use*> uses(kinds_.at(kind));
            for (const std::vector<Use>& pass : passes_)
                for (const Use& use : pass)
                    if (*use.kernel == kind) uses[use.number] = &use;
            for (const Use* use : uses)
                kernel.bind(binding * uses.size() + use->number,
                            {{SPREAD_FINE, part_of(m.scratch, use->fine)},
                             {SPREAD_COARSE, part_of(m.scratch, use->coarse)},
                             {SPREAD_GAIN, gain(m.scratch)},
                             {SPREAD_TO, part_of(use->answers && picks_.empty() ? m.response : m.scratch, use->to)},
                             {SPREAD_WEIGHTS, m.weights},
                             {SPREAD_PADS, m.pads}});
        }
    }
    // Records what follows a press of the pads list[first] .. list[last - 1]. own: see PressKernel::record().
    void record(VkCommandBuffer commands, size_t binding, const model::PadList& list, size_t first_pad, size_t last_pad,
                Recording* own) const {
        constexpr VkPipelineStageFlags compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
        const uint32_t pads = uint32_t(last_pad - first_pad);
        for (const std::vector<Use>& pass : passes_) {
            if (pass.empty()) continue;
            barrier(device_.calls, commands, {compute, VK_ACCESS_SHADER_WRITE_BIT},
                    {compute, VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT});
            for (const Use& use : pass) {
                f32::SpreadConstants c = use.constants;
                const int most = int(std::clamp(device_.most_work / (use.work_of_row * pads), 1.0, 1e9));
                const size_t set = binding * kinds_.at(*use.kernel) + use.number;
                for (int y = c.y_low, last = c.y_high; y <= last; y += most) {
                    c.y_low = y, c.y_high = std::min(last, y + most - 1);
                    if (own) own->add(use.work_of_row * (c.y_high - y + 1) * pads);
                    const int first = c.x_low & ~(four - 1);
                    kernels_.at(*use.kernel)
                        .record(commands, set, &c, groups(c.x_high - first + 1, four * group_[0]),
                                groups(c.y_high - y + 1, group_[1]), groups(int(pads), group_[2]));
                }
            }
        }
        if (picks_.empty()) return;
        const auto& [from, to, regions] = copies_[binding];
        constexpr VkPipelineStageFlags copy = VK_PIPELINE_STAGE_TRANSFER_BIT;
        barrier(device_.calls, commands, {compute, VK_ACCESS_SHADER_WRITE_BIT}, {copy, VK_ACCESS_TRANSFER_READ_BIT});
        const size_t of_pad = regions.size() / size_t(pads_);
        for (size_t i = first_pad, next; i < last_pad;
             i = next) { // neighbouring pads at once; others keep their responses
            for (next = i + 1; next < last_pad && list[next] == list[i] + int(next - i);) ++next;
            device_.calls.vkCmdCopyBuffer(commands, from, to, uint32_t((next - i) * of_pad),
                                          regions.data() + size_t(list[i]) * of_pad);
        }
        barrier(device_.calls, commands, {copy, VK_ACCESS_TRANSFER_READ_BIT}, {compute, VK_ACCESS_SHADER_WRITE_BIT});
    }
    double work_of_pad() const { return work_; }
    bool copies() const { return !picks_.empty(); } // a press ends with a copy

  private:
    static constexpr int halves = -2;              // in place of a radius
    static constexpr int four = 4;                 // nodes of an invocation
    static constexpr VkDeviceSize alignment = 256; // bytes: the greatest offset alignment that Vulkan allows
    static constexpr size_t most_levels = 64;

    static model::SpreadLevel grid_of(const model::PreparedSkin& skin) {
        return {.x = {0, skin.width() - 1}, .y = {0, skin.height() - 1}};
    }
    using Specialization = std::vector<uint32_t>;
    struct Part { // of the scratch memory, in bytes
        VkDeviceSize first = 0, bytes = 0;
    };
    struct Use { // of a kernel, for one class
        f32::SpreadConstants constants;
        double work_of_row;
        const Specialization* kernel;
        size_t number; // among the uses of the kernel
        Part fine, coarse, to;
        bool answers; // `to` is a part of the response
    };
    static BufferRange part_of(const BufferRange& all, const Part& part) {
        return {all.buffer, all.offset + part.first, part.bytes};
    }
    f32::NodeMap map_of(const model::SpreadLevel& level) const {
        f32::NodeMap map{};
        map.pitch = (level.x.high + four) / four * four + 2 * SPREAD_MARGIN;
        map.pad = map.pitch * (level.y.high + 1 + 2 * SPREAD_MARGIN);
        return map;
    }
    Part take(size_t floats) {
        const Part part{scratch_bytes_, floats * sizeof(float)};
        scratch_bytes_ = (scratch_bytes_ + part.bytes + alignment - 1) / alignment * alignment;
        return part;
    }
    Part take(const model::SpreadLevel& level) {
        return take(size_t(map_of(level).pad) * size_t(pads_) + 2 * SPREAD_MARGIN);
    }
    void add(size_t pass, Use use, int radius, bool coarser) {
        Specialization kind(SPREAD_CONSTANTS);
        kind[SPREAD_RADIUS] = uint32_t(radius);
        kind[SPREAD_COARSER] = coarser;
        kind[SPREAD_ANSWERS] = use.answers;
        kind[SPREAD_OF_PADS] = pads_ > 1;
        std::ranges::copy(group_, kind.begin() + SPREAD_GROUP_X);
        const auto known = kinds_.try_emplace(kind, 0).first;
        use.kernel = &known->first;
        use.number = known->second++;
        const f32::SpreadConstants& c = use.constants;
        use.work_of_row = double(c.x_high - c.x_low + 1) * (4 + (radius + 1) * (radius + 1) / 2);
        work_ += use.work_of_row * (c.y_high - c.y_low + 1);
        if (passes_.size() <= pass) passes_.resize(pass + 1);
        passes_[pass].push_back(use);
    }
    // Plans the passes of a class, the last one first.
    void plan(const model::StreamedSkin& s, int quantity, const Part& response) {
        const model::Spread levels =
            s.spread[size_t(quantity)] ? *s.spread[size_t(quantity)] : model::Spread{grid_of(s.skin)};
        std::vector<Part> down{signal_[size_t(quantity)]}, up{response};
        for (size_t l = 1; l < levels.size(); ++l) down.push_back(take(levels[l])), up.push_back(take(levels[l]));
        Use use{};
        f32::SpreadConstants& c = use.constants;
        c.quantity = quantity;
        c.height = s.skin.height(), c.pitch = s.skin.pitch;
        c.gain_plus = float(s.skin.constants.gain_plus), c.gain_minus = float(s.skin.constants.gain_minus);
        const auto between = [&](size_t l, const std::vector<Part>& coarser, size_t made) {
            const size_t next = std::min(l + 1, levels.size() - 1);
            use.fine = down[l], c.fine = map_of(levels[l]);
            use.coarse = next == l ? down[l] : coarser[next], c.coarse = map_of(levels[next]);
            c.x_low = levels[made].x.low, c.x_high = levels[made].x.high;
            c.y_low = levels[made].y.low, c.y_high = levels[made].y.high;
        };
        for (size_t l = 0; l < levels.size(); ++l) {
            between(l, up, l);
            use.to = up[l];
            use.answers = l == 0;
            c.weights = int(weights_.size());
            weights_.insert(weights_.end(), levels[l].weights.begin(), levels[l].weights.end());
            add(l, use, levels[l].radius, l + 1 < levels.size());
        }
        use.answers = false;
        for (size_t l = 0; l + 1 < levels.size(); ++l) {
            between(l, down, l + 1);
            use.to = up[l + 1]; // which it does not write
            add(most_levels - l, use, halves, false);
        }
    }
    // Notes the sites that are picked from fields, pad by pad.
    void pick(const model::StreamedSkin& s, const model::ResponseLayout& layout,
              const std::array<Part, REDUCED_MAPS>& fields) {
        for (size_t pad = 0; pad < size_t(s.pads); ++pad)
            for (size_t i = 0; i < s.picked.size(); ++i) {
                const auto& [type, cell] = s.picked[i];
                const size_t q = size_t(type), of_pad = layout.of[q].count / size_t(s.pads),
                             at = (pad * size_t(s.skin.height()) + size_t(cell.y)) * size_t(s.skin.pitch) +
                                  size_t(cell.x);
                picks_.push_back({fields[q].first + at * sizeof(float), (layout.site[i] + pad * of_pad) * sizeof(float),
                                  sizeof(float)});
            }
    }

    const DeviceTable& device_;
    const int pads_;
    std::array<int, 3> group_; // size of a workgroup
    VkDeviceSize scratch_bytes_ = 0;
    std::array<Part, REDUCED_MAPS> signal_; // by quantity
    Part gain_;
    std::vector<float> weights_;
    std::map<Specialization, size_t> kinds_; // the number of uses of each kernel
    std::map<Specialization, Kernel> kernels_;
    std::vector<std::vector<Use>> passes_; // one after another
    double work_ = 0;
    std::vector<VkBufferCopy> picks_; // of sites, from fields in the scratch memory to the response, pad by pad
    struct Copy {
        VkBuffer from, to;
        std::vector<VkBufferCopy> regions;
    };
    std::vector<Copy> copies_; // the picks of each binding
};

} // namespace dermis::vulkan
