// SPDX-License-Identifier: MIT
// Records presses into one command buffer, as many as fit a ring of results, and hands the results over when it is
// full.
#include "host/vulkan/march.hpp"

#include "fields_spv.h"
#include "press_spv.h"
#include "reduce_spv.h"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {
namespace {

using f32::Constants;
using f32::Summary;

// A submission is cut at about this many cell-steps, so that no driver's watchdog and no user waits long.
constexpr double cell_steps_per_submit = 2e7;
constexpr double ring_bytes = 16e6;

uint32_t groups(int cells, int size) { return uint32_t((cells + size - 1) / size); }

// What the device must hold, checked before anything is allocated.
void check_fits(const plan::Plan& plan, const Context& context, VkDeviceSize plane, VkDeviceSize ring) {
    const std::string grid = std::to_string(plan.constants.width) + " x " + std::to_string(plan.constants.height);
    const auto refuse = [&](VkDeviceSize needed, const char* limit, VkDeviceSize allowed) {
        throw Error(Error::Code::bad_input, "grid.width",
                    "grid of " + grid + " needs " + std::to_string(needed) + " bytes; allowed on this device: " +
                        limit + " = " + std::to_string(allowed) + "; or device cpu");
    };
    const VkPhysicalDeviceLimits& limits = context.limits();
    const VkDeviceSize state = plan.compensated ? 2 * plane : plane, all = 9 * plane + 4 * state + ring;
    if (std::max(state, ring) > limits.maxStorageBufferRange)
        refuse(std::max(state, ring), "maxStorageBufferRange", limits.maxStorageBufferRange);
    if (all > context.heap_bytes()) refuse(all, "device memory", context.heap_bytes());
    if (uint32_t(plan.constants.height) > limits.maxComputeWorkGroupCount[1])
        refuse(plane, "maxComputeWorkGroupCount[1]", limits.maxComputeWorkGroupCount[1]);
}

class March : public plan::Marcher {
  public:
    March(const plan::Plan& plan, std::shared_ptr<Context> context, Sink sink)
        : plan_(plan), context_(std::move(context)), sink_(std::move(sink)),
          plane_(VkDeviceSize(plan.pitch) * plan.constants.height * sizeof(float)),
          probes_(int(plan.scene.output.probes.size())) {
        const VkDeviceSize per_step =
            VkDeviceSize(REDUCED_MAPS) * (plan.constants.height + probes_) * plan.tiles * sizeof(Summary);
        ring_ = size_t(
            std::clamp(std::min(cell_steps_per_submit * sizeof(float) / double(plane_), ring_bytes / double(per_step)),
                       1.0, 1024.0));
        check_fits(plan, *context_, plane_, ring_ * per_step);
        // throws where a value does not fit, so before buffers
        const std::vector<float> maps[] = {plan::padded<float>(plan.maps.pressure, plan, "load.intensity"),
                                           plan::padded<float>(plan.maps.rest_curvature, plan, "surface.relief"),
                                           plan::padded<float>(plan.maps.surface, plan, "surface.relief")};
        for (int i = 0; i < planes; ++i) {
            const bool state = i >= strain0 && i <= sum1;
            buffers_.emplace_back(*context_, plan.compensated && state ? 2 * plane_ : plane_, Buffer::Place::device);
        }
        buffers_.emplace_back(*context_, ring_ * per_step, Buffer::Place::host);
        buffers_.emplace_back(*context_, std::max(probes_, 1) * sizeof(int), Buffer::Place::host);
        make_kernels();
        upload(maps);
    }

