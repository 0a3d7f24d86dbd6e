// SPDX-License-Identifier: MIT
// Records presses, submits them by their work, and hands the results over when a ring of them is full.
#include "host/core/embedding/backend.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/vulkan/press_kernel.hpp"
#include "host/lab/march/results.hpp"
#include "host/lab/march/self_test.hpp"
#include "host/lab/march/staging.hpp"

#include <algorithm>

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
