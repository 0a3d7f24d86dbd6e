// SPDX-License-Identifier: MIT
#include "bench/frames.hpp"

#include "bench/native_loops.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/vulkan/press_kernel.hpp"
#include "host/core/vulkan/recording.hpp"
#include "host/core/vulkan/windows.hpp"

#include "moves_spv.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace bench {

using namespace dermis;

namespace {

constexpr int ring = 4; // the number of frames, which are used cyclically

const float* frame_of(const FrameScene& scene, size_t i) { return scene.frames[i % ring].data(); }

// Maps of cells that a stepper has: four responses, and others.
std::vector<Floats> maps_of(const FrameScene& scene, size_t count) {
    std::vector<Floats> maps;
    for (size_t i = 0; i < count; ++i) maps.emplace_back(scene.cells());
    return maps;
}

Responses copied(const FrameScene& scene, const std::vector<Floats>& maps) {
    Responses r;
    for (size_t i = 0; i < r.size(); ++i) r[i].assign(maps[i].data(), maps[i].data() + scene.cells());
    return r;
}

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

Stepper library(const FrameScene& scene, int threads, const simd::Isa& isa, bool fa1) {
    const auto loops = std::make_shared<cpu::FramePress>(scene.streamed, threads, isa);
    const auto out = std::make_shared<std::vector<Floats>>(maps_of(scene, RESPONSE_MAPS));
    const auto press = [&scene, loops, out, fa1, i = size_t(0)](int count) mutable {
        float* to[RESPONSE_MAPS];
        for (size_t r = 0; r < RESPONSE_MAPS; ++r)
            to[r] = !fa1 || r == QUANTITY_FA1 - QUANTITY_SA1 ? (*out)[r].data() : nullptr;
        const double start = now();
        for (int k = 0; k < count; ++k, ++i) loops->press({scene.dt}, frame_of(scene, i), frame_of(scene, i + 1), to);
        return now() - start;
    };
    return {press, [&scene, out] { return copied(scene, *out); }};
}

Stepper moves(const FrameScene& scene, int threads, bool past_caches) {
    const auto pool = std::make_shared<simd::Pool>(threads);
    const auto maps = std::make_shared<std::vector<Floats>>(maps_of(scene, RESPONSE_MAPS + 3));
    const auto press = [&scene, pool, maps, past_caches, i = size_t(0)](int count) mutable {
        constexpr size_t run = 1024; // cells
        const size_t cells = scene.cells(), runs = (cells + run - 1) / run;
        const auto map = [&](size_t m) { return (*maps)[m].data(); };
        const double start = now();
        for (int k = 0; k < count; ++k, ++i) {
            const native::Moved moved{
                frame_of(scene, i), frame_of(scene, i + 1), map(4), map(5), map(6), {map(0), map(1), map(2), map(3)},
                past_caches};
            pool->share(int(runs), [&](int first, int last) {
                native::move_cells(moved, size_t(first) * run, std::min(size_t(last) * run, cells));
            });
        }
        return now() - start;
    };
    return {press, {}};
}

namespace {

// phi1(z) = (1 - e^-z)/z, phi2 = (1 - phi1)/z and phi3 = (1/2 - phi2)/z weigh the pressure; z = dt*E/eta > 0.
template <class Real> native::ExactStep<Real> exact_step(const FrameScene& scene) {
    const scene::Element& m = scene.skin().materials[0];
    const double dt = scene.dt, z = dt * m.modulus / m.viscosity, q = dt / m.viscosity, decay = std::exp(-z);
    const double phi1 = -std::expm1(-z) / z, phi2 = (1 - phi1) / z, phi3 = (0.5 - phi2) / z;
    return {Real(m.modulus),
            Real(q * phi1),
            Real(q * phi2),
            Real(dt * phi1),
            Real(dt * q * phi2),
            Real(dt * q * phi3),
            Real(decay / m.viscosity),
            Real(phi1 / m.viscosity),
            Real(-m.modulus / m.viscosity * decay / m.viscosity),
            Real(decay / m.viscosity / dt)};
}

class NativeFrames {
  public:
    NativeFrames(const FrameScene& scene, int threads, bool past_caches)
        : scene_(scene), pool_(threads), maps_(maps_of(scene, RESPONSE_MAPS + 2)),
          strain_((size_t(scene.skin().pitch) + 2 * native::lanes) * size_t(scene.skin().height())),
          past_caches_(past_caches) {
        const model::PreparedSkin& skin = scene.skin();
        const std::vector<float> rest = model::padded_rest_curvature<float>(skin);
        const size_t width = size_t(skin.width()), height = size_t(skin.height()), pitch = size_t(skin.pitch),
                     strain_pitch = pitch + 2 * native::lanes;
        if (width % native::lanes)
            throw std::runtime_error(fmt::format("the native peer: width = {}; allowed: multiples of 16", width));
        std::copy(rest.begin(), rest.end(), maps_[4].data());
        std::fill_n(maps_[5].data(), scene.cells(), 0.0f);
        std::fill_n(strain_.data(), strain_pitch * height, 0.0f);
        for (int i = 0; i < 4 * pool_.threads(); ++i) rows_.emplace_back(pitch);
        frame_ = {exact_step<float>(scene),
                  width,
                  height,
                  pitch,
                  strain_pitch,
                  nullptr,
                  nullptr,
                  maps_[4].data(),
                  strain_.data() + native::lanes,
                  maps_[5].data(),
                  {}};
        for (size_t r = 0; r < 4; ++r) frame_.responses[r] = maps_[r].data();
    }
    double press(int count) {
        const size_t threads = size_t(pool_.threads());
        const auto share = [&](auto&& work) { // rows of each thread
            pool_.each([&](int thread) {
                const size_t t = size_t(thread);
                const Floats* rows = rows_.data() + 4 * t;
                work(frame_.height * t / threads, frame_.height * (t + 1) / threads,
                     native::ThreadRows{rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data()});
            });
        };
        const double start = now();
        for (int i = 0; i < count; ++i, ++pressed_) {
            frame_.from = frame_of(scene_, pressed_);
            frame_.to = frame_of(scene_, pressed_ + 1);
            if (threads > 1)
                share([&](size_t first, size_t last, auto rows) { native::step_beside(frame_, first, last, rows); });
            share([&](size_t first, size_t last, auto rows) {
                native::press_rows(frame_, first, last, rows, past_caches_);
            });
        }
        return now() - start;
    }
    Responses responses() const { return copied(scene_, maps_); }

