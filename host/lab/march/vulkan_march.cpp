// SPDX-License-Identifier: MIT
// Records presses, submits them by their work, and hands the results over when a ring of them is full.
#include "host/lab/march/march.hpp"

#include "host/core/model/laplacian.hpp"
#include "host/core/vulkan/press_kernel.hpp"
#include "host/lab/march/results.hpp"

#include <algorithm>
#include <cstring>

namespace dermis::vulkan {
namespace {

// Refuses what the device cannot hold, before anything is allocated.
void check_fits(const plan::PreparedSkin& skin, const Context& context, VkDeviceSize all, VkDeviceSize largest) {
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

// The kernel `fields` over either state of a march.
class FieldsKernel {
  public:
    FieldsKernel(Pipelines& pipelines, const plan::PreparedSkin& skin, const plan::Variant& variant,
                 const MarchMemory& memory)
        : windows_(
              row_windows(pipelines.device(), skin,
                          {.first = 0, .last = skin.height(), .planes = variant.state().planes(), .work = numbers})),
          kernel_(pipelines, fields_module(),
                  {.bindings = FIELDS_BINDINGS,
                   .constants_bytes = sizeof(f32::Constants),
                   .specialization = specialization(variant),
                   .max_sets = 2 * uint32_t(windows_.size())}) {
        size_t set = 0;
        for (int state : {MarchMemory::state0, MarchMemory::state1})
            for (const RowWindow& window : windows_) {
                const auto map = [&](int name) { return window.of(memory.range(name), skin.pitch); };
                const BufferRange strain = window.of(memory.range(state), skin.pitch, variant.state().planes());
                kernel_.bind(set++, {{FIELDS_SURFACE, map(MarchMemory::surface)},
                                     {FIELDS_REST_CURVATURE, map(MarchMemory::rest_curvature)},
                                     {FIELDS_STRAIN, strain},
                                     {FIELDS_CURVATURE, map(MarchMemory::curvature)},
                                     {FIELDS_DEFORMATION, map(MarchMemory::deformation)}});
            }
    }

    void record(Recording& recording, int state, f32::Constants c) const {
        const VkCommandBuffer commands = recording.commands();
        for (size_t i = 0; i < windows_.size(); ++i) {
            recording.add(numbers * c.width * windows_[i].rows());
            c.first_row = windows_[i].first;
            c.base_row = windows_[i].base;
            kernel_.record(commands, size_t(state) * windows_.size() + i, &c, groups(c.width, FIELDS_X),
                           uint32_t(windows_[i].rows()));
        }
    }

  private:
    static constexpr double numbers = 2; // numbers written for each cell
    std::vector<RowWindow> windows_;
    Kernel kernel_;
};

// The regions that copy a map's first plane without gaps, from byte `at` on. In a state, the rows of other planes lie
// between the rows of the first one.
std::vector<VkBufferCopy> regions_of(const plan::PreparedSkin& skin, int planes, VkDeviceSize at) {
    const VkDeviceSize row = VkDeviceSize(skin.pitch) * sizeof(float), rows = VkDeviceSize(skin.height());
    if (planes == 1) return {{0, at, rows * row}};
    std::vector<VkBufferCopy> regions;
    for (VkDeviceSize y = 0; y < rows; ++y) regions.push_back({y * row * VkDeviceSize(planes), at + y * row, row});
    return regions;
}

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

class March : public plan::Stepper {
  public:
    March(const plan::PreparedSkin& skin, const plan::Schedule& schedule, const plan::Variant& variant,
          std::shared_ptr<Context> context, Sink sink)
        : skin_(skin), schedule_(schedule), variant_(variant), context_(std::move(context)), sink_(std::move(sink)),
          memory_(skin, schedule, variant), results_(*context_, skin, schedule), recording_(*context_),
          staging_(*context_, recording_) {
        check_fits(skin, *context_, memory_.bytes() + results_.bytes(),
                   std::max(results_.bytes(), memory_.bytes_of(MarchMemory::coefficients)));
        // These throw where a value does not fit, so they come before any buffer.
        const std::vector<float> rest = plan::padded_rest_curvature<float>(skin),
                                 surface = plan::padded_surface<float>(skin),
                                 pressure = schedule.framed
                                                ? std::vector<float>()
                                                : plan::padded<float>(schedule.pressure, skin, "load.intensity");
        memory_.allocate(*context_);
        make_kernels();
        memory_.clear(*context_, recording_.commands());
        results_.clear(*context_, recording_.commands());
        recording_.barrier();
        stage(rest, MarchMemory::rest_curvature);
        if (schedule.derives) stage(surface, MarchMemory::surface);
        if (!schedule.framed) stage(pressure, MarchMemory::pressure0);
        if (variant.materials) stage(skin.material_of, MarchMemory::material);
        finish();
    }

    void frame(const std::vector<double>& map) override {
        const Use use = context_->need_working();
        to_ = 1 - to_;
        stage(plan::padded<float>(map, skin_, "load.intensity"), MarchMemory::pressure0 + to_);
    }

    void press(const plan::Step& step) override {
        const Use use = context_->need_working();
        if (variant_.tabled() && !step.same_coefficients(table_of_)) {
            table_of_ = step;
            std::vector<f32::Coefficients> table;
            plan::fill_table<f32>(step, skin_.materials, skin_.chain, skin_.rule, table);
            stage(table, MarchMemory::coefficients);
        }
        press_->record(recording_.commands(), binding(from_, to_),
                       plan::constants_of<f32>(skin_, schedule_.pressed, step), 1, &recording_);
        recording_.barrier();
        ++dispatches_;
        visible_ = 1 - from_;
        if (step.trace >= 0 || step.impulse >= 0) {
            dispatches_ += results_.record(recording_, step, visible_);
            recording_.barrier();
        }
        if (step.keep) from_ = visible_;
        if (results_.full() || ++recorded_ >= results_.slots()) finish();
    }

    void finish() override {
        if (!recording_.empty()) recording_.submit();
        recorded_ = 0;
        staging_.reuse();
        results_.hand_over(sink_);
    }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const std::vector<const float*> views = view(what);
        maps.resize(what.size());
        for (size_t i = 0; i < what.size(); ++i) {
            maps[i].clear();
            for (int y = 0; y < skin_.height(); ++y) {
                const float* row = views[i] + size_t(y) * size_t(skin_.pitch);
                maps[i].insert(maps[i].end(), row, row + skin_.width());
            }
        }
    }

    std::vector<const float*> view(const std::vector<Quantity>& what) override {
        const Use use = context_->need_working();
        if (std::ranges::any_of(what, [](Quantity q) { return q >= Quantity::curvature; })) {
            fields_->record(recording_, visible_, plan::constants_of<f32>(skin_, schedule_.pressed));
            ++dispatches_;
            recording_.barrier();
        }
        const VkDeviceSize map = memory_.map_bytes();
        if (!download_ || download_->bytes() < map * what.size())
            download_ = std::make_unique<Buffer>(*context_, map * what.size(), Buffer::Location::host);
        for (size_t i = 0; i < what.size(); ++i) copy_map(recording_.commands(), what[i], i * map);
        recording_.barrier();
        finish();
        std::vector<const float*> views;
        for (size_t i = 0; i < what.size(); ++i)
            views.push_back(static_cast<const float*>(download_->data()) + i * skin_.padded_cells());
        return views;
    }

    long long dispatches() const override { return dispatches_; }

  private:
    // The binding of the kernel `press` that reads state `from` and runs to pressure `to`.
    static size_t binding(int from, int to) { return size_t(from + 2 * to); }

    void make_kernels() {
        using M = MarchMemory;
        const auto range = [this](int name) { return memory_.range(name); };
        Pipelines& pipelines = context_->pipelines();
        press_ = std::make_unique<PressKernel>(pipelines, skin_, variant_, schedule_.pressed, 4);
        std::array<BufferRange, RESPONSE_MAPS> responses;
        for (size_t i = 0; i < responses.size(); ++i) responses[i] = range(M::responses + int(i));
        for (int to : {0, 1}) // the pressure runs from the other one
            for (int from : {0, 1})
                press_->bind(binding(from, to),
                             {.pressure_from = range(variant_.framed ? M::pressure0 + (1 - to) : M::pressure0),
                              .pressure_to = range(M::pressure0 + to),
                              .rest_curvature = range(M::rest_curvature),
                              .state_from = range(M::state0 + from),
                              .state_to = range(M::state1 - from),
                              .response = responses,
                              .coefficients = range(M::coefficients),
                              .material = range(M::material),
                              .invalid = range(M::invalid)});
        results_.allocate(*context_, variant_, memory_, press_->windows());
        if (schedule_.derives) fields_ = std::make_unique<FieldsKernel>(pipelines, skin_, variant_, memory_);
    }

    template <class T> void stage(const std::vector<T>& values, int name) {
        staging_.copy(values, memory_[name], [this] { finish(); });
    }

    // Copies a map into the download from byte `at` on.
    void copy_map(VkCommandBuffer commands, Quantity q, VkDeviceSize at) {
        const std::vector<VkBufferCopy> regions =
            regions_of(skin_, q == Quantity::strain ? variant_.state().planes() : 1, at);
        context_->calls().vkCmdCopyBuffer(
            commands,
            memory_[q == Quantity::strain ? MarchMemory::state0 + visible_ : MarchMemory::response(int(q))].handle(),
            download_->handle(), uint32_t(regions.size()), regions.data());
    }

    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    const plan::Variant variant_;
    std::shared_ptr<Context> context_;
    Sink sink_;
    MarchMemory memory_;
    Results results_;
    std::unique_ptr<PressKernel> press_;
    std::unique_ptr<FieldsKernel> fields_;
    std::unique_ptr<Buffer> download_;
    Recording recording_;
    Staging staging_;
    plan::Step table_of_; // what the table on the device was made from
    size_t recorded_ = 0;
    int from_ = 0, visible_ = 0, to_ = 1; // states: that a step begins with, that the last one made; pressure run to
    long long dispatches_ = 0;
};

} // namespace

std::unique_ptr<plan::Stepper> stepper(const plan::PreparedSkin& skin, const plan::Schedule& schedule,
                                       Precision precision, std::shared_ptr<Context> context,
                                       plan::Stepper::Sink sink) {
    return std::make_unique<March>(skin, schedule, variant_of(skin, schedule, precision), std::move(context),
                                   std::move(sink));
}

} // namespace dermis::vulkan
