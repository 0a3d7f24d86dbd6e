// SPDX-License-Identifier: MIT
// Records presses into one command buffer, as many as fit a ring of results, and hands the results over when it is
// full.
#include "host/vulkan/stepper.hpp"

#include "host/vulkan/press_kernel.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {
namespace {

using f32::Constants;
using f32::Summary;

// A submission is cut at about this many cell-steps, so that no driver's watchdog and no user waits long.
constexpr double cell_steps_per_submit = 2e7;
constexpr double ring_bytes = 16e6;
constexpr VkDeviceSize upload_bytes = 16 << 20;

// What the device must hold, checked before anything is allocated.
void check_fits(const plan::Plan& plan, const Context& context, VkDeviceSize all, VkDeviceSize ring) {
    const std::string grid = std::to_string(plan.constants.width) + " x " + std::to_string(plan.constants.height);
    const auto refuse = [&](VkDeviceSize needed, const char* limit, VkDeviceSize allowed) {
        throw Error(Error::Code::bad_input, "grid.width",
                    "grid of " + grid + " needs " + std::to_string(needed) + " bytes; allowed on this device: " +
                        limit + " = " + std::to_string(allowed) + "; or device cpu");
    };
    const VkPhysicalDeviceLimits& limits = context.limits();
    const VkDeviceSize largest =
        std::max<VkDeviceSize>(ring, plan.material.empty() ? 0 : plan.media.size() * sizeof(f32::Coefficients));
    if (largest > limits.maxStorageBufferRange) refuse(largest, "maxStorageBufferRange", limits.maxStorageBufferRange);
    if (all > context.heap_bytes()) refuse(all, "device memory", context.heap_bytes());
    if (uint32_t(plan.constants.height) > limits.maxComputeWorkGroupCount[1])
        refuse(all, "maxComputeWorkGroupCount[1]", limits.maxComputeWorkGroupCount[1]);
}

class March : public plan::Stepper {
  public:
    March(const plan::Plan& plan, std::shared_ptr<Context> context, Sink sink)
        : plan_(plan), context_(std::move(context)), sink_(std::move(sink)),
          plane_(VkDeviceSize(plan.pitch) * plan.constants.height * sizeof(float)), probes_(int(plan.places.size())) {
        const VkDeviceSize per_step =
            VkDeviceSize(REDUCED_MAPS) * (VkDeviceSize(plan.constants.height) * plan.tiles + probes_) * sizeof(Summary);
        const double room = std::min(ring_bytes, double(context_->limits().maxStorageBufferRange)) / double(per_step);
        ring_ = size_t(std::clamp(std::min(cell_steps_per_submit * sizeof(float) / double(plane_), room), 1.0, 1024.0));
        VkDeviceSize all = ring_ * per_step;
        for (int i = 0; i < places; ++i) all += bytes_of(i);
        check_fits(plan, *context_, all, ring_ * per_step);
        // throws where a value does not fit, so before buffers
        const std::vector<float> rest_map = plan::padded<float>(plan.maps.rest_curvature, plan, "surface.relief"),
                                 surface_map = plan::padded<float>(plan.maps.surface, plan, "surface.relief"),
                                 pressure_map = plan.framed
                                                    ? std::vector<float>()
                                                    : plan::padded<float>(plan.maps.pressure, plan, "load.intensity");
        for (int i = 0; i < places; ++i) buffers_.emplace_back(*context_, bytes_of(i), Buffer::Location::device);
        buffers_.emplace_back(*context_, ring_ * per_step, Buffer::Location::host);
        buffers_.emplace_back(*context_, std::max(probes_, 1) * sizeof(int), Buffer::Location::host);
        make_kernels();
        for (int i = 0; i < probes_; ++i) {
            const Cell p = plan_.places[size_t(i)];
            static_cast<int*>(buffers_[probe_cells].data())[i] = p.y * plan_.pitch + p.x;
        }
        // The skin at rest; responses of cells that are pressed poisoned, so that what a kernel forgets to write shows.
        const plan::Pressed& box = plan.pressed;
        const bool whole = box.first_row == 0 && box.last_row == plan.constants.height && box.first_tile == 0 &&
                           box.last_tile == plan.tiles;
        const VkCommandBuffer commands = recording();
        for (int i = 0; i <= ring_summaries; ++i)
            context_->calls().vkCmdFillBuffer(commands, buffers_[i].handle(), 0, VK_WHOLE_SIZE,
                                              whole && i >= sa1 && i <= deformation ? 0xffffffff : 0);
        context_->barrier(commands);
        stage(rest_map, rest);
        if (plan.derives) stage(surface_map, surface);
        if (!plan.framed) stage(pressure_map, pressure0);
        if (!plan.material.empty()) stage(plan.material, material);
        finish();
    }

    void frame(const std::vector<double>& map) override {
        to_ = 1 - to_;
        stage(plan::padded<float>(map, plan_, "load.intensity"), pressure0 + to_);
    }

