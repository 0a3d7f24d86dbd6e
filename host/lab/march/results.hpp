// SPDX-License-Identifier: MIT
// A ring of result slots: the device reduces each responding step into a slot, and the host reads the slots after a
// submission.
#pragma once

#include "host/core/base/pool.hpp"
#include "host/core/vulkan/recording.hpp"
#include "host/lab/march/march_memory.hpp"

#include <algorithm>

namespace dermis::vulkan {

class Results {
  public:
    // Chooses the number of slots.
    Results(Context& context, const model::MarchPlan& plan)
        : plan_(plan), slot_bytes_(VkDeviceSize(REDUCED_MAPS) * (tiles() + probes()) * sizeof(f32::Summary)),
          pool_(simd::useful_threads(plan.skin.cells(), 0)) {
        constexpr double ring_bytes = 16e6;
        const double room = std::min(ring_bytes, double(context.limits().maxStorageBufferRange)) / double(slot_bytes_);
        slots_ = size_t(std::clamp(room, 1.0, 1024.0));
    }

    size_t slots() const { return slots_; }
    VkDeviceSize bytes() const { return slots_ * slot_bytes_; }
    // Makes buffers and kernel. memory: allocated before; windows: the row windows of the kernel `press`.
    void allocate(Context& context, const MarchMemory& memory, const std::vector<RowWindow>& windows) {
        using Name = MarchMemory::Name;
        windows_ = windows;
        summaries_ = std::make_unique<Buffer>(context, bytes(), Buffer::Location::host);
        probe_cells_ =
            std::make_unique<Buffer>(context, std::max<size_t>(probes(), 1) * sizeof(int), Buffer::Location::host);
        for (size_t i = 0; i < probes(); ++i) {
            const Cell p = plan_.points[i];
            static_cast<int*>(probe_cells_->data())[i] = p.y * plan_.skin.pitch + p.x;
        }
        Pipelines& pipelines = context.pipelines();
        const DeviceTable& device = pipelines.device();
        reduce_ = std::make_unique<Kernel>(pipelines, reduce_module(device.texels),
                                           KernelOptions{.bindings = REDUCE_BINDINGS,
                                                         .constants_bytes = sizeof(f32::ReduceConstants),
                                                         .specialization = {},
                                                         .max_sets = maps * uint32_t(windows.size())});
        size_t set = 0;
        for (int map = state0; map < maps; ++map)
            for (const RowWindow& window : windows) {
                // A response that is not asked for is never reduced: a state is bound in its place.
                const bool response = map >= responses && plan_.variant.wanted[size_t(map - responses + QUANTITY_SA1)];
                const BufferRange range = memory.range(response ? MarchMemory::response(map - responses + QUANTITY_SA1)
                                                                : Name::state0 + (map == state1));
                reduce_->bind(set++, {{REDUCE_MAP, window.of(range, plan_.skin.pitch,
                                                             response ? 1 : plan_.variant.state().planes())},
                                      {REDUCE_PROBES, probe_cells_->all()},
                                      {REDUCE_SUMMARIES, summaries_->all()}});
            }
    }

    void clear(const Context& context, VkCommandBuffer commands) const {
        context.calls().vkCmdFillBuffer(commands, summaries_->handle(), 0, VK_WHOLE_SIZE, 0);
    }

    // Records the reduction of the wanted maps at the end of a step that wrote state 0 or 1. Returns the number of
    // dispatches.
    int record(Recording& recording, model::Sample& sample, int state) {
        const model::PressedBox& box = plan_.pressed;
        const VkCommandBuffer commands = recording.commands();
        const int tiles = std::max(box.last_tile - box.first_tile, 1);
        int dispatches = 0;
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            if (!plan_.variant.wanted[size_t(q)]) continue;
            const bool strain = q == QUANTITY_STRAIN;
            const size_t map = strain ? size_t(state0 + state) : size_t(responses + q - QUANTITY_SA1);
            for (size_t i = 0; i < windows_.size(); ++i) {
                const RowWindow& window = windows_[i];
                if (window.rows() == 0) continue;
                f32::ReduceConstants c{};
                c.width = plan_.skin.width();
                c.height = plan_.skin.height();
                c.pitch = plan_.skin.pitch;
                c.tiles = plan_.skin.tiles;
                c.stride = strain ? plan_.skin.pitch * plan_.variant.state().planes() : plan_.skin.pitch;
                c.first_tile = box.first_tile;
                c.first_row = window.first;
                c.rows = window.rows();
                c.base_row = window.base;
                c.probes = int(probes());
                c.slot = int(samples_.size()) * REDUCED_MAPS + q;
                recording.add(double(window.rows()) * tiles * TILE_CELLS);
                reduce_->record(commands, map * windows_.size() + i, &c,
                                groups(window.rows() + int(probes()), REDUCE_ROWS), uint32_t(tiles));
            }
            ++dispatches;
        }
        samples_.push_back(&sample);
        return dispatches;
    }

    // Fills the sample of each step recorded since the last call, after the submission.
    void hand_over() {
        if (samples_.empty()) return; // no thread is woken
        const auto* map = static_cast<const f32::Summary*>(summaries_->data());
        for (model::Sample* sample : samples_) sample->points.assign(REDUCED_MAPS * probes(), 0);
        pool_.share(static_cast<long long>(samples_.size() * REDUCED_MAPS), [&](long long first, long long last) {
            for (auto n = size_t(first); n < size_t(last); ++n) {
                const size_t q = n % REDUCED_MAPS;
                const f32::Summary* const of_map = map + n * (tiles() + probes());
                model::Sample& sample = *samples_[n / REDUCED_MAPS];
                if (plan_.variant.wanted[q])
                    sample.totals[q] = model::total_of<f32>(of_map, tiles(), plan_.skin.cells());
                for (size_t i = 0; i < probes(); ++i) sample.points[q * probes() + i] = double(of_map[tiles() + i].sum);
            }
        });
        samples_.clear();
    }

  private:
    enum Map { state0, state1, responses, maps = responses + RESPONSE_MAPS }; // the maps that are reduced
    size_t probes() const { return plan_.points.size(); }
    size_t tiles() const { return size_t(plan_.skin.height()) * size_t(plan_.skin.tiles); }

    const model::MarchPlan plan_;
    VkDeviceSize slot_bytes_;
    size_t slots_ = 1;
    std::vector<RowWindow> windows_;
    std::unique_ptr<Buffer> summaries_, probe_cells_;
    std::unique_ptr<Kernel> reduce_;
    std::vector<model::Sample*> samples_; // of the steps that have a slot, in order
    simd::Pool pool_;                     // that adds up tiles: a GPU makes them faster than one thread reads them
};

} // namespace dermis::vulkan
