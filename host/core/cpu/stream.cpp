// SPDX-License-Identifier: MIT
#include "host/core/cpu/stream.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/cpu/pad_cells.hpp"
#include "host/core/model/laplacian.hpp"

#include <atomic>
#include <optional>

namespace dermis::cpu {

using model::StreamedSkin;
static_assert(simd::most_in_series == scene::most_in_series);

FramePress::FramePress(StreamedSkin s, int threads, const simd::Isa& isa)
    : streamed_(std::move(s)), rest_(streamed_.skin.padded_cells(), rest_place(streamed_.skin.chain)),
      tables_(streamed_, streamed_.skin.materials), cells_(streamed_.skin, streamed_.variant(), streamed_.skin.whole(),
                                                           simd::useful_threads(streamed_.skin.cells(), threads), isa) {
    std::ranges::copy(model::padded_rest_curvature<float>(streamed_.skin), rest_.data());
    model::drop_maps(streamed_.skin);
    presses_.reserve(together);
}

bool FramePress::press_frames(const model::FrameStep& step, const float* from, const float* frames, size_t count,
                              bool answers, float* const (&response)[RESPONSE_MAPS], size_t response_pitch) {
    if (count > 1 && step.before && *step.before != step.dt) // the first frame has coefficients of its own
        return press_frames(step, from, frames, 1, false, response, response_pitch) &&
               press_frames({step.dt, step.dt}, frames, frames + streamed_.skin.padded_cells(), count - 1, answers,
                            response, response_pitch);
    if (!prepare(step)) return false;
    const DefaultFloats guard;
    const f32::Constants constants = model::frame_constants(streamed_.skin, *tables_.of(0));
    f32::Constants silent = constants;
    silent.respond = 0;
    std::array<int, together> changed;
    presses_.clear(); // a call that ran out of memory has left some
    for (size_t i = 0; i < count; ++i) {
        const float* to = frames + i * streamed_.skin.padded_cells();
        presses_.push_back({.constants = answers && i + 1 == count ? constants : silent,
                            .table = tables_.of(0),
                            .pressure = std::exchange(from, to),
                            .pressure_to = to,
                            .rest_curvature = rest_.data(),
                            .response = std::to_array(response),
                            .response_pitch = response_pitch ? response_pitch : size_t(streamed_.skin.pitch)});
        // The one that answers is taken alone: the steps before it then need no rows beside a band.
        const bool full = presses_.size() == together || (answers && i + 2 == count);
        if (!full && i + 1 < count) continue;
        cells_.press(presses_, changed);
        presses_.clear();
    }
    return true;
}

bool FramePress::prepare(const model::FrameStep& step) {
    const DefaultFloats guard;
    double before = step.before.value_or(0);
    return !tables_.fill({}, {.dt = &step.dt, .before = &before, .parabolic = step.before.has_value()});
}

namespace {

using Responses = std::array<float*, RESPONSE_MAPS>;

// One skin. Threads share its rows.
class SkinStream : public model::Stream {
  public:
    SkinStream(const StreamedSkin& skin, int threads, const simd::Isa& isa)
        : press_(skin, threads, isa), width_(size_t(skin.skin.width())), pitch_(size_t(skin.skin.pitch)),
          cells_(skin.skin.cells()), held_(model::site_cells_of(skin.skin).cells) {
        const bool sites = !skin.skin.description.sites.empty();
        if (sites) sites_.emplace(skin.skin.description.sites, width_);
        int place = response_place(skin.skin.chain);
        for (Plane<float>& side : pressure_) side = Plane<float>(skin.skin.padded_cells(), place++);
        const auto made = [](Plane<float>& plane, size_t cells, int at) {
            plane = Plane<float>(cells, at);
            return plane.data();
        };
        const auto counts = model::response_counts(skin);
        for (size_t r = 0; r < RESPONSE_MAPS; ++r)
            if (skin.wanted[QUANTITY_SA1 + r]) {
                field_[r] = made(fields_[r], cells_, place++);
                response_[r] = sites ? made(felt_[r], counts[r], place) : field_[r];
            }
    }

    bool take(const model::PadList& pads, const float* pressure, bool) override {
        return pads.count == 0 || take(pressure, pressure_[1 - from_].data());
    }

    bool rests(int) const override { return false; }

    bool copy(const float* numbers, size_t count, float* to) override { // count: whole frames
        return copy_rows({.from = numbers, .stride = width_, .width = width_, .to = to, .pitch = width_},
                         count / width_);
    }

    const double* prepare(const model::PadList& pads, const model::StepLengths& dt) override {
        return pads.count == 0 || press_.prepare(dt.of(pads, 0)) ? nullptr : &dt[0];
    }

    void press(const model::PadList& pads, const model::StepLengths& dt, bool answers) override {
        if (pads.count == 0) return;
        (void)press_.press_frames(dt.of(pads, 0), pressure(), pressure_[1 - from_].data(), 1, answers, field_, width_);
        from_ = 1 - from_;
        if (sites_ && answers) sites_->read(std::to_array(field_), response_);
    }

