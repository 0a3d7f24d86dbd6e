// SPDX-License-Identifier: MIT
#include "bench/native_pads_loops.hpp"
#include "bench/skins.hpp"
#include "host/core/base/pool.hpp"
#include "host/core/model/coefficients.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/model/streamed_skin.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>

namespace bench {

using namespace dermis;

namespace {

native::PadStep step_of(const model::StreamedSkin& s) {
    const auto k = model::rounded<f32>(model::exact_coefficients(s.skin.materials[0], s.skin.rule, press_dt));
    const f32::Constants c = model::frame_constants(s.skin, k);
    return {k.E,
            k.b,
            k.f,
            k.i0,
            k.i1,
            k.i2,
            k.leak,
            k.v0,
            k.v1,
            k.a0,
            k.a1,
            k.a2,
            c.start,
            c.rise,
            c.jump,
            c.bend,
            c.curvature_length};
}

class NativePads {
  public:
    NativePads(const SkinDescription& d, int pads, int threads)
        : pads_(pads), cells_(size_t(d.grid.width) * size_t(d.grid.height)), pitch_((cells_ + 15) / 16 * 16),
          pool_(std::clamp(int(cells_ * size_t(pads) / 8192), 1, threads)), // a second thread pays from there
          rest_(pitch_), scratch_(size_t(pool_.threads()), std::vector<float>(2 * pitch_)) {
        const model::StreamedSkin skin = model::streamed_skin(d, in_f32());
        const auto width = size_t(d.grid.width);
        std::vector<double> row(width);
        for (size_t y = 0; y * width < cells_; ++y) {
            model::rest_curvature_row(skin.skin, int(y), 0, int(width), row.data());
            std::ranges::transform(row, rest_.begin() + long(y * width), [](double x) { return float(x); });
        }
        for (auto& inside : inside_) inside.assign(pitch_, 0);
        for (size_t i = 0; i < cells_; ++i) {
            const bool beside[4] = {i % width > 0, i % width < width - 1, i >= width, i + width < cells_};
            for (size_t k = 0; k < 4; ++k) inside_[k][i] = beside[k] ? -1 : 0;
        }
        const size_t beside = width + 16; // cells that are read before the first pad and behind the last one
        float* map[8];
        for (size_t m = 0; m < 8; ++m) { // each begins at other bits of an address
            maps_[m].assign(pitch_ * size_t(pads) + 2 * beside + 80 * m, 0);
            map[m] = maps_[m].data() + beside + 80 * m;
        }
        batch_ = {step_of(skin), cells_, width, pitch_, rest_.data(), {}, map[0], map[1], map[2], map[3], {}};
        for (size_t k = 0; k < 4; ++k) batch_.inside[k] = inside_[k].data(), batch_.responses[k] = map[4 + k];
    }
    void press(const float* pressure) {
        std::atomic<bool> finite = true;
        pool_.share(pads_, [&](int first, int last) {
            if (!native::take_pads(batch_, size_t(first), size_t(last), pressure)) finite = false;
        });
        if (!finite) throw std::runtime_error("the native pads: a pressure is not finite");
        pool_.each([&](int thread) {
            const auto at = [&](int t) { return size_t(pads_) * size_t(t) / size_t(pool_.threads()); };
            native::press_pads(batch_, at(thread), at(thread + 1), scratch_[size_t(thread)].data());
        });
        std::swap(batch_.from, batch_.to);
    }
    bool same(const Skin& skin) const {
        return std::ranges::all_of(std::array{0, 1, 2, 3}, [&](int r) {
            const Skin::Response own = skin.response(Quantity(r + 1));
            return std::memcmp(own.data, batch_.responses[r], own.size * sizeof(float)) == 0;
        });
    }

  private:
    const int pads_;
    const size_t cells_, pitch_;
    simd::Pool pool_;
    std::vector<float> rest_, maps_[8];
    std::vector<int> inside_[4];
    std::vector<std::vector<float>> scratch_; // of each thread
    native::PadBatch batch_{};
};

} // namespace

std::function<double()> native_pads(const Press& p, int threads, long long steps, const Frames& frames) {
    auto native = std::make_shared<NativePads>(p.skin, p.options.count, threads);
    const size_t cells = frames->size() / p.ring;
    const auto frame = [frames, cells, ring = p.ring](size_t i) { return frames->data() + i % ring * cells; };
    {
        Skin skin(Device::cpu(1), p.skin, p.options);
        for (size_t i = 0; i < 6; ++i) native->press(frame(i)), skin.press(frame(i), cells, press_dt);
        if (!native->same(skin)) throw std::runtime_error("the native pads differ from the batch");
    }
    return [=] {
        return seconds_of([&] {
            for (size_t i = 0; i < size_t(steps); ++i) native->press(frame(i));
        });
    };
}

} // namespace bench
