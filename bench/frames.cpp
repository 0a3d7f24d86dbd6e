// SPDX-License-Identifier: MIT
#include "bench/frames.hpp"

#include "bench/native_loops.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/vulkan/press_kernel.hpp"
#include "host/core/vulkan/windows.hpp"

#include "moves_spv.h"

#include <algorithm>
#include <cstring>

namespace bench {

using namespace dermis;

namespace {

constexpr int ring = 4; // the number of frames, which are used cyclically
enum {
    frames,
    rest = frames + ring,
    state0,
    state1,
    responses,
    coefficients = responses + RESPONSE_MAPS, // where there are several elements
    unused,
    buffers
};

} // namespace

FrameScene::FrameScene(int n, const Material& material) {
    SkinDescription skin;
    skin.grid = {n, n, {}};
    skin.surface.kind = Surface::Kind::map;
    skin.receptors.fa2 = material.spring ? Fa2::step_mean : Fa2::point;
    skin.material = material;
    std::vector<double> surface(size_t(n) * size_t(n));
    for (size_t i = 0; i < surface.size(); ++i)
        surface[i] = std::sin(0.3 * double(i % size_t(n))) * std::cos(0.2 * double(i / size_t(n)));
    skin.surface.map = surface;
    SkinOptions options;
    options.precision = Precision::f32;
    streamed = model::streamed_skin(skin, options);
    for (int i = 0; i < ring; ++i) {
        const Floats& f = frames.emplace_back(cells());
        for (size_t k = 0; k < cells(); ++k) f.data()[k] *= float(i % 2 ? 1 : -0.5);
    }
}

CpuMoves::CpuMoves(const FrameScene& scene, int threads, bool past_caches)
    : scene_(scene), past_caches_(past_caches), pool_(threads), rest_(scene.cells()), strain_(scene.cells()),
      integral_(scene.cells()), responses_{Floats(scene.cells()), Floats(scene.cells()), Floats(scene.cells()),
                                           Floats(scene.cells())} {}

void CpuMoves::press(int count) {
    constexpr size_t run = 1024; // cells
    const size_t cells = scene_.cells(), runs = (cells + run - 1) / run;
    for (int i = 0; i < count; ++i, ++frame_) {
        native::Moved moved{.from = scene_.frames[frame_ % ring].data(),
                            .to = scene_.frames[(frame_ + 1) % ring].data(),
                            .rest = rest_.data(),
                            .strain = strain_.data(),
                            .integral = integral_.data(),
                            .responses = {},
                            .past_caches = past_caches_};
        for (size_t r = 0; r < responses_.size(); ++r) moved.responses[r] = responses_[r].data();
        pool_.share(int(runs), [&](int first, int last) {
            native::move_cells(moved, size_t(first) * run, std::min(size_t(last) * run, cells));
        });
    }
}

VulkanFrames::VulkanFrames(const FrameScene& scene, std::shared_ptr<vulkan::Context> context, Shader shader)
    : scene_(scene), context_(std::move(context)) {
    using vulkan::Buffer;
    const VkDeviceSize map = scene.cells() * sizeof(float);
    const model::PreparedSkin& skin = scene.skin();
    std::vector<f32::Coefficients> table(skin.materials.size());
    if (!model::fill_table<f32>(skin.materials, skin.chain, skin.rule, {scene.dt}, table.data()))
        throw std::logic_error("table");
    const VkDeviceSize planes = VkDeviceSize(scene.streamed.variant().state().planes());
    for (int i = 0; i < buffers; ++i)
        buffers_.emplace_back(*context_,
                              i == unused                  ? 4
                              : i == coefficients          ? table.size() * sizeof table[0]
                              : i == state0 || i == state1 ? planes * map
                                                           : map,
                              Buffer::Location::device);
    const auto b = [&](int i) { return buffers_[size_t(i)].all(); };
    std::vector<std::vector<vulkan::BoundRange>> sets;
    for (int i = 0; i < ring; ++i) { // the two states are swapped with each frame
        sets.push_back({{PRESS_PRESSURE_FROM, b(frames + i)},
                        {PRESS_PRESSURE_TO, b(frames + (i + 1) % ring)},
                        {PRESS_REST_CURVATURE, b(rest)},
                        {PRESS_STATE_FROM, b(state0 + i % 2)},
                        {PRESS_STATE_TO, b(state1 - i % 2)},
                        {PRESS_COEFFICIENTS, b(coefficients)},
                        {PRESS_MATERIAL, b(unused)},
                        {PRESS_INVALID, b(unused)}});
        for (int r = 0; r < RESPONSE_MAPS; ++r)
            sets.back().push_back({uint32_t(PRESS_RESPONSE(QUANTITY_SA1 + r)), b(responses + r)});
    }
    const std::vector<uint32_t> variant = vulkan::specialization(scene.streamed.variant());
    vulkan::Pipelines& pipelines = context_->pipelines();
    const vulkan::Module module = shader == Shader::moves ? vulkan::Module{moves_spv, sizeof moves_spv}
                                                          : vulkan::press_module_for(pipelines.device());
    kernel_ = std::make_unique<vulkan::Kernel>(
        pipelines, module,
        vulkan::KernelOptions{.bindings = PRESS_BINDINGS,
                              .constants_bytes = sizeof(f32::Constants),
                              .specialization = shader == Shader::press ? variant : std::vector<uint32_t>{},
                              .max_sets = uint32_t(sets.size())});
    for (size_t i = 0; i < sets.size(); ++i) kernel_->bind(i, sets[i]);
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = 2;
    vulkan::check(context_->calls().vkCreateQueryPool(context_->device(), &info, nullptr, &stamps_),
                  "vkCreateQueryPool");
    Buffer staging(*context_, std::max<VkDeviceSize>(map, b(coefficients).bytes), Buffer::Location::host);
    const std::vector<float> rest_map = model::padded_rest_curvature<float>(scene.skin());
    vulkan::Recording recording(*context_);
    const auto upload = [&](int i, const void* values) {
        const VkBufferCopy region{0, 0, b(i).bytes};
        std::memcpy(staging.data(), values, b(i).bytes);
        context_->calls().vkCmdCopyBuffer(recording.commands(), staging.handle(), b(i).buffer, 1, &region);
        recording.submit();
    };
    for (int i = 0; i < ring; ++i) upload(i, scene.frames[size_t(i)].data());
    upload(rest, rest_map.data());
    upload(coefficients, table.data());
    const VkCommandBuffer commands = recording.commands();
    for (int i = state0; i < coefficients; ++i)
        context_->calls().vkCmdFillBuffer(commands, b(i).buffer, 0, VK_WHOLE_SIZE, 0);
    context_->barrier(commands);
    recording.submit();
}

VulkanFrames::~VulkanFrames() { context_->calls().vkDestroyQueryPool(context_->device(), stamps_, nullptr); }

template <class Record> double VulkanFrames::timed(Record&& record) {
    const VolkDeviceTable& vk = context_->calls();
    vulkan::Recording recording(*context_);
    const VkCommandBuffer commands = recording.commands();
    vk.vkCmdResetQueryPool(commands, stamps_, 0, 2);
    vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, stamps_, 0);
    const double start = now();
    record(commands);
    recording_ = now() - start;
    vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, stamps_, 1);
    recording.submit();
    uint64_t ticks[2] = {};
    vulkan::check(vk.vkGetQueryPoolResults(context_->device(), stamps_, 0, 2, sizeof ticks, ticks, sizeof(uint64_t),
                                           VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
                  "vkGetQueryPoolResults");
    return double(ticks[1] - ticks[0]) * double(context_->limits().timestampPeriod) * 1e-9;
}