  private:
    const FrameScene& scene_;
    simd::Pool pool_;
    std::vector<Floats> maps_, rows_; // the responses, rest curvature and integral; four rows of each thread
    Floats strain_;
    const bool past_caches_;
    native::Frame frame_{};
    size_t pressed_ = 0;
};

} // namespace

Stepper native_loop(const FrameScene& scene, int threads, bool past_caches) {
    const auto frames = std::make_shared<NativeFrames>(scene, threads, past_caches);
    return {[frames](int count) { return frames->press(count); }, [frames] { return frames->responses(); }};
}

std::array<double, RESPONSE_MAPS> errors_of_frames(const FrameScene& scene, int presses, const Responses& found) {
    const native::ExactStep<double> k = exact_step<double>(scene);
    const std::vector<float> rest = model::padded_rest_curvature<float>(scene.skin());
    const auto n = size_t(scene.skin().width()), pitch = size_t(scene.skin().pitch),
               height = size_t(scene.skin().height());
    // The strain of each cell of a row, and the signals that the gain multiplies.
    using Row = std::vector<std::array<double, RESPONSE_MAPS>>;
    const auto row_of = [&](size_t y) {
        Row row(n);
        for (size_t x = 0; x < n; ++x) {
            auto& [strain, integral, rate, acceleration] = row[x];
            for (size_t i = 0; i < size_t(presses); ++i) {
                const double from = double(frame_of(scene, i)[y * pitch + x]),
                             way = double(frame_of(scene, i + 1)[y * pitch + x]) - from, r = from - k.E * strain;
                integral += k.i0 * strain + k.i1 * from + k.i2 * way;
                rate = k.v0 * r + k.v1 * way;
                acceleration = k.a0 * r + k.a1 * way;
                strain += k.b * r + k.f * way;
            }
        }
        return row;
    };
    std::array<double, RESPONSE_MAPS> worst{}, greatest{};
    Row above = row_of(0), here = above, below;
    for (size_t y = 0; y < height; ++y) {
        below = row_of(std::min(y + 1, height - 1)); // beyond the grid, a copy of the last row
        for (size_t x = 0; x < n; ++x) {
            const double beside = here[x ? x - 1 : 0][0] + here[std::min(x + 1, n - 1)][0],
                         gain = 1 + double(rest[y * pitch + x]) - (beside + above[x][0] + below[x][0] - 4 * here[x][0]);
            for (size_t q = 0; q < RESPONSE_MAPS; ++q) {
                const double exact = here[x][q] * gain, off = std::abs(double(found[q][y * pitch + x]) - exact);
                worst[q] = std::isfinite(off) ? std::max(worst[q], off) : INFINITY;
                greatest[q] = std::max(greatest[q], std::abs(exact));
            }
        }
        above = std::exchange(here, std::move(below));
    }
    for (size_t q = 0; q < RESPONSE_MAPS; ++q) worst[q] /= greatest[q];
    return worst;
}

namespace {

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

class VulkanFrames {
  public:
    VulkanFrames(const FrameScene& scene, std::shared_ptr<vulkan::Context> context, bool moves)
        : scene_(scene), context_(std::move(context)) {
        const model::PreparedSkin& skin = scene.skin();
        std::vector<f32::Coefficients> table(skin.materials.size());
        if (!model::fill_table<f32>(skin.materials, skin.chain, skin.rule, {scene.dt}, table.data()))
            throw std::logic_error("table");
        const VkDeviceSize map = scene.cells() * sizeof(float), of_table = table.size() * sizeof table[0],
                           of_state = map * VkDeviceSize(scene.streamed.variant().state().planes());
        for (int i = 0; i < buffers; ++i) {
            const bool state = i == state0 || i == state1;
            buffers_.emplace_back(*context_,
                                  i == unused         ? 4
                                  : i == coefficients ? of_table
                                  : state             ? of_state
                                                      : map,
                                  vulkan::Buffer::Location::device);
        }
        vulkan::Pipelines& pipelines = context_->pipelines();
        kernel_ = std::make_unique<vulkan::Kernel>(
            pipelines,
            moves ? vulkan::Module{moves_spv, sizeof moves_spv, PRESS_BINDINGS, sizeof(f32::Constants)}
                  : vulkan::press_module_for(pipelines.device()),
            moves ? std::vector<uint32_t>{} : vulkan::specialization(scene.streamed.variant()), ring);
        for (int i = 0; i < ring; ++i) { // the two states are swapped with each frame
            std::vector<vulkan::BoundRange> set = {
                {PRESS_PRESSURE_FROM, at(frames + i)}, {PRESS_PRESSURE_TO, at(frames + (i + 1) % ring)},
                {PRESS_REST_CURVATURE, at(rest)},      {PRESS_STATE_FROM, at(state0 + i % 2)},
                {PRESS_STATE_TO, at(state1 - i % 2)},  {PRESS_COEFFICIENTS, at(coefficients)},
                {PRESS_MATERIAL, at(unused)},          {PRESS_INVALID, at(unused)}};
            for (int r = 0; r < RESPONSE_MAPS; ++r)
                set.push_back({uint32_t(PRESS_RESPONSE(QUANTITY_SA1 + r)), at(responses + r)});
            kernel_->bind(size_t(i), set);
        }
        VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
        info.queryType = VK_QUERY_TYPE_TIMESTAMP;
        info.queryCount = 2;
        vulkan::check(context_->calls().vkCreateQueryPool(context_->device(), &info, nullptr, &stamps_),
                      "vkCreateQueryPool");
        vulkan::Recording recording(*context_);
        for (int i = state0; i < coefficients; ++i)
            context_->calls().vkCmdFillBuffer(recording.commands(), at(i).buffer, 0, VK_WHOLE_SIZE, 0);
        recording.submit();
        for (int i = 0; i < ring; ++i) copy(i, scene.frames[size_t(i)].data());
        copy(rest, model::padded_rest_curvature<float>(skin).data());
        copy(coefficients, table.data());
    }
    ~VulkanFrames() { context_->calls().vkDestroyQueryPool(context_->device(), stamps_, nullptr); }
    double press(int count) {
        const model::PreparedSkin& skin = scene_.skin();
        const auto c = model::frame_constants(skin, model::rounded<f32>(model::exact_coefficients(
                                                        skin.materials[0], skin.rule, scene_.dt))); // of one element
        const auto groups = [](int cells, int size) { return uint32_t((cells + size - 1) / size); };
        const VolkDeviceTable& vk = context_->calls();
        vulkan::Recording recording(*context_);
        const VkCommandBuffer commands = recording.commands();
        vk.vkCmdResetQueryPool(commands, stamps_, 0, 2);
        vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, stamps_, 0);
        for (int i = 0; i < count; ++i, ++frame_) {
            kernel_->record(commands, size_t(frame_ % ring), &c, groups(c.width, PRESS_CELLS * PRESS_X),
                            groups(c.height, PRESS_Y));
            context_->barrier(commands);
        }
        vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, stamps_, 1);
        recording.submit();
        uint64_t ticks[2] = {};
        vulkan::check(vk.vkGetQueryPoolResults(context_->device(), stamps_, 0, 2, sizeof ticks, ticks, sizeof(uint64_t),
                                               VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
                      "vkGetQueryPoolResults");
        return double(ticks[1] - ticks[0]) * double(context_->limits().timestampPeriod) * 1e-9;
    }
    Responses made() {
        Responses all;
        for (size_t r = 0; r < all.size(); ++r) {
            all[r].resize(scene_.cells());
            copy(responses + int(r), nullptr, all[r].data());
        }
        return all;
    }