    bool joins_frames() const override { return width_ == pitch_; } // rows are read where they stand, up to the pitch

    void press_frames(const model::PadList& pads, const float* frames, size_t count, size_t numbers,
                      const model::StepLengths& dt) override {
        (void)press_.press_frames(dt.of(pads, 0), pressure(), frames, count, true, field_, width_);
        take(frames + (count - 1) * numbers, pressure());
        if (sites_) sites_->read(std::to_array(field_), response_);
    }

    const float* response(Quantity q) override { return response_[size_t(q) - QUANTITY_SA1]; }

    void reset(const model::PadList& pads) override {
        if (pads.count == 0) return;
        press_.cells().rest();
        pressure_[from_].clear();
        for (auto* planes : {&fields_, &felt_})
            for (Plane<float>& plane : *planes) plane.clear();
    }

    void save(const model::PadList& pads, const model::StateMemory<char>& to) override { transfer(pads, to); }
    void load(const model::PadList& pads, const model::StateMemory<const char>& from) override { transfer(pads, from); }

    void read(const model::PadList& pads, const std::vector<model::HeldCell>& cells, size_t planes,
              float* to) override {
        const auto copy = [&](const float* map) {
            size_t end = width_; // of the row: divisions would take as long as the step
            for (const model::HeldCell& c : cells) {
                for (; c.cell >= end; end += width_) map += pitch_ - width_;
                *to++ = map[c.cell];
            }
        };
        if (pads.count == 0) return;
        press_.cells().each_plane([&](const float* map) {
            if (planes > 0) copy(map), --planes;
        });
        copy(pressure());
    }

    void set_elements(const model::PadList&, const std::vector<model::Element>& elements) override {
        press_.set_elements(elements);
    }

  private:
    float* pressure() const { return pressure_[from_].data(); } // that the next press starts from

    bool take(const float* frame, float* to) {
        return copy_rows({.from = frame, .stride = width_, .width = width_, .to = to, .pitch = pitch_},
                         cells_ / width_);
    }
    // Copies rows on the threads of a press. Returns whether all numbers are finite.
    bool copy_rows(const model::PressureCopy& copy, size_t rows) {
        std::atomic<bool> all = true;
        const auto some = [&](int first, int last) {
            if (!model::copy_rows(copy, first, last)) all = false;
        };
        press_.cells().pool().share(int(rows), std::ref(some)); // a reference: nothing is allocated
        return all;
    }
    // Copies the state to the caller's memory or, where that is const, from there.
    template <class Byte> void transfer(const model::PadList& pads, const model::StateMemory<Byte>& saved) {
        if (pads.count == 0) return;
        const size_t rows = cells_ / width_;
        Byte *strains = saved.strains, *pressed = saved.pressure;
        press_.cells().each_plane([&](float* plane) {
            for (size_t y = 0; held_.empty() && y < rows; ++y) model::copy_state(strains, plane + y * pitch_, width_);
            for (const size_t cell : held_)
                model::copy_state(strains, plane + cell / width_ * pitch_ + cell % width_, 1);
        });
        for (size_t y = 0; y < rows; ++y) model::copy_state(pressed, pressure() + y * pitch_, width_);
    }

    FramePress press_;
    Plane<float> pressure_[2];
    int from_ = 0;                                          // the side of the pressure that the next press starts from
    std::array<Plane<float>, RESPONSE_MAPS> fields_, felt_; // of cells, and of sites
    const size_t width_, pitch_, cells_;
    const std::vector<size_t> held_; // the cells that sites read; a saved state holds them alone; empty without sites
    std::optional<SitesOfFields> sites_;
    float* field_[RESPONSE_MAPS]{};
    Responses response_{};
};

// Whether a single skin is cheaper to press as one pad on one thread: its rows are short, or its sites few.
bool as_pads(const StreamedSkin& s, int threads) {
    const model::PreparedSkin& skin = s.skin;
    if (!skin.description.sites.empty() && PadCells::sparse(skin, model::site_cells_of(skin), threads)) return true;
    return skin.width() < 96 && threads == 1;
}

} // namespace

std::unique_ptr<model::Stream> stream(const StreamedSkin& skin, int threads, const simd::Isa& isa) {
    const DefaultFloats guard; // threads inherit it
    if (skin.by_signals()) return deep_stream(skin, stream(model::signals_of(skin), threads, isa), threads, isa);
    // a batch waits for no thread to wake, so that a second one pays from 16384 cells on
    const int useful = simd::useful_threads(skin.skin.cells() * size_t(skin.pads > 1 ? 4 * skin.pads : 1), threads);
    if (skin.pads == 1 && !as_pads(skin, useful)) return std::make_unique<SkinStream>(skin, threads, isa);
    return pad_stream(skin, std::min(skin.pads, useful), isa);
}

} // namespace dermis::cpu
