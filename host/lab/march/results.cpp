// SPDX-License-Identifier: MIT
#include "host/lab/march/results.hpp"

#include <algorithm>

namespace dermis::vulkan {
namespace {

using Summary = f32::Summary;

constexpr double ring_bytes = 16e6;

} // namespace

Results::Results(Context& context, const plan::PreparedSkin& skin, const plan::Schedule& schedule)
    : skin_(skin), schedule_(schedule),
      slot_bytes_(VkDeviceSize(REDUCED_MAPS) * (tiles() + probes()) * sizeof(Summary)) {
    const double room = std::min(ring_bytes, double(context.limits().maxStorageBufferRange)) / double(slot_bytes_);
    slots_ = size_t(std::clamp(room, 1.0, 1024.0));
}

void Results::allocate(Context& context, const plan::Variant& variant, const MarchMemory& memory,
                       const std::vector<RowWindow>& windows) {
    using Name = MarchMemory::Name;
    windows_ = windows;
    planes_ = variant.state().planes();
    summaries_ = std::make_unique<Buffer>(context, bytes(), Buffer::Location::host);
    probe_cells_ =
        std::make_unique<Buffer>(context, std::max<size_t>(probes(), 1) * sizeof(int), Buffer::Location::host);
    for (size_t i = 0; i < probes(); ++i) {
        const Cell p = schedule_.points[i];
        static_cast<int*>(probe_cells_->data())[i] = p.y * skin_.pitch + p.x;
    }
    Pipelines& pipelines = context.pipelines();
    const DeviceTable& device = pipelines.device();
    reduce_ = std::make_unique<Kernel>(pipelines, device.texels ? reduce_texels_module() : reduce_module(),
                                       KernelOptions{.bindings = REDUCE_BINDINGS,
                                                     .constants_bytes = sizeof(f32::ReduceConstants),
                                                     .specialization = {},
                                                     .max_sets = maps * uint32_t(windows.size())});
    size_t set = 0;
    for (int map = state0; map < maps; ++map)
        for (const RowWindow& window : windows) {
            // A response that is not asked for is never reduced: a state is bound in its place.
            const bool response = map >= responses && variant.wanted[size_t(map - responses + QUANTITY_SA1)];
            const BufferRange range = memory.range(response ? MarchMemory::response(map - responses + QUANTITY_SA1)
                                                            : Name::state0 + (map == state1));
            reduce_->bind(set++, {{REDUCE_MAP, window.of(range, skin_.pitch, response ? 1 : planes_)},
                                  {REDUCE_PROBES, probe_cells_->all()},
                                  {REDUCE_SUMMARIES, summaries_->all()}});
        }
}

void Results::clear(const Context& context, VkCommandBuffer commands) const {
    context.calls().vkCmdFillBuffer(commands, summaries_->handle(), 0, VK_WHOLE_SIZE, 0);
}

int Results::record(Recording& recording, const plan::Step& step, int state) {
    const plan::PressedBox& box = schedule_.pressed;
    const VkCommandBuffer commands = recording.commands();
    const int tiles = std::max(box.last_tile - box.first_tile, 1);
    int dispatches = 0;
    for (int q = 0; q < REDUCED_MAPS; ++q) {
        if (!schedule_.wanted[size_t(q)]) continue;
        const bool strain = q == QUANTITY_STRAIN;
        const size_t map = strain ? size_t(state0 + state) : size_t(responses + q - QUANTITY_SA1);
        for (size_t i = 0; i < windows_.size(); ++i) {
            const RowWindow& window = windows_[i];
            if (window.rows() == 0) continue;
            f32::ReduceConstants c{};
            c.width = skin_.width();
            c.height = skin_.height();
            c.pitch = skin_.pitch;
            c.tiles = skin_.tiles;
            c.stride = strain ? skin_.pitch * planes_ : skin_.pitch;
            c.first_tile = box.first_tile;
            c.first_row = window.first;
            c.rows = window.rows();
            c.base_row = window.base;
            c.probes = int(probes());
            c.slot = int(steps_.size()) * REDUCED_MAPS + q;
            recording.add(double(window.rows()) * tiles * TILE_CELLS);
            reduce_->record(commands, map * windows_.size() + i, &c, groups(window.rows() + int(probes()), REDUCE_ROWS),
                            uint32_t(tiles));
        }
        ++dispatches;
    }
    steps_.push_back(step);
    return dispatches;
}

void Results::hand_over(const plan::Stepper::Sink& sink) {
    const auto* map = static_cast<const Summary*>(summaries_->data());
    for (const plan::Step& step : steps_) {
        plan::Sample sample{};
        for (size_t q = 0; q < REDUCED_MAPS; ++q, map += tiles() + probes()) {
            sample.totals[q] = plan::total_of<f32>(map, tiles(), skin_.cells());
            for (size_t i = 0; i < probes(); ++i) sample.points.push_back(double(map[tiles() + i].sum));
        }
        sink(step, sample);
    }
    steps_.clear();
}

} // namespace dermis::vulkan