    void press(const plan::Step& step) override {
        if (!plan_.material.empty() && step.rows != rows_) {
            rows_ = step.rows;
            std::vector<f32::Coefficients> table;
            for (const f64::Coefficients& k : *rows_) table.push_back(plan::rounded<f32::Coefficients>(k));
            stage(table, rows);
        }
        const VkCommandBuffer commands = recording();
        const Constants c = plan::constants_of<Constants>(plan_, step);
        const plan::Pressed& box = plan_.pressed;
        const size_t bands = press_->bands().size();
        press_->record(commands, size_t(from_ + 2 * to_), c);
        context_->barrier(commands);
        ++dispatches_;
        shown_ = 1 - from_;
        if (step.trace >= 0 || step.impulse >= 0) {
            for (int q = 0; q < REDUCED_MAPS; ++q) {
                if (!plan_.wanted[q]) continue;
                const size_t map = q == 0 ? size_t(shown_) : size_t(q) + 1; // either state, SA1, SA2, FA1, FA2
                for (size_t i = 0; i < bands; ++i) {
                    const Band& band = press_->bands()[i];
                    const int rows = band.last - band.first;
                    const f32::ReduceConstants reduce{c.width,
                                                      c.height,
                                                      c.pitch,
                                                      plan_.tiles,
                                                      q == 0 ? c.pitch * state_planes(plan_) : c.pitch,
                                                      box.first_tile,
                                                      band.first,
                                                      rows,
                                                      band.base,
                                                      probes_,
                                                      int(kept_.size()) * REDUCED_MAPS + q};
                    if (rows > 0)
                        reduce_->record(commands, map * bands + i, &reduce, groups(rows + probes_, REDUCE_ROWS),
                                        uint32_t(std::max(box.last_tile - box.first_tile, 1)));
                }
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
        staged_ = 0;
        const size_t tiles = size_t(plan_.constants.height) * plan_.tiles, cells = plan_.maps.pressure.size();
        const auto* map = static_cast<const Summary*>(buffers_[ring_summaries].data());
        for (const plan::Step& step : kept_) {
            plan::Sample sample{};
            for (int q = 0; q < REDUCED_MAPS; ++q, map += tiles + size_t(probes_)) {
                sample.totals[q] = plan::total_of(map, tiles, cells);
                for (int i = 0; i < probes_; ++i) sample.probes.push_back(map[tiles + size_t(i)].sum);
            }
            sink_(step, sample);
        }
        kept_.clear();
    }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const VkCommandBuffer commands = recording();
        const auto derived = [](Quantity q) { return q == Quantity::curvature || q == Quantity::deformation; };
        if (std::any_of(what.begin(), what.end(), derived)) {
            Constants c = plan::constants_of<Constants>(plan_, {});
            for (size_t i = 0; i < field_bands_.size(); ++i) {
                const Band& band = field_bands_[i];
                c.first_row = band.first;
                c.base_row = band.base;
                fields_->record(commands, size_t(shown_) * field_bands_.size() + i, &c, groups(c.width, FIELDS_X),
                                uint32_t(band.last - band.first));
            }
            ++dispatches_;
            context_->barrier(commands);
        }
        if (!staging_ || staging_->bytes() < plane_ * what.size())
            staging_ = std::make_unique<Buffer>(*context_, plane_ * what.size(), Buffer::Location::host);
        for (size_t i = 0; i < what.size(); ++i) {
            std::vector<VkBufferCopy> regions;
            const VkDeviceSize row = VkDeviceSize(plan_.pitch) * sizeof(float);
            if (what[i] == Quantity::strain) // in a state, other rows lie between its rows
                for (int y = 0; y < plan_.constants.height; ++y)
                    regions.push_back({VkDeviceSize(y) * row * VkDeviceSize(state_planes(plan_)),
                                       i * plane_ + VkDeviceSize(y) * row, row});
            else regions.push_back({0, i * plane_, plane_});
            context_->calls().vkCmdCopyBuffer(commands, plane_of(what[i]).handle(), staging_->handle(),
                                              uint32_t(regions.size()), regions.data());
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
    // Buffers: on the device, then the ring of results, and which cells are probed.
    enum {
        rest,
        surface,
        pressure0,
        pressure1,
        state0,
        state1,
        sa1,
        sa2,
        fa1,
        fa2,
        curvature,
        deformation,
        rows,
        material,
        invalid,
        places,
        ring_summaries = places,
        probe_cells
    };

    VkDeviceSize bytes_of(int place) const {
        const bool uniform = plan_.material.empty(); // then what it does not need is bound all the same
        if (place == state0 || place == state1) return VkDeviceSize(state_planes(plan_)) * plane_;
        if ((place == surface || place == curvature || place == deformation) && !plan_.derives) return 4;
        if (place == invalid) return 4;
        if (place == rows) return uniform ? 4 : plan_.media.size() * sizeof(f32::Coefficients);
        if (place >= sa1 && place <= fa2 && !plan_.wanted[place - sa1 + 1]) return 4;
        if ((place == material && uniform) || (place == pressure1 && !plan_.framed)) return 4;
        return plane_;
    }

    void make_kernels() {
        Pipelines& pipelines = context_->pipelines();
        const bool rounds = pipelines.gpu().rounds;
        const auto b = [&](int i) { return buffers_[size_t(i)].all(); };
        press_ = std::make_unique<Press>(pipelines, plan_, 4);
        for (int to = 0; to < 2; ++to) // pressure runs from the other one
            for (int from = 0; from < 2; ++from)
                press_->bind(size_t(from + 2 * to), {b(plan_.framed ? pressure0 + (1 - to) : pressure0),
                                                     b(pressure0 + to),
                                                     b(rest),
                                                     b(state0 + from),
                                                     b(state1 - from),
                                                     {b(sa1), b(sa2), b(fa1), b(fa2)},
                                                     b(rows),
                                                     b(material),
                                                     b(invalid)});
        const std::vector<Band>& bands = press_->bands();
        const int pitch = plan_.pitch, stride = state_planes(plan_);
        reduce_ =
            std::make_unique<Kernel>(pipelines, reduce_module(rounds), REDUCE_BINDINGS, sizeof(f32::ReduceConstants),
                                     std::vector<uint32_t>{}, 6 * uint32_t(bands.size()));
        size_t set = 0;
        for (int map : {state0, state1, sa1, sa2, fa1, fa2})
            for (const Band& band : bands) {
                const bool there = map <= state1 || plan_.wanted[map - sa1 + 1];
                reduce_->bind(set++, {there ? band.of(b(map), pitch, map <= state1 ? stride : 1) : b(map),
                                      b(probe_cells), b(ring_summaries)});
            }
        if (!plan_.derives) return;
        field_bands_ =
            vulkan::bands(plan_, 0, plan_.constants.height, stride, pipelines.gpu().limits.maxStorageBufferRange);
        fields_ = std::make_unique<Kernel>(pipelines, fields_module(rounds), FIELDS_BINDINGS, sizeof(Constants),
                                           variant_of(plan_), 2 * uint32_t(field_bands_.size()));
        set = 0;
        for (int state : {state0, state1})
            for (const Band& band : field_bands_) {
                const auto map = [&](int i) { return band.of(b(i), pitch); };
                fields_->bind(set++, {map(surface), map(rest), band.of(b(state), pitch, stride), map(curvature),
                                      map(deformation)});
            }
    }

    // Copies values to a buffer in the order of what is recorded. Staging holds them until the next submission.
    template <class T> void stage(const std::vector<T>& values, int place) {
        const VkDeviceSize bytes = values.size() * sizeof(T);
        if (!uploads_)
            uploads_ = std::make_unique<Buffer>(*context_, std::clamp(bytes, VkDeviceSize(1) << 16, upload_bytes),
                                                Buffer::Location::host);
        for (VkDeviceSize done = 0; done < bytes;) {
            if (staged_ == uploads_->bytes()) finish();
            const VkDeviceSize part = std::min(bytes - done, uploads_->bytes() - staged_);
            std::memcpy(static_cast<char*>(uploads_->data()) + staged_,
                        reinterpret_cast<const char*>(values.data()) + done, part);
            const VkCommandBuffer commands = recording();
            const VkBufferCopy region{staged_, done, part};
            context_->calls().vkCmdCopyBuffer(commands, uploads_->handle(), buffers_[place].handle(), 1, &region);
            context_->barrier(commands);
            staged_ += part;
            done += part;
        }
    }

    VkCommandBuffer recording() {
        if (!commands_) commands_ = context_->begin();
        return commands_;
    }

    const Buffer& plane_of(Quantity q) const {
        switch (q) {
        case Quantity::strain: return buffers_[state0 + shown_];
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
    std::unique_ptr<Press> press_;
    std::unique_ptr<Kernel> fields_, reduce_;
    std::vector<Band> field_bands_;
    std::unique_ptr<Buffer> staging_, uploads_;
    VkDeviceSize staged_ = 0;                           // bytes of uploads_ in use
    std::shared_ptr<const std::vector<f64::Coefficients>> rows_; // what the table was made from
    VkCommandBuffer commands_ = VK_NULL_HANDLE;         // while recording
    std::vector<plan::Step> kept_;                      // whose results stand in the ring
    size_t recorded_ = 0;
    int from_ = 0, shown_ = 0, to_ = 1; // states; the pressure that is run to
    long long dispatches_ = 0;
};

} // namespace

std::unique_ptr<plan::Stepper> march(const plan::Plan& plan, std::shared_ptr<Context> context,
                                     plan::Stepper::Sink sink) {
    return std::make_unique<March>(plan, std::move(context), std::move(sink));
}

} // namespace dermis::vulkan
