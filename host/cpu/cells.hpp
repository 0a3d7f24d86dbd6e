// SPDX-License-Identifier: MIT
// The state of every cell and one pass over it per step, in K = f32 or f64. Rows are stepped in place; responses follow
// as far behind as the stencil reaches, while the rows are still in a cache. A thread makes for itself the new strain
// that its rows need of other threads' rows, before any thread begins to step.
#pragma once

#include "host/cpu/planes.hpp"
#include "host/plan/skin.hpp"
#include "host/simd/isa.hpp"

#include <array>
#include <barrier>

namespace dermis::cpu {

// One press. Maps have pitch*height cells, summaries one for each tile of each row.
template <class K> struct CellsPress {
    using real = typename K::real;
    const typename K::Constants& constants;
    const typename K::Coefficients* table; // of the materials, where there are several
    const real *pressure, *pressure_to;    // pressure_to is null without frames
    const real* rest_curvature;
    bool keep = true;                            // the state advances; otherwise the step goes to a scratch state
    std::array<real*, RESPONSE_MAPS> response{}; // null: not wanted
    std::array<typename K::Summary*, REDUCED_MAPS> tiles{}; // null: not wanted
};

// The places of planes: those of a state, of a worker's signals, the rest curvature's, and the first that is left for
// responses.
constexpr int signal_place = 2 * simd::state_sums, rest_place = signal_place + 3 * STEP_SIGNALS + 1,
              response_place = rest_place + 1;

// The share of one thread, and its scratch: new strain of rows outside its share, and what belongs to a step but
// not to the state.
template <class real> struct Worker {
    int first = 0, last = 0; // rows
    std::array<Plane<real>, 8> outside;
    std::array<int, 8> row{}; // which rows those are
    int count = 0, changed = 0;
    std::array<std::array<Plane<real>, 3>, STEP_SIGNALS> signals; // of the last rows, each at y % 3
    std::array<Plane<real>, 2 * simd::state_sums + STEP_SIGNALS> unused;
};

template <class K> class Cells {
  public:
    using real = typename K::real;
    using Constants = typename K::Constants;
    using Summary = typename K::Summary;

    using Press = CellsPress<K>;

    Cells(const plan::PreparedSkin& skin, const plan::Variant& variant, const plan::PressedBox& pressed, int threads,
          const simd::Isa& isa)
        : height_(skin.height()), width_(skin.width()), pitch_(skin.pitch), tiles_(skin.tiles),
          material_of_(skin.material_of), variant_(variant), pressed_(pressed), pool_(threads), isa_(isa),
          loops_(isa.of<K>()), barrier_(pool_.threads()), state_(resting_state()), workers_(size_t(pool_.threads())) {
        for (Worker<real>& worker : workers_) {
            int place = signal_place;
            for (Plane<real>& row : worker.outside) row = Plane<real>(size_t(pitch_), 0);
            for (Plane<real>& row : worker.unused) row = Plane<real>(size_t(pitch_), 0);
            for (auto& ring : worker.signals)
                for (Plane<real>& row : ring) row = Plane<real>(size_t(pitch_), ++place);
        }
    }

    // Returns what changed in some cell: simd::strain_changed, simd::integral_changed. Without sums it may return more.
    int press(const Press& p) {
        if (!p.keep && scratch_.empty()) scratch_ = resting_state();
        visible_ = p.keep ? &state_ : &scratch_;
        pool_.each([&](int thread) { work(p, thread); });
        int changed = 0;
        for (const Worker<real>& worker : workers_) changed |= worker.changed;
        return changed;
    }

    // The strain that the last press made.
    const real* strain() const { return visible_->strain(); }

    void rest() { state_.rest(size_t(pitch_) * size_t(height_)); }

    simd::Pool& pool() { return pool_; }

  private:
    State<real> resting_state() const { return {size_t(pitch_) * size_t(height_), variant_.compensated}; }

    int first_column() const { return pressed_.first_column(); }
    int last_column() const { return pressed_.last_column(width_); }

    void work(const Press& press, int thread) {
        Worker<real>& worker = workers_[size_t(thread)];
        const long long rows = pressed_.last_row - pressed_.first_row, threads = pool_.threads();
        worker.first = pressed_.first_row + int(rows * thread / threads);
        worker.last = pressed_.first_row + int(rows * (thread + 1) / threads);
        worker.changed = 0;
        const int reach = K::reach(variant_.stencil);
        const bool respond = press.constants.respond != 0;
        if (respond) {
            worker.count = 0;
            for (int y = worker.first; y < worker.last; ++y) {
                if (y == worker.first + reach) y = std::max(y, worker.last - reach);
                step_outside(press, worker, y);
            }
            if (threads > 1) barrier_.arrive_and_wait();
        }
        for (int y = worker.first; y < worker.last + reach; ++y) {
            const bool advances = y < worker.last, responds = respond && y - reach >= worker.first;
            const auto stepped = [&] {
                return advance_arguments(press, y, visible_->row(y, pitch_),
                                         [&](size_t s) { return worker.signals[s][size_t(y % 3)].data(); });
            };
            const auto answered = [&] { return respond_arguments(press, worker, y - reach); };
            if (advances && responds) worker.changed |= loops_.step_row(stepped(), answered(), press.constants);
            else if (advances) worker.changed |= loops_.advance(stepped(), press.constants);
            else if (responds) loops_.respond(answered(), press.constants);
        }
        isa_.fence_streams();
    }

    // Whether the state holds row i's new strain by the time that the worker's row y responds.
    bool ready(const Worker<real>& worker, int i, int y) const {
        const bool pressed = i >= pressed_.first_row && i < pressed_.last_row; // others rest for ever
        return !pressed || (i >= worker.first && i < worker.last && i <= y + K::reach(variant_.stencil));
    }

    // Steps, for the worker alone, the rows of other shares that its row y reads.
    void step_outside(const Press& press, Worker<real>& worker, int y) {
        const f64::Axis a = f64::axis(y, height_, variant_.stencil, variant_.edges);
        for (int i : {a.far_low, a.low, a.high, a.far_high}) {
            const auto known = worker.row.begin() + worker.count;
            if (ready(worker, i, y) || std::find(worker.row.begin(), known, i) != known) continue;
            worker.row[size_t(worker.count)] = i;
            const auto unused = [&](size_t plane) { return worker.unused[plane].data(); };
            simd::StateRow<real> to{};
            for (size_t s = 0; s < simd::state_sums; ++s) {
                to.value[s] = s == simd::sum_strain ? worker.outside[size_t(worker.count)].data() : unused(s);
                to.lost[s] = variant_.compensated ? unused(simd::state_sums + s) : nullptr;
            }
            loops_.advance(advance_arguments(press, i, to, [&](size_t s) { return unused(2 * simd::state_sums + s); }),
                           press.constants);
            ++worker.count;
        }
    }

    // signal(s): where signal s of the step goes, from column 0 on.
    template <class Signal>
    simd::AdvanceArguments<K> advance_arguments(const Press& press, int y, const simd::StateRow<real>& to,
                                                Signal signal) const {
        const int at = first_column();
        const size_t row = size_t(y) * size_t(pitch_) + size_t(at);
        simd::AdvanceArguments<K> a{.count = last_column() - at,
                                    .pressure = press.pressure + row,
                                    .pressure_to = press.pressure_to ? press.pressure_to + row : nullptr,
                                    .material = material_of_.empty() ? nullptr : material_of_.data() + row,
                                    .table = press.table,
                                    .from = state_.row(y, pitch_),
                                    .to = to,
                                    .signal = {}};
        for (simd::StateRow<real>* state : {&a.from, &a.to})
            for (size_t s = 0; s < simd::state_sums; ++s) {
                state->value[s] += at;
                if (state->lost[s]) state->lost[s] += at;
            }
        for (size_t s = 0; s < STEP_SIGNALS; ++s) a.signal[s] = signal(s) + at;
        return a;
    }

    simd::RespondArguments<K> respond_arguments(const Press& press, const Worker<real>& worker, int y) const {
        const size_t row = size_t(y) * size_t(pitch_), tile = size_t(y) * size_t(tiles_);
        const auto strain = [&](int i) -> const real* {
            if (ready(worker, i, y)) return visible_->row(i, pitch_).value[simd::sum_strain];
            const auto known = worker.row.begin() + worker.count, at = std::find(worker.row.begin(), known, i);
            return worker.outside[size_t(at - worker.row.begin())].data();
        };
        const simd::StateRow<real> state = visible_->row(y, pitch_);
        simd::RespondArguments<K> r{
            .first = first_column(),
            .last = last_column(),
            .strain = simd::neighbours<real>(y, width_, height_, variant_.stencil, variant_.edges, strain),
            .signal = {state.value[simd::sum_strain], state.value[simd::sum_integral]}, // SA1, SA2
            .rest_curvature = press.rest_curvature + row,
            .response = {},
            .tiles = {}};
        for (size_t s = 0; s < STEP_SIGNALS; ++s)
            r.signal[QUANTITY_FA1 - QUANTITY_SA1 + s] = worker.signals[s][size_t(y % 3)].data();
        for (size_t i = 0; i < RESPONSE_MAPS; ++i)
            r.response[i] = press.response[i] ? press.response[i] + row : nullptr;
        for (size_t q = 0; q < REDUCED_MAPS; ++q) r.tiles[q] = press.tiles[q] ? press.tiles[q] + tile : nullptr;
        return r;
    }

    const int height_, width_, pitch_, tiles_;
    const std::vector<int>& material_of_;
    const plan::Variant variant_;
    const plan::PressedBox pressed_;
    simd::Pool pool_;
    const simd::Isa& isa_;
    const simd::Loops<K>& loops_;
    std::barrier<> barrier_;
    State<real> state_, scratch_;    // scratch_: of steps that are not kept
    State<real>* visible_ = &state_; // what the last press made
    std::vector<Worker<real>> workers_;
};

} // namespace dermis::cpu
