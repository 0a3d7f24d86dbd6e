// SPDX-License-Identifier: MIT
#include "bench/native.hpp"

#include "host/core/model/laplacian.hpp"

#include <algorithm>
#include <atomic>
#include <cfloat>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

namespace bench {

namespace {

using native::ExactStep;

// A cell of the reference: its strain and what is multiplied by the gain.
struct ReferenceCell {
    double strain = 0, integral = 0, rate = 0, acceleration = 0;
};

ReferenceCell after(const FrameScene& scene, const ExactStep<double>& k, int presses, size_t cell) {
    ReferenceCell c;
    for (size_t i = 0; i < size_t(presses); ++i) {
        const double from = double(scene.frames[i % 4].data()[cell]);
        const double way = double(scene.frames[(i + 1) % 4].data()[cell]) - from, r = from - k.E * c.strain;
        c.integral += k.i0 * c.strain + k.i1 * from + k.i2 * way;
        c.rate = k.v0 * r + k.v1 * way;
        c.acceleration = k.a0 * r + k.a1 * way;
        c.strain += k.b * r + k.f * way;
    }
    return c;
}

// The greatest error and the greatest value of each response.
struct Worst {
    std::array<double, 4> error{}, value{};

    void take(size_t response, double found, double exact) {
        const double off = std::abs(found - exact);
        error[response] = std::isfinite(off) ? std::max(error[response], off) : INFINITY;
        value[response] = std::max(value[response], std::abs(exact));
    }
};

class Reference {
  public:
    Reference(const FrameScene& scene, int presses)
        : scene_(scene), presses_(presses), rest_(dermis::model::padded_rest_curvature<float>(scene.skin())),
          k_(native::exact_step(scene.skin().materials[0].modulus, scene.skin().materials[0].viscosity, scene.dt)),
          n_(size_t(scene.skin().width())), pitch_(size_t(scene.skin().pitch)), height_(size_t(scene.skin().height())) {
    }

    size_t height() const { return height_; }

    // Compares rows first .. last - 1.
    Worst compare(const std::array<const float*, 4>& responses, size_t first, size_t last) const {
        Worst worst;
        std::vector<ReferenceCell> above = row(first ? first - 1 : 0), here = row(first), below;
        for (size_t y = first; y < last; ++y) {
            below = row(std::min(y + 1, height_ - 1)); // beyond the grid, a copy of the last row
            for (size_t x = 0; x < n_; ++x) {
                const ReferenceCell& c = here[x];
                const double beside = here[x ? x - 1 : 0].strain + here[std::min(x + 1, n_ - 1)].strain;
                const double laplacian = beside + above[x].strain + below[x].strain - 4 * c.strain;
                const double gain = 1 + double(rest_[y * pitch_ + x]) - laplacian;
                const double exact[4] = {c.strain, c.integral, c.rate, c.acceleration};
                for (size_t q = 0; q < 4; ++q) worst.take(q, double(responses[q][y * pitch_ + x]), exact[q] * gain);
            }
            above = std::exchange(here, std::move(below));
        }
        return worst;
    }

  private:
    std::vector<ReferenceCell> row(size_t y) const {
        std::vector<ReferenceCell> cells(n_);
        for (size_t x = 0; x < n_; ++x) cells[x] = after(scene_, k_, presses_, y * pitch_ + x);
        return cells;
    }

