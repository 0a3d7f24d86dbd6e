// SPDX-License-Identifier: MIT
// The state of every cell and the pass over it that takes one step, or a batch of steps, in K = f32 or f64. The strain
// of a cell does not depend on its neighbours: a band of rows can take all steps of a batch while it is in a cache. It
// steps copies of the rows outside it that the stencils of its own rows read. Rows are stepped in place; a row responds
// once the rows that its stencil reads have been stepped.
#pragma once

#include "host/core/cpu/planes.hpp"
#include "host/core/model/skin.hpp"
#include "host/core/simd/isa.hpp"

#include <array>
#include <atomic>
#include <barrier>
#include <functional>
#include <numeric>
#include <span>

namespace dermis::cpu {

// One press. Maps have pitch*height cells, summaries one for each tile of each row.
template <class K> struct CellsPress {
    using real = typename K::real;
    const typename K::Constants& constants;
    const typename K::Coefficients* table; // the coefficients of each element, where there are several
    // Null where `table` holds all coefficients. Else it writes the coefficients of all cells of row y, each cell its
    // own.
    const std::function<void(int y, typename K::Coefficients* row)>* fill_row = nullptr;
    const real *pressure, *pressure_to; // pressure_to is null without frames
    const real* rest_curvature;
    bool keep = true;                            // the state advances; otherwise the step goes to a scratch state
    std::array<real*, RESPONSE_MAPS> response{}; // null: not wanted
    size_t response_pitch;                       // cells from row to row of a response
    std::array<typename K::Summary*, REDUCED_MAPS> tiles{}; // null: not wanted
    double* points = nullptr; // [quantity][point], of quantities that are summarized; null: not wanted
};

// The `place`s of planes (see Plane) that follow a state's planes: of a worker's first signal, of the rest curvature,
// and of the first response.
inline int signal_place(const model::Chain& chain) {
    return 2 * (int(chain.elements()) + 1) + (chain.length > 1 ? 2 : 0);
}
inline int rest_place(const model::Chain& chain) { return signal_place(chain) + 3 * STEP_SIGNALS + 1; }
inline int response_place(const model::Chain& chain) { return rest_place(chain) + 1; }

// The points: cells whose values are read. They are found by row.
class PointsOfRows {
  public:
    struct Point {
        int y, x;
        size_t index;
    };
    explicit PointsOfRows(const std::vector<Cell>& cells) {
        for (const Cell& c : cells) points_.push_back({c.y, c.x, points_.size()});
        std::stable_sort(points_.begin(), points_.end(), [](auto& a, auto& b) { return a.y < b.y; });
    }
    size_t count() const { return points_.size(); }
    std::span<const Point> of(int y) const {
        const auto first = std::ranges::lower_bound(points_, y, {}, &Point::y);
        const auto last = std::ranges::upper_bound(points_, y, {}, &Point::y);
        return {points_.data() + (first - points_.begin()), size_t(last - first)};
    }
    // The first row from y on that has a point; `none` if no row has.
    int next(int y, int none) const {
        const auto point = std::ranges::lower_bound(points_, y, {}, &Point::y);
        return point == points_.end() ? none : point->y;
    }

