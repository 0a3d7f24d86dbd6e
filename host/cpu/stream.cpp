// SPDX-License-Identifier: MIT
#include "host/cpu/stream.hpp"

#include "host/cpu/cells.hpp"
#include "host/plan/float_environment.hpp"
#include "host/plan/site_stepper.hpp"
#include "host/simd/pool.hpp"

#include <atomic>
#include <cmath>
#include <optional>

namespace dermis::cpu {

using plan::StreamedSkin;

struct FramePress::Impl {
    explicit Impl(StreamedSkin s) : streamed(std::move(s)) {}
    virtual ~Impl() = default;
    virtual void run(const f32::Constants&, const float* from, const float* to, float* const (&response)[RESPONSE_MAPS],
                     size_t response_pitch) = 0;
    virtual void reset() = 0;
    virtual void save(float* planes) const = 0;
    virtual void load(const float* planes) = 0;
    virtual simd::Pool& pool() = 0;

    StreamedSkin streamed;
    std::vector<plan::Element> materials; // those that are stepped
    std::vector<f32::Coefficients> table; // theirs, of a press over table_dt
    double table_dt = std::nan("");
};

struct FramePress::Fields : Impl {
    Fields(StreamedSkin s, int threads, const simd::Isa& isa)
        : Impl(std::move(s)), rest(streamed.skin.padded_cells(), rest_place(streamed.skin.chain)),
          cells(streamed.skin, streamed.variant(), streamed.skin.whole(), threads, isa) {
        materials = streamed.skin.materials;
        std::ranges::copy(plan::padded_rest_curvature<float>(streamed.skin), rest.data());
        plan::drop_maps(streamed.skin);
    }

    void run(const f32::Constants& c, const float* from, const float* to, float* const (&response)[RESPONSE_MAPS],
             size_t response_pitch) override {
        const CellsPress<f32> press{.constants = c,
                                    .table = table.data(),
                                    .pressure = from,
                                    .pressure_to = to,
                                    .rest_curvature = rest.data(),
                                    .response = std::to_array(response),
                                    .response_pitch = response_pitch};
        int changed;
        cells.press({&press, 1}, {&changed, 1});
    }

    void reset() override { cells.rest(); }
    void save(float* planes) const override { cells.save(planes); }
    void load(const float* planes) override { cells.load(planes); }
    simd::Pool& pool() override { return cells.pool(); }

    const Plane<float> rest;
    Cells<f32> cells;
};

struct FramePress::Sites : Impl {
    Sites(StreamedSkin s, int threads)
        : Impl(std::move(s)), threads_(threads),
          cells(streamed.skin, {streamed.skin.whole()}, site_cells(streamed.skin)),
          stepper(streamed.skin, cells, streamed.variant()) {
        for (const Cell& c : cells.points) points.push_back(stepper.point(c));
        for (auto* pressure : {&from, &to}) pressure->resize(cells.cells.size());
        materials = cells.materials;
        lanes.resize(materials.size());
        plan::drop_maps(streamed.skin);
    }

    static std::vector<Cell> site_cells(const plan::PreparedSkin& skin) {
        std::vector<Cell> at;
        for (const Site& site : skin.description.sites) at.push_back(site.cell);
        return at;
    }

    void run(const f32::Constants& c, const float* p, const float* q, float* const (&response)[RESPONSE_MAPS],
             size_t) override {
        std::transform(table.begin(), table.end(), lanes.begin(), f32::lanes_of);
        const size_t width = size_t(streamed.skin.width()), pitch = size_t(streamed.skin.pitch);
        for (size_t i = 0; i < from.size(); ++i) {
            const size_t cell = cells.cells[i], at = cell / width * pitch + cell % width;
            from[i] = p[at];
            to[i] = q[at];
        }
        stepper.advance(c, lanes.data(), {from.data(), to.data()}, 0, from.size());
        std::array<size_t, RESPONSE_MAPS> next{};
        for (size_t i = 0; i < points.size(); ++i) {
            const Quantity type = streamed.skin.description.sites[i].type;
            const size_t r = size_t(type) - QUANTITY_SA1;
            response[r][next[r]++] = stepper.value(points[i], type, c, lanes.data(), {from.data(), to.data()});
        }
        stepper.keep();
    }

    void reset() override { stepper.reset(); }
    void save(float* planes) const override { stepper.save(planes, streamed.wanted[QUANTITY_SA2]); }
    void load(const float* planes) override { stepper.load(planes, streamed.wanted[QUANTITY_SA2]); }
    simd::Pool& pool() override { return threads_; }