    const FrameScene& scene_;
    const int presses_;
    const std::vector<float> rest_;
    const ExactStep<double> k_;
    const size_t n_, pitch_, height_;
};

} // namespace

std::array<double, 4> errors_of_frames(const FrameScene& scene, int presses, int threads,
                                       const std::array<const float*, 4>& responses) {
    const Reference reference(scene, presses);
    dermis::simd::Pool pool(threads);
    std::vector<Worst> worst;
    std::mutex mutex;
    pool.share(int(reference.height()), [&](int first, int last) {
        const Worst own = reference.compare(responses, size_t(first), size_t(last));
        const std::lock_guard lock(mutex);
        worst.push_back(own);
    });
    std::array<double, 4> errors;
    for (size_t q = 0; q < 4; ++q) {
        double error = 0, value = 0;
        for (const Worst& w : worst) {
            error = std::max(error, w.error[q]);
            value = std::max(value, w.value[q]);
        }
        errors[q] = error / value;
    }
    return errors;
}

NativeFrames::NativeFrames(const FrameScene& scene, int threads, Way way)
    : scene_(scene), pool_(threads), rest_(scene.cells()),
      strain_((size_t(scene.skin().pitch) + 2 * native::lanes) * size_t(scene.skin().height())),
      integral_(scene.cells()), responses_{Floats(scene.cells()), Floats(scene.cells()), Floats(scene.cells()),
                                           Floats(scene.cells())},
      way_(way) {
    const dermis::model::PreparedSkin& skin = scene.skin();
    const dermis::scene::Element& material = skin.materials[0];
    const std::vector<float> rest = dermis::model::padded_rest_curvature<float>(skin);
    std::copy(rest.begin(), rest.end(), rest_.data());
    const size_t pitch = size_t(skin.pitch), strain_pitch = pitch + 2 * native::lanes;
    std::fill_n(strain_.data(), strain_pitch * size_t(skin.height()), 0.0f);
    std::fill_n(integral_.data(), scene.cells(), 0.0f);
    if (way == Way::two_passes)
        for (int i = 0; i < 2; ++i) rows_.emplace_back(scene.cells());
    else
        for (int i = 0; i < 4 * pool_.threads(); ++i) rows_.emplace_back(pitch);
    frame_ = {.step = native::exact_step<float>(material.modulus, material.viscosity, scene.dt),
              .width = size_t(skin.width()),
              .height = size_t(skin.height()),
              .pitch = pitch,
              .strain_pitch = strain_pitch,
              .rest = rest_.data(),
              .strain = strain_.data() + native::lanes,
              .integral = integral_.data()};
    if (frame_.width % native::lanes)
        throw std::runtime_error("the native peer: width = " + std::to_string(frame_.width) +
                                 "; allowed: multiples of 16");
    for (size_t r = 0; r < 4; ++r) frame_.responses[r] = responses_[r].data();
}

std::array<const float*, 4> NativeFrames::responses() const {
    return {responses_[0].data(), responses_[1].data(), responses_[2].data(), responses_[3].data()};
}

void NativeFrames::press(int count) {
    const size_t threads = size_t(pool_.threads());
    const auto share = [&](auto&& work) { // rows of each thread
        pool_.each([&](int thread) {
            const size_t t = size_t(thread);
            work(t, frame_.height * t / threads, frame_.height * (t + 1) / threads);
        });
    };
    const auto own = [&](size_t t) {
        const Floats* rows = rows_.data() + 4 * t;
        return native::ThreadRows{rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data()};
    };
    for (int i = 0; i < count; ++i, ++frames_) {
        frame_.from = scene_.frames[frames_ % 4].data();
        frame_.to = scene_.frames[(frames_ + 1) % 4].data();
        if (way_ == Way::two_passes) {
            float *rate = rows_[0].data(), *acceleration = rows_[1].data();
            share([&](size_t, size_t first, size_t last) {
                native::advance_rows(frame_, first, last, rate, acceleration);
            });
            share([&](size_t, size_t first, size_t last) {
                native::answer_rows(frame_, first, last, rate, acceleration);
            });
            continue;
        }
        if (threads > 1)
            share([&](size_t t, size_t first, size_t last) { native::step_beside(frame_, first, last, own(t)); });
        share([&](size_t t, size_t first, size_t last) {
            native::press_rows(frame_, first, last, own(t), way_ == Way::past_caches);
        });
    }
}

NativeMarch::NativeMarch(Skin skin, int threads) : skin_(std::move(skin)), pool_(threads) {
    const size_t materials = skin_.step_of_material.size();
    if (size_t(skin_.n) % width || !materials || materials > native::most_materials)
        throw std::runtime_error("the native march: n = " + std::to_string(skin_.n) + ", " + std::to_string(materials) +
                                 " materials; allowed: multiples of 256, 1 to 16 materials");
    for (int t = 0; t < pool_.threads(); ++t) tiles_.push_back(std::make_unique<TileMemory>());
}

native::Tile NativeMarch::TileMemory::tile() {
    return {.width = width,
            .height = height,
            .pitch = pitch,
            .strain = strain,
            .pressure = pressure,
            .material = material,
            .integral = integral,
            .rest = rest,
            .rate = rate,
            .acceleration = acceleration};
}

// A skin at rest. Beyond the grid the halo is a copy of the last cells inside.
void NativeMarch::load(TileMemory& m, size_t top, size_t left) const {
    const size_t n = size_t(skin_.n);
    std::fill_n(m.strain, with_halo, 0.0f);
    std::fill_n(m.integral, inside, 0.0f);
    for (size_t y = 0; y < height + 2; ++y) {
        const size_t row = std::clamp(top + y, size_t(1), n) - 1;
        for (size_t x = 0; x < pitch; ++x) {
            const size_t cell = row * n + std::clamp(left + x, native::lanes, n - 1 + native::lanes) - native::lanes;
            m.pressure[y * pitch + x] = skin_.pressure[cell];
            m.material[y * pitch + x] = skin_.material.empty() ? 0 : skin_.material[cell];
        }
    }
    for (size_t y = 0; y < height; ++y)
        std::copy_n(skin_.rest.data() + (top + y) * n + left, width, m.rest + y * width);
}

std::vector<native::Statistics> NativeMarch::run(const std::vector<native::Envelope>& steps) {
    const size_t n = size_t(skin_.n), across = n / width, count = across * (n / height);
    native::Statistics none{};
    std::fill_n(none.least, 5, FLT_MAX);
    std::fill_n(none.greatest, 5, -FLT_MAX);
    std::vector<std::vector<native::Statistics>> of_thread(tiles_.size(), {steps.size(), none});
    std::atomic<size_t> next = 0;
    pool_.each([&](int thread) {
        TileMemory& memory = *tiles_[size_t(thread)];
        for (size_t i = next++; i < count; i = next++) {
            load(memory, i / across * height, i % across * width);
            native::march_tile(memory.tile(), skin_.step_of_material.data(), skin_.step_of_material.size(),
                               steps.data(), steps.size(), of_thread[size_t(thread)].data());
        }
    });
    std::vector<native::Statistics> all = std::move(of_thread[0]);
    for (size_t t = 1; t < of_thread.size(); ++t)
        for (size_t i = 0; i < steps.size(); ++i)
            for (size_t q = 0; q < 5; ++q) {
                const native::Statistics& own = of_thread[t][i];
                all[i].sum[q] += own.sum[q];
                all[i].least[q] = std::min(all[i].least[q], own.least[q]);
                all[i].greatest[q] = std::max(all[i].greatest[q], own.greatest[q]);
            }
    return all;
}

} // namespace bench