double VulkanFrames::press(int count) {
    const model::PreparedSkin& skin = scene_.skin();
    const auto c = model::frame_constants(skin, model::rounded<f32>(model::exact_coefficients(
                                                    skin.materials[0], skin.rule, scene_.dt))); // of one element
    const auto groups = [](int cells, int size) { return uint32_t((cells + size - 1) / size); };
    const double gpu = timed([&](VkCommandBuffer commands) {
        for (int i = 0; i < count; ++i, ++frame_) {
            kernel_->record(commands, size_t(frame_ % ring), &c, groups(c.width, PRESS_CELLS * PRESS_X),
                            groups(c.height, PRESS_Y));
            context_->barrier(commands);
        }
    });
    recording_ /= count;
    return gpu;
}

std::vector<float> VulkanFrames::response(int r) {
    vulkan::Buffer staging(*context_, buffers_[responses].bytes(), vulkan::Buffer::Location::host);
    const VkBufferCopy region{0, 0, staging.bytes()};
    vulkan::Recording recording(*context_);
    const VkCommandBuffer commands = recording.commands();
    context_->calls().vkCmdCopyBuffer(commands, buffers_[size_t(responses + r)].handle(), staging.handle(), 1, &region);
    context_->barrier(commands);
    recording.submit();
    const auto* values = static_cast<const float*>(staging.data());
    return {values, values + scene_.cells()};
}

} // namespace bench