    simd::Pool threads_; // take in the pressure
    const plan::SiteCells cells;
    plan::SiteStepper<f32> stepper;
    std::vector<plan::SiteStepper<f32>::Point> points;
    std::vector<float> from, to; // pressures of the cells
    std::vector<f32::LaneCoefficients> lanes;
};

FramePress::FramePress(StreamedSkin skin, int threads, const simd::Isa& isa) {
    const DefaultFloats guard; // threads inherit it
    threads = simd::useful_threads(skin.skin.cells(), threads);
    if (skin.skin.description.sites.empty()) impl_ = std::make_unique<Fields>(std::move(skin), threads, isa);
    else impl_ = std::make_unique<Sites>(std::move(skin), threads);
    impl_->table.resize(impl_->materials.size());
}

FramePress::~FramePress() = default;

void FramePress::reset() { impl_->reset(); }
void FramePress::save(float* planes) const { impl_->save(planes); }
void FramePress::load(const float* planes) { impl_->load(planes); }

bool FramePress::copy(const float* pressure, size_t stride, float* to) {
    const plan::PreparedSkin& skin = impl_->streamed.skin;
    struct {
        plan::PressureCopy copy;
        long long rows, threads;
        std::atomic<bool> finite = true;
    } job{.copy = {.from = pressure,
                   .stride = stride,
                   .width = size_t(skin.width()),
                   .to = to,
                   .pitch = size_t(skin.pitch)},
          .rows = skin.height(),
          .threads = impl_->pool().threads()};
    impl_->pool().each([&job](int thread) { // captures so little that nothing is allocated
        if (!copy_rows(job.copy, int(job.rows * thread / job.threads), int(job.rows * (thread + 1) / job.threads)))
            job.finite = false;
    });
    return job.finite;
}

bool FramePress::press(double dt, const float* from, const float* to, float* const (&response)[RESPONSE_MAPS]) {
    return press(dt, from, to, response, size_t(impl_->streamed.skin.pitch));
}

bool FramePress::press(double dt, const float* from, const float* to, float* const (&response)[RESPONSE_MAPS],
                       size_t response_pitch) {
    const DefaultFloats guard;
    Impl& s = *impl_;
    if (dt != s.table_dt) {
        s.table_dt = std::nan(""); // the table is no longer that of any dt
        const plan::PreparedSkin& skin = s.streamed.skin;
        if (!plan::fill_table(s.materials, skin.chain, skin.rule, dt, s.table.data())) return false;
        s.table_dt = dt;
    }
    s.run(plan::frame_constants(s.streamed.skin, s.table.front()), from, to, response, response_pitch);
    return true;
}

namespace {

// Maps that are walked side by side: each begins at a cache line, and at other bits of an address than its neighbours,
// which would otherwise compete for the same lines of a cache.
class SideBySide {
  public:
    explicit SideBySide(const std::vector<size_t>& sizes) {
        size_t all = line;
        for (size_t size : sizes) all += size + gap;
        values_ = simd::map_of(all, 0.0f);
        size_t at = (64 - reinterpret_cast<uintptr_t>(values_.data()) % 64) % 64 / sizeof(float);
        for (size_t size : sizes) {
            begins_.push_back(values_.data() + at);
            at += (size + line - 1) / line * line + 5 * line;
        }
    }
    float* operator[](size_t i) const { return begins_[i]; }
    void clear() { std::fill(values_.begin(), values_.end(), 0.0f); }

  private:
    static constexpr size_t line = 64 / sizeof(float), gap = 6 * line;
    std::vector<float> values_;
    std::vector<float*> begins_;
};

class CpuStream : public plan::Stream {
  public:
    CpuStream(const StreamedSkin& skin, int threads, const simd::Isa& isa)
        : press_(skin, threads, isa), memory_(sizes_of(skin)), layout_(state_layout_of(skin)),
          width_(size_t(skin.skin.width())), pitch_(size_t(skin.skin.pitch)) {
        for (size_t i = 0; i < 2; ++i) pressure_[i] = memory_[i];
        for (size_t r = 0; r < RESPONSE_MAPS; ++r)
            response_[r] = skin.wanted[QUANTITY_SA1 + r] ? memory_[2 + r] : nullptr;
    }

    // The map that is overwritten is the one before the last press, which nobody needs any more.
    bool take(const float* pressure, size_t stride) override { return press_.copy(pressure, stride, pressure_[1]); }

    bool press(double dt) override {
        if (!press_.press(dt, pressure_[0], pressure_[1], response_, width_)) return false;
        std::swap(pressure_[0], pressure_[1]);
        return true;
    }

    const float* response(Quantity q) const override { return response_[size_t(q) - QUANTITY_SA1]; }

    void reset() override {
        press_.reset();
        memory_.clear();
    }

    void save(float* state) override {
        press_.save(state);
        float* to = state + layout_.cells * layout_.planes;
        for (size_t i = 0; i < layout_.pressure; i += width_, to += width_)
            std::copy_n(pressure_[0] + i / width_ * pitch_, width_, to);
    }

    void load(const float* state) override {
        press_.load(state);
        const float* from = state + layout_.cells * layout_.planes;
        for (size_t i = 0; i < layout_.pressure; i += width_, from += width_)
            std::copy_n(from, width_, pressure_[0] + i / width_ * pitch_);
    }

  private:
    static std::vector<size_t> sizes_of(const StreamedSkin& skin) {
        const size_t map = skin.skin.padded_cells();
        std::vector<size_t> sizes = {map, map};
        const plan::ResponseLayout layout = response_layout_of(skin);
        const bool fields = skin.skin.description.sites.empty();
        for (size_t q = QUANTITY_SA1; q < REDUCED_MAPS; ++q)
            sizes.push_back(fields && skin.wanted[q] ? skin.skin.cells() : layout.of[q].count);
        return sizes;
    }

    FramePress press_;
    SideBySide memory_; // two pressures, then the responses
    const plan::StateLayout layout_;
    const size_t width_, pitch_;
    float* pressure_[2];
    float* response_[RESPONSE_MAPS];
};

} // namespace

std::unique_ptr<plan::Stream> stream(const StreamedSkin& skin, int threads, const simd::Isa& isa) {
    return std::make_unique<CpuStream>(skin, threads, isa);
}

} // namespace dermis::cpu
