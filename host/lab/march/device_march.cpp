// SPDX-License-Identifier: MIT
// Records presses, submits them by their work, and hands the results over when a ring of them is full.
#include "host/core/base/pool.hpp"
#include "host/core/embedding/backend.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/vulkan/press_kernel.hpp"
#include "host/core/vulkan/recording.hpp"
#include "host/core/vulkan/windows.hpp"
#include "host/lab/march/march.hpp"
#include "host/lab/march/self_test.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {
namespace {

// Refuses what the device cannot hold, before anything is allocated.
void check_fits(const model::PreparedSkin& skin, const Context& context, VkDeviceSize all, VkDeviceSize largest) {
    const std::string grid = std::to_string(skin.width()) + " x " + std::to_string(skin.height());
    const auto refuse = [&](VkDeviceSize needed, const char* limit, VkDeviceSize allowed) {
        throw Error(Error::Code::bad_input, "grid.width",
                    "grid of " + grid + " needs " + std::to_string(needed) + " bytes; allowed on this device: " +
                        limit + " = " + std::to_string(allowed) + "; or device cpu");
    };
    const VkPhysicalDeviceLimits& limits = context.limits();
    if (largest > limits.maxStorageBufferRange) refuse(largest, "maxStorageBufferRange", limits.maxStorageBufferRange);
    if (all > context.heap_bytes()) refuse(all, "device memory", context.heap_bytes());
    if (uint32_t(skin.height()) > limits.maxComputeWorkGroupCount[1])
        refuse(all, "maxComputeWorkGroupCount[1]", limits.maxComputeWorkGroupCount[1]);
}

// The regions that copy a map's first plane without gaps, from byte `at` on. In a state, the rows of other planes lie
// between the rows of the first one.
std::vector<VkBufferCopy> regions_of(const model::PreparedSkin& skin, int planes, VkDeviceSize at) {
    const VkDeviceSize row = VkDeviceSize(skin.pitch) * sizeof(float), rows = VkDeviceSize(skin.height());
    if (planes == 1) return {{0, at, rows * row}};
    std::vector<VkBufferCopy> regions;
    for (VkDeviceSize y = 0; y < rows; ++y) regions.push_back({y * row * VkDeviceSize(planes), at + y * row, row});
    return regions;
}

// The device buffers of a march, by name.
class MarchMemory {
  public:
    enum Name {
        rest_curvature,
        pressure0,
        pressure1,
        state0,
        state1,
        responses, // the first of them
        coefficients = responses + RESPONSE_MAPS,
        material,
        invalid,
        names
    };

    explicit MarchMemory(const model::MarchPlan& plan) : plan_(plan), map_(plan.skin.padded_cells() * sizeof(float)) {}

    VkDeviceSize map_bytes() const { return map_; }
    // A buffer that the run does not need is bound all the same, so it has 4 bytes.
    VkDeviceSize bytes_of(int name) const {
        constexpr VkDeviceSize unused = 4;
        const model::Variant& variant = plan_.variant;
        if (name >= responses && name < coefficients)
            return variant.wanted[size_t(name - responses + QUANTITY_SA1)] ? map_ : unused;
        switch (name) {
        case state0:
        case state1: return VkDeviceSize(variant.state().planes()) * map_;
        case pressure1: return variant.framed ? map_ : unused;
        case material: return variant.materials ? map_ : unused;
        case coefficients:
            return variant.tabled() ? (1 + variant.parabolic) * plan_.skin.materials.size() * sizeof(f32::Coefficients)
                                    : unused;
        case invalid: return sizeof(uint32_t);
        default: return map_;
        }
    }

    VkDeviceSize bytes() const { // sum over all buffers
        VkDeviceSize all = 0;
        for (int name = 0; name < names; ++name) all += bytes_of(name);
        return all;
    }

    void allocate(Context& context) {
        for (int name = 0; name < names; ++name)
            buffers_.emplace_back(context, bytes_of(name), Buffer::Location::device);
    }

    // Records the state of a skin at rest. Responses of a wholly pressed grid begin as NaN, so that one which is read
    // before it is written shows.
    void clear(const Context& context, VkCommandBuffer commands) const {
        const model::PressedBox &box = plan_.pressed, all = plan_.skin.whole();
        const bool whole =
            box.first_row == 0 && box.last_row == all.last_row && box.first_tile == 0 && box.last_tile == all.last_tile;
        constexpr uint32_t nan = 0xffffffff;
        for (int name = 0; name < names; ++name)
            context.calls().vkCmdFillBuffer(commands, buffers_[size_t(name)].handle(), 0, VK_WHOLE_SIZE,
                                            whole && name >= responses && name < coefficients ? nan : 0);
    }