    void press(const plan::Step& step) override {
        const VkCommandBuffer commands = recording();
        const Constants c = plan::constants_of<Constants>(plan_, step);
        press_->record(commands, size_t(from_), &c, groups(c.width, PRESS_CELLS * PRESS_X), groups(c.height, PRESS_Y),
                       1);
        context_->barrier(commands);
        ++dispatches_;
        shown_ = 1 - from_;
        if (step.trace >= 0 || step.impulse >= 0) {
            for (int q = 0; q < REDUCED_MAPS; ++q) {
                const int slot = int(kept_.size()) * REDUCED_MAPS + q;
                const f32::ReduceConstants reduce{c.width, c.height, c.pitch, probes_, slot};
                const size_t map = q == 0 ? size_t(shown_) : size_t(q) + 1; // strain0, strain1, SA1, SA2, FA1, FA2
                reduce_->record(commands, map, &reduce, groups(c.height + probes_, REDUCE_ROWS), uint32_t(plan_.tiles),
                                1);
                ++dispatches_;
            }
            context_->barrier(commands);
            kept_.push_back(step);
        }
        if (step.keep) from_ = shown_;
        if (kept_.size() == ring_ || ++recorded_ >= ring_) finish();
    }

    void finish() override {
        if (!commands_) return;
        context_->submit();
        commands_ = VK_NULL_HANDLE;
        recorded_ = 0;
        const size_t tiles = size_t(plan_.constants.height) * plan_.tiles, cells = plan_.maps.pressure.size();
        const auto* map = static_cast<const Summary*>(buffers_[ring_summaries].data());
        for (const plan::Step& step : kept_) {
            plan::Sample sample;
            for (int q = 0; q < REDUCED_MAPS; ++q, map += tiles + size_t(probes_) * plan_.tiles) {
                sample.totals[q] = plan::total_of(map, tiles, cells);
                for (int i = 0; i < probes_; ++i) sample.probes.push_back(map[tiles + size_t(i) * plan_.tiles].sum);
            }
            sink_(step, sample);
        }
        kept_.clear();
    }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const VkCommandBuffer commands = recording();
        const auto derived = [](Quantity q) { return q == Quantity::curvature || q == Quantity::deformation; };
        if (std::any_of(what.begin(), what.end(), derived)) {
            const Constants c = plan::constants_of<Constants>(plan_, {});
            fields_->record(commands, size_t(shown_), &c, groups(c.width, FIELDS_X), uint32_t(c.height), 1);
            ++dispatches_;
            context_->barrier(commands);
        }
        if (!staging_ || staging_->bytes() < plane_ * what.size())
            staging_ = std::make_unique<Buffer>(*context_, plane_ * what.size(), Buffer::Place::host);
        for (size_t i = 0; i < what.size(); ++i) {
            const VkBufferCopy region{0, i * plane_, plane_};
            context_->calls().vkCmdCopyBuffer(commands, plane_of(what[i]).handle(), staging_->handle(), 1, &region);
        }
        context_->barrier(commands);
        finish();
        maps.resize(what.size());
        for (size_t i = 0; i < what.size(); ++i) {
            const auto* values = static_cast<const float*>(staging_->data()) + i * plane_ / sizeof(float);
            std::vector<double>& map = maps[i];
            map.clear();
            for (int y = 0; y < plan_.constants.height; ++y)
                map.insert(map.end(), values + size_t(y) * plan_.pitch,
                           values + size_t(y) * plan_.pitch + plan_.constants.width);
        }
    }

    long long dispatches() const override { return dispatches_; }

  private:
    // Planes of one map each, the ring of results, and which cells are probed.
    enum {
        pressure,
        rest,
        surface,
        strain0,
        strain1,
        sum0,
        sum1,
        sa1,
        sa2,
        fa1,
        fa2,
        curvature,
        deformation,
        planes,
        ring_summaries = planes,
        probe_cells
    };