  private:
    std::vector<Point> points_;
};

// Rows first .. last - 1, and copies of the strain of rows outside the band that the stencils of its rows read.
template <class real> struct Band {
    struct Outside {
        int row;
        State<real> state; // of that row; its integral is never read
    };
    int first, last;
    std::vector<Outside> outside;
    size_t place_of(int row) const {
        return size_t(std::find_if(outside.begin(), outside.end(), [row](auto& o) { return o.row == row; }) -
                      outside.begin());
    }
};

// The scratch of one thread.
template <class K> struct Worker {
    using real = typename K::real;
    std::vector<int> changed;                                     // for each press, the bits of the sums that changed
    std::array<std::array<Plane<real>, 3>, STEP_SIGNALS> signals; // the signals of row y, at y % 3
    std::array<Plane<real>, 5> strain; // the strain of row y, at y % 5, where the state does not hold the strain
    std::array<State<real>, 8> peeked; // states of rows outside the band, at the end of a step that is not kept
    std::array<Plane<real>, RESPONSE_MAPS> answered;    // the responses of a row that has points
    std::vector<typename K::Coefficients> coefficients; // the coefficients of a row's cells
};

template <class K> class Cells {
  public:
    using real = typename K::real;
    using Constants = typename K::Constants;
    using Summary = typename K::Summary;

    using Press = CellsPress<K>;

    // points: the cells whose values presses give.
    Cells(const model::PreparedSkin& skin, const model::Variant& variant, const model::PressedBox& pressed, int threads,
          const simd::Isa& isa, const std::vector<Cell>& points = {})
        : height_(skin.height()), width_(skin.width()), pitch_(skin.pitch), tiles_(skin.tiles),
          material_of_(skin.material_of), line_material_(shared_in_lines(material_of_)), variant_(variant),
          pressed_(pressed), points_(points), pool_(threads), isa_(isa), loops_(isa.of<K>()), barrier_(pool_.threads()),
          state_(resting_state()), resting_row_(size_t(pitch_), 0), shares_(bands(pool_.threads())),
          workers_(size_t(pool_.threads())) {
        for (Worker<K>& worker : workers_) {
            int place = signal_place(variant_.chain);
            worker.changed.resize(1);
            const auto make = [this](auto& rows) {
                for (Plane<real>& row : rows) row = Plane<real>(size_t(pitch_), 0);
            };
            make(worker.answered);
            for (State<real>& row : worker.peeked) row = row_state();
            for (auto& ring : worker.signals)
                for (Plane<real>& row : ring) row = Plane<real>(size_t(pitch_), ++place);
            if (rolls()) make(worker.strain);
        }
    }

    // Takes presses in order. changed: for each press the bits simd::strain_changed and simd::integral_changed, set
    // where the sum of some cell changed; where no sums of responses are asked for, they may be set without need. A
    // single press allocates nothing.
    void press(std::span<const Press> presses, std::span<int> changed) {
        if (presses.front().fill_row && column_.empty()) prepare_rows();
        for (const Press& p : presses)
            if (!p.keep && scratch_.empty()) scratch_ = resting_state();
        visible_ = &stepped(presses.back());
        if (presses.size() > 1 && bands_.empty()) bands_ = bands(count_of_bands());
        Batch batch{presses, presses.size() > 1 ? bands_ : shares_, pool_.threads()};
        for (Worker<K>& worker : workers_)
            if (worker.changed.size() < presses.size()) worker.changed.resize(presses.size());
        pool_.each([&](int thread) { work(batch, thread); });
        for (size_t i = 0; i < presses.size(); ++i) {
            changed[i] = 0;
            for (const Worker<K>& worker : workers_) changed[i] |= worker.changed[i];
        }
    }

    // The strain of every cell after the last press. Only for a single element, or a variant that keeps the strain.
    const real* strain() const { return visible_->strain(); }

    void rest() { state_.rest(); }

    // Calls f with the first number of each plane that is saved; its rows are a pitch apart.
    template <class F> void each_plane(F f) const { state_.each_plane(f); }

    simd::Pool& pool() { return pool_; }

  private:
    State<real> resting_state() const { return {size_t(pitch_) * size_t(height_), variant_.state()}; }
    State<real> row_state() const { // nobody reads the rate of a spring there
        model::StateShape shape = variant_.state();
        shape.strain = variant_.chain.length > 1;
        shape.rate = false;
        return {size_t(pitch_), shape};
    }

    // Whether responses are stored past the caches. Measured: one thread gains where the responses exceed 2 MiB and
    // each row begins at a half of a cache line, several threads where the maps of a press exceed a third of the cache
    // that they share.
    bool streams(const Press& press) const {
        const size_t maps = press.response_pitch * size_t(height_) * sizeof(real), all = RESPONSE_MAPS + 5;
        if (maps * RESPONSE_MAPS <= size_t(2) << 20) return false;
        return pool_.threads() == 1 ? press.response_pitch % (PITCH_CELLS / 2) == 0
                                    : maps * all > simd::last_level_cache() / 3;
    }

    // Whether a cell's strain is a sum of several elements that is kept only for the rows that a stencil reads.
    bool rolls() const { return variant_.chain.length > 1 && !variant_.keeps_strain; }

    int first_column() const { return pressed_.first_column(); }
    int last_column() const { return pressed_.last_column(width_); }

    void prepare_rows() {
        column_.resize(size_t(pitch_));
        std::iota(column_.begin(), column_.end(), 0);
        const size_t chain = variant_.chain.length;
        for (int& x : column_) x *= int(chain);
        for (Worker<K>& worker : workers_)
            worker.coefficients.resize(size_t(pitch_) * chain * (1 + variant_.parabolic)); // 0 beyond the row's end
    }

    struct Batch {
        std::span<const Press> presses;
        std::vector<Band<real>>& bands;
        std::atomic<int> next; // the first band that no thread has taken
    };

    // The state that a press writes.
    State<real>& stepped(const Press& press) { return press.keep ? state_ : scratch_; }

    // Returns the number of bands of a batch: a step of one band reads and writes three quarters of the second-level
    // cache, and every thread gets the same number of bands, so that threads end together.
    int count_of_bands() const {
        const size_t sums = variant_.chain.elements() + 1, planes = (variant_.compensated ? 2 : 1) * sums +
                                                                    variant_.keeps_strain +
                                                                    (variant_.framed ? 3 + variant_.parabolic : 2);
        const size_t row = size_t(pitch_) * (planes * sizeof(real) + (material_of_.empty() ? 0 : sizeof(int)));
        const int rows = pressed_.last_row - pressed_.first_row, threads = pool_.threads(),
                  of_band = std::max(int(simd::second_level_cache() * 3 / 4 / row), 4 * K::reach(variant_.stencil));
        const int count = (rows + of_band - 1) / of_band;
        return std::clamp((count + threads - 1) / threads * threads, threads, std::max(rows, threads));
    }

    std::vector<Band<real>> bands(int count) const {
        const long long rows = pressed_.last_row - pressed_.first_row;
        const int reach = K::reach(variant_.stencil);
        std::vector<Band<real>> all;
        for (int b = 0; b < count; ++b) {
            Band<real>& band = all.emplace_back();
            band.first = pressed_.first_row + int(rows * b / count);
            band.last = pressed_.first_row + int(rows * (b + 1) / count);
            for (int y = band.first; y < band.last; ++y) {
                if (y == band.first + reach) y = std::max(y, band.last - reach);
                const f64::Axis a = f64::axis(y, height_, variant_.stencil, variant_.edges);
                for (int i : {a.far_low, a.low, a.high, a.far_high})
                    if (const size_t k = band.place_of(i); !ready(band, i, y) && k == band.outside.size())
                        band.outside.push_back({i, row_state()});
            }
        }
        return all;
    }

    // Whether the new strain of row i has been computed, and is still held, when row y of the band responds.
    bool ready(const Band<real>& band, int i, int y) const {
        const int reach = K::reach(variant_.stencil);
        if (!is_pressed(i)) return true;
        return i >= band.first && i < band.last && i <= y + reach && !(rolls() && i < y - reach);
    }
    bool is_pressed(int y) const { return y >= pressed_.first_row && y < pressed_.last_row; } // others rest for ever

    void work(Batch& batch, int thread) {
        Worker<K>& worker = workers_[size_t(thread)];
        const size_t count = batch.bands.size(), threads = size_t(pool_.threads());
        std::fill(worker.changed.begin(), worker.changed.end(), 0);
        const bool responds = std::ranges::any_of(batch.presses, [](auto& p) { return p.constants.respond != 0; });
        if (responds) {
            for (size_t b = size_t(thread); b < count; b += threads) take_outside(batch.bands[b]);
            if (threads > 1) barrier_.arrive_and_wait();
        }
        for (size_t b = size_t(thread); b < count; b = size_t(batch.next++))
            for (size_t i = 0; i < batch.presses.size(); ++i)
                worker.changed[i] |= step(batch.presses[i], batch.bands[b], worker, responds);
        isa_.fence_streams();
    }

    // Copies the strain of rows outside a band before anybody steps them.
    void take_outside(Band<real>& band) const {
        for (auto& o : band.outside) o.state.take_strains(state_.row(o.row, pitch_), size_t(pitch_));
    }

    // Takes one step of a band. beside: of the rows outside it too, because this step or a later one of the batch
    // responds. Returns what changed.
    int step(const Press& press, Band<real>& band, Worker<K>& worker, bool beside) {
        const int reach = K::reach(variant_.stencil);
        const bool respond = press.constants.respond != 0;
        State<real>& to = stepped(press);
        int changed = 0;
        for (size_t k = 0; beside && k < band.outside.size(); ++k) step_outside(press, band.outside[k], k, worker);
        for (int y = band.first, rows; y < band.last + reach; y += rows) {
            rows = 1;
            const bool advances = y < band.last, responds = respond && y - reach >= band.first;
            const auto arguments = [&] {
                simd::StateRow<real> row = to.row(y, pitch_);
                if (rolls()) row.strain = rolled(worker, y);
                return advance_arguments(press, worker, y, state_.row(y, pitch_), row, [&](size_t s) -> real* {
                    const bool read = respond && variant_.wanted[QUANTITY_FA1 + s];
                    return read ? worker.signals[s][size_t(y % 3)].data() + first_column() : nullptr;
                });
            };
            if (!responds) {
                if (advances) changed |= loops_.advance(arguments(), press.constants);
                continue;
            }
            const simd::RespondArguments<K> answered = respond_arguments(press, band, worker, y - reach);
            if (advances) {
                rows = rows_alike(press, band, y);
                changed |= loops_.step_rows(row_steps(press, worker, arguments(), answered, y, rows), press.constants);
            } else {
                loops_.respond(answered, press.constants);
            }
            if (press.points) read_points(press, answered, y - reach);
        }
        return changed;
    }

    // The number of rows, from row y on, that one call of Loops::step_rows takes: their arguments differ by a fixed
    // distance. 1 where a row needs arguments of its own, because it is read, and for the first 2*reach rows of a band,
    // because their stencils read rows outside it.
    int rows_alike(const Press& press, const Band<real>& band, int y) const {
        const int reach = K::reach(variant_.stencil), answered = y - reach;
        const int read = press.points ? points_.next(answered, height_) : height_;
        if (press.fill_row || read == answered || y < band.first + 2 * reach) return 1;
        return std::min(band.last - y, read - answered);
    }

    simd::RowSteps<K> row_steps(const Press& press, const Worker<K>& worker, const simd::AdvanceArguments<K>& a,
                                const simd::RespondArguments<K>& r, int y, int rows) const {
        simd::RowSteps<K> s{.advance = a,
                            .respond = r,
                            .rows = rows,
                            .pitch = size_t(pitch_),
                            .response_pitch = press.response_pitch,
                            .tiles = size_t(tiles_),
                            .stepped = y,
                            .behind = K::reach(variant_.stencil)};
        for (size_t i = 0; i < STEP_SIGNALS; ++i)
            for (size_t row = 0; row < 3; ++row) s.signal[i][row] = worker.signals[i][row].data();
        for (size_t row = 0; rolls() && row < 5; ++row) s.strain[row] = worker.strain[row].data();
        return s;
    }

    // Steps a row outside a band.
    void step_outside(const Press& press, typename Band<real>::Outside& o, size_t k, Worker<K>& worker) const {
        const simd::StateRow<real> to = (press.keep ? o.state : worker.peeked[k]).row(0, pitch_);
        loops_.advance(advance_arguments(press, worker, o.row, o.state.row(0, pitch_), to,
                                         [](size_t) -> real* { return nullptr; }),
                       press.constants);
    }

    // Where the strain of row y stands if no state holds it.
    real* rolled(const Worker<K>& worker, int y) const { return worker.strain[size_t(y % 5)].data(); }

    void read_points(const Press& press, const simd::RespondArguments<K>& r, int y) const {
        for (const auto& point : points_.of(y))
            for (size_t q = 0; q < REDUCED_MAPS; ++q) {
                if (!press.tiles[q]) continue;
                const real* row = q == QUANTITY_STRAIN ? r.strain.here : r.response[q - QUANTITY_SA1];
                press.points[q * points_.count() + point.index] = double(row[point.x]);
            }
    }

    // signal(s): where signal s of the step goes, from the first column on.
    template <class Signal>
    simd::AdvanceArguments<K> advance_arguments(const Press& press, Worker<K>& worker, int y,
                                                const simd::StateRow<real>& from, const simd::StateRow<real>& to,
                                                Signal signal) const {
        const int at = first_column();
        const size_t row = size_t(y) * size_t(pitch_) + size_t(at);
        simd::AdvanceArguments<K> a;
        a.count = last_column() - at;
        a.elements = int(variant_.chain.elements());
        a.spring = variant_.chain.spring;
        a.pressure = press.pressure + row;
        a.pressure_to = press.pressure_to ? press.pressure_to + row : nullptr;
        a.material = material_of_.empty() ? nullptr : material_of_.data() + row;
        a.line_material = material_of_.empty() ? nullptr : line_material_.data() + row / PITCH_CELLS;
        a.table = press.table;
        a.from = from;
        a.to = to;
        for (simd::StateRow<real>* state : {&a.from, &a.to}) {
            for (size_t s = 0; s < simd::state_sums; ++s)
                for (real** sum : {&state->value[s], &state->lost[s]})
                    if (*sum) *sum += at;
            state->strain += at;
            for (real** row : {&state->rate, &state->previous})
                if (*row) *row += at;
        }
        for (size_t s = 0; s < STEP_SIGNALS; ++s) a.signal[s] = signal(s);
        if (press.fill_row) {
            (*press.fill_row)(y, worker.coefficients.data());
            a.table = &worker.coefficients[size_t(at) * variant_.chain.length * (1 + variant_.parabolic)];
            a.material = column_.data();
            a.line_material = nullptr;
        }
        return a;
    }

    simd::RespondArguments<K> respond_arguments(const Press& press, const Band<real>& band, const Worker<K>& worker,
                                                int y) {
        const size_t row = size_t(y) * size_t(pitch_), tile = size_t(y) * size_t(tiles_);
        const State<real>& to = stepped(press);
        const auto strain = [&](int i) -> const real* {
            if (!is_pressed(i) && rolls()) return resting_row_.data();
            if (ready(band, i, y)) return rolls() ? rolled(worker, i) : to.strain_row(i, pitch_);
            const size_t k = band.place_of(i);
            return (press.keep ? band.outside[k].state : worker.peeked[k]).strain();
        };
        simd::RespondArguments<K> r; // every member is set below: to clear it first took a tenth of a short row
        r.first = first_column();
        r.last = last_column();
        r.strain = simd::neighbours<real>(y, width_, height_, variant_.stencil, variant_.edges, strain);
        r.signal[0] = rolls() ? rolled(worker, y) : to.strain_row(y, pitch_); // SA1
        r.signal[QUANTITY_SA2 - QUANTITY_SA1] = to.integral_row(y, pitch_);
        r.rest_curvature = press.rest_curvature + row;
        r.streams = streams(press);
        for (size_t s = 0; s < STEP_SIGNALS; ++s)
            r.signal[QUANTITY_FA1 - QUANTITY_SA1 + s] = worker.signals[s][size_t(y % 3)].data();
        for (size_t i = 0; i < RESPONSE_MAPS; ++i)
            r.response[i] = press.response[i] ? press.response[i] + size_t(y) * press.response_pitch : nullptr;
        for (size_t q = 0; q < REDUCED_MAPS; ++q) r.tiles[q] = press.tiles[q] ? press.tiles[q] + tile : nullptr;
        if (press.points && !points_.of(y).empty())
            for (size_t i = 0; i < RESPONSE_MAPS; ++i)
                if (press.tiles[QUANTITY_SA1 + i] && !r.response[i]) r.response[i] = worker.answered[i].data();
        return r;
    }

    const int height_, width_, pitch_, tiles_;
    const std::vector<int>& material_of_;
    const std::vector<int> line_material_;
    const model::Variant variant_;
    const model::PressedBox pressed_;
    const PointsOfRows points_;
    simd::Pool pool_;
    const simd::Isa& isa_;
    const simd::Loops<K>& loops_;
    std::barrier<> barrier_;
    State<real> state_, scratch_;    // scratch_: of steps that are not kept
    State<real>* visible_ = &state_; // the state that the last press wrote
    const Plane<real> resting_row_;
    std::vector<int> column_;                // the index of each cell's first coefficients in a row of them
    std::vector<Band<real>> shares_, bands_; // a band for each thread, of a single press; bands of a batch
    std::vector<Worker<K>> workers_;
};

} // namespace dermis::cpu