    Buffer& operator[](int name) { return buffers_[size_t(name)]; }
    BufferRange range(int name) const { return buffers_[size_t(name)].all(); }
    static Name response(int quantity) { return Name(responses + quantity - QUANTITY_SA1); }

  private:
    const model::MarchPlan plan_;
    const VkDeviceSize map_;
    std::vector<Buffer> buffers_;
};

// A ring of result slots: the device reduces each responding step into a slot, and the host reads the slots after a
// submission.
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
        reduce_ = std::make_unique<Kernel>(pipelines, reduce_module(pipelines.device().texels), std::vector<uint32_t>(),
                                           maps * uint32_t(windows.size()));
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

// Copies values to buffers in the order of what is recorded. A host buffer holds them until the next submission.
class Staging {
  public:
    Staging(Context& context, Recording& recording) : context_(context), recording_(recording) {}

    // make_room: called where the host buffer is full; it submits what is recorded and calls reuse().
    template <class T, class MakeRoom> void copy(const std::vector<T>& values, const Buffer& to, MakeRoom make_room) {
        const VkDeviceSize bytes = values.size() * sizeof(T);
        if (!host_)
            host_ =
                std::make_unique<Buffer>(context_, std::clamp(bytes, least_bytes, most_bytes), Buffer::Location::host);
        for (VkDeviceSize done = 0; done < bytes;) {
            if (used_ == host_->bytes()) make_room();
            const VkDeviceSize part = std::min(bytes - done, host_->bytes() - used_);
            std::memcpy(static_cast<char*>(host_->data()) + used_, reinterpret_cast<const char*>(values.data()) + done,
                        part);
            const VkBufferCopy region{used_, done, part};
            context_.calls().vkCmdCopyBuffer(recording_.commands(), host_->handle(), to.handle(), 1, &region);
            recording_.barrier();
            used_ += part;
            done += part;
        }
    }

    // After a submission the host buffer is free again.
    void reuse() { used_ = 0; }

  private:
    static constexpr VkDeviceSize least_bytes = 1 << 16, most_bytes = 16 << 20;
    Context& context_;
    Recording& recording_;
    std::unique_ptr<Buffer> host_;
    VkDeviceSize used_ = 0; // bytes
};

class DeviceMarch : public model::March {
  public:
    DeviceMarch(const model::MarchPlan& plan, std::shared_ptr<Context> context)
        : plan_(plan), skin_(plan.skin), constants_(model::constants_of<f32>(skin_, plan.pressed)),
          context_(std::move(context)), memory_(plan), results_(*context_, plan), recording_(*context_),
          staging_(*context_, recording_) {
        check_fits(skin_, *context_, memory_.bytes() + results_.bytes(),
                   std::max(results_.bytes(), memory_.bytes_of(MarchMemory::coefficients)));
        // These throw where a value does not fit, so they come before any buffer.
        const bool framed = plan.variant.framed;
        const std::vector<float> rest = model::padded_rest_curvature<float>(skin_),
                                 pressure = framed ? std::vector<float>()
                                                   : model::padded<float>(plan.pressure, skin_, "load.intensity");
        memory_.allocate(*context_);
        make_kernels();
        memory_.clear(*context_, recording_.commands());
        results_.clear(*context_, recording_.commands());
        recording_.barrier();
        stage(rest, MarchMemory::rest_curvature);
        if (!framed) stage(pressure, MarchMemory::pressure0);
        if (plan.variant.materials) stage(skin_.material_of, MarchMemory::material);
        finish();
    }

    void frame(const std::vector<double>& map) override {
        const Use use = context_->need_working();
        to_ = 1 - to_;
        stage(model::padded<float>(map, skin_, "load.intensity"), MarchMemory::pressure0 + to_);
    }

    bool press(const model::Step& step, model::Sample* sample) override {
        const Use use = context_->need_working();
        if (!step.same_coefficients(table_of_)) {
            table_of_ = step;
            model::fill_table<f32>(step, skin_.materials, skin_.chain, skin_.rule, table_);
            if (plan_.variant.tabled()) stage(table_, MarchMemory::coefficients);
        }
        press_->record(recording_.commands(), binding(from_, to_),
                       model::constants_of<f32>(constants_, skin_.tabled() ? nullptr : table_.data(), step), 1,
                       &recording_);
        recording_.barrier();
        ++dispatches_;
        visible_ = 1 - from_;
        if (sample) {
            dispatches_ += results_.record(recording_, *sample, visible_);
            recording_.barrier();
        }
        if (step.keep) from_ = visible_;
        if (++recorded_ < results_.slots()) return false;
        finish();
        return true;
    }