    void make_kernels() {
        const std::vector<uint32_t> variant = {uint32_t(plan_.stencil), uint32_t(plan_.edges), plan_.compensated};
        std::vector<std::vector<const Buffer*>> press, fields, reduce;
        for (int from = 0; from < 2; ++from) {
            const auto b = [&](int i) { return &buffers_[i]; };
            const int to = 1 - from;
            press.push_back({b(pressure), b(rest), b(strain0 + from), b(sum0 + from), b(strain0 + to), b(sum0 + to),
                             b(sa1), b(sa2), b(fa1), b(fa2)});
            fields.push_back({b(surface), b(rest), b(strain0 + from), b(curvature), b(deformation)});
        }
        for (int map : {strain0, strain1, sa1, sa2, fa1, fa2})
            reduce.push_back({&buffers_[map], &buffers_[probe_cells], &buffers_[ring_summaries]});
        press_ = std::make_unique<Kernel>(*context_, press_spv, sizeof press_spv, PRESS_BINDINGS, sizeof(Constants),
                                          variant, press);
        fields_ = std::make_unique<Kernel>(*context_, fields_spv, sizeof fields_spv, FIELDS_BINDINGS, sizeof(Constants),
                                           variant, fields);
        reduce_ = std::make_unique<Kernel>(*context_, reduce_spv, sizeof reduce_spv, REDUCE_BINDINGS,
                                           sizeof(f32::ReduceConstants), std::vector<uint32_t>{}, reduce);
    }

    // Maps to the device; the state at rest; everything else poisoned, so that what a kernel forgets to write shows.
    void upload(const std::vector<float> (&maps)[3]) {
        staging_ = std::make_unique<Buffer>(*context_, 3 * plane_, Buffer::Place::host);
        for (int i = 0; i < 3; ++i)
            std::memcpy(static_cast<char*>(staging_->data()) + i * plane_, maps[i].data(), plane_);
        for (int i = 0; i < probes_; ++i) {
            const Cell p = plan_.scene.output.probes[size_t(i)];
            static_cast<int*>(buffers_[probe_cells].data())[i] = p.y * plan_.pitch + p.x;
        }
        const VkCommandBuffer commands = recording();
        const VolkDeviceTable& vk = context_->calls();
        for (int i = 0; i < 3; ++i) {
            const VkBufferCopy region{i * plane_, 0, plane_};
            vk.vkCmdCopyBuffer(commands, staging_->handle(), buffers_[i].handle(), 1, &region);
        }
        for (int i = strain0; i <= ring_summaries; ++i)
            vk.vkCmdFillBuffer(commands, buffers_[i].handle(), 0, VK_WHOLE_SIZE, i <= sum1 ? 0 : 0xffffffff);
        context_->barrier(commands);
        finish();
    }

    VkCommandBuffer recording() {
        if (!commands_) commands_ = context_->begin();
        return commands_;
    }

    const Buffer& plane_of(Quantity q) const {
        switch (q) {
        case Quantity::strain: return buffers_[strain0 + shown_];
        case Quantity::curvature: return buffers_[curvature];
        case Quantity::deformation: return buffers_[deformation];
        default: return buffers_[sa1 + int(q) - int(Quantity::sa1)];
        }
    }

    const plan::Plan& plan_;
    std::shared_ptr<Context> context_;
    Sink sink_;
    VkDeviceSize plane_; // bytes
    int probes_;
    size_t ring_ = 1; // steps whose results there is room for
    std::vector<Buffer> buffers_;
    std::unique_ptr<Kernel> press_, fields_, reduce_;
    std::unique_ptr<Buffer> staging_;
    VkCommandBuffer commands_ = VK_NULL_HANDLE; // while recording
    std::vector<plan::Step> kept_;              // whose results stand in the ring
    size_t recorded_ = 0;
    int from_ = 0, shown_ = 0;
    long long dispatches_ = 0;
};

} // namespace

std::unique_ptr<plan::Marcher> march(const plan::Plan& plan, std::shared_ptr<Context> context,
                                     plan::Marcher::Sink sink) {
    return std::make_unique<March>(plan, std::move(context), std::move(sink));
}

} // namespace dermis::vulkan