  private:
    vulkan::BufferRange at(int i) const { return buffers_[size_t(i)].all(); }
    // Copies numbers into a buffer, or out of it.
    void copy(int i, const void* in, void* out = nullptr) {
        vulkan::Buffer host(*context_, at(i).bytes, vulkan::Buffer::Location::host);
        vulkan::Recording recording(*context_);
        const VkBufferCopy region{0, 0, host.bytes()};
        if (in) std::memcpy(host.data(), in, host.bytes());
        context_->calls().vkCmdCopyBuffer(recording.commands(), in ? host.handle() : at(i).buffer,
                                          in ? at(i).buffer : host.handle(), 1, &region);
        recording.submit();
        if (out) std::memcpy(out, host.data(), host.bytes());
    }
    const FrameScene& scene_;
    std::shared_ptr<vulkan::Context> context_;
    std::vector<vulkan::Buffer> buffers_;
    std::unique_ptr<vulkan::Kernel> kernel_;
    VkQueryPool stamps_ = VK_NULL_HANDLE;
    int frame_ = 0;
};

} // namespace

Stepper on_device(const FrameScene& scene, std::shared_ptr<vulkan::Context> context, bool moves) {
    const auto frames = std::make_shared<VulkanFrames>(scene, std::move(context), moves);
    return {[frames](int count) { return frames->press(count); }, [frames] { return frames->made(); }};
}

} // namespace bench