    int settle() override {
        const Use use = context_->need_working();
        finish();
        return ~0;
    }

    std::vector<const void*> maps(const std::vector<Quantity>& what) override {
        const Use use = context_->need_working();
        const VkDeviceSize map = memory_.map_bytes();
        if (!download_ || download_->bytes() < map * what.size())
            download_ = std::make_unique<Buffer>(*context_, map * what.size(), Buffer::Location::host);
        for (size_t i = 0; i < what.size(); ++i) copy_map(recording_.commands(), what[i], i * map);
        recording_.barrier();
        finish();
        std::vector<const void*> maps;
        for (size_t i = 0; i < what.size(); ++i) maps.push_back(static_cast<const char*>(download_->data()) + i * map);
        return maps;
    }

    long long dispatches() const override { return dispatches_; }

  private:
    void finish() {
        if (!recording_.empty()) recording_.submit();
        recorded_ = 0;
        staging_.reuse();
        results_.hand_over();
    }

    // The binding of the kernel `press` that reads state `from` and runs to pressure `to`.
    static size_t binding(int from, int to) { return size_t(from + 2 * to); }

    void make_kernels() {
        using M = MarchMemory;
        const auto range = [this](int name) { return memory_.range(name); };
        Pipelines& pipelines = context_->pipelines();
        press_ = std::make_unique<PressKernel>(pipelines, skin_, plan_.variant, plan_.pressed, 4);
        std::array<BufferRange, RESPONSE_MAPS> responses;
        for (size_t i = 0; i < responses.size(); ++i) responses[i] = range(M::responses + int(i));
        for (int to : {0, 1}) // the pressure runs from the other one
            for (int from : {0, 1})
                press_->bind(binding(from, to),
                             {.pressure_from = range(plan_.variant.framed ? M::pressure0 + (1 - to) : M::pressure0),
                              .pressure_to = range(M::pressure0 + to),
                              .rest_curvature = range(M::rest_curvature),
                              .state_from = range(M::state0 + from),
                              .state_to = range(M::state1 - from),
                              .response = responses,
                              .coefficients = range(M::coefficients),
                              .material = range(M::material),
                              .invalid = range(M::invalid)});
        results_.allocate(*context_, memory_, press_->windows());
    }

    template <class T> void stage(const std::vector<T>& values, int name) {
        staging_.copy(values, memory_[name], [this] { finish(); });
    }

    // Copies a map into the download from byte `at` on.
    void copy_map(VkCommandBuffer commands, Quantity q, VkDeviceSize at) {
        const bool strain = q == Quantity::strain;
        const std::vector<VkBufferCopy> regions = regions_of(skin_, strain ? plan_.variant.state().planes() : 1, at);
        const int map = strain ? MarchMemory::state0 + visible_ : MarchMemory::response(int(q));
        context_->calls().vkCmdCopyBuffer(commands, memory_[map].handle(), download_->handle(),
                                          uint32_t(regions.size()), regions.data());
    }

    const model::MarchPlan plan_;
    const model::PreparedSkin& skin_;
    const f32::Constants constants_; // of every step
    std::shared_ptr<Context> context_;
    MarchMemory memory_;
    Results results_;
    std::unique_ptr<PressKernel> press_;
    std::unique_ptr<Buffer> download_;
    Recording recording_;
    Staging staging_;
    model::Step table_of_; // what the table was made for
    std::vector<f32::Coefficients> table_;
    size_t recorded_ = 0;
    int from_ = 0, visible_ = 0, to_ = 1; // states: that a step begins with, that the last one made; pressure run to
    long long dispatches_ = 0;
};

} // namespace

std::unique_ptr<model::March> march(const model::MarchPlan& plan, const model::Backend& backend) {
    const std::shared_ptr<Context>& context = context_of(backend);
    const Use use = context->need_working();
    return std::make_unique<DeviceMarch>(plan, context);
}

bool exact(model::Backend& backend, const model::Variant& variant) {
    std::vector<uint32_t> key = specialization(variant);
    key.push_back(2); // of a march: a stream's key ends in 0 or 1
    return context_of(backend)->exact(key, [&] { return marches_exactly(backend, variant); });
}

} // namespace dermis::vulkan
