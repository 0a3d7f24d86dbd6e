// SPDX-License-Identifier: MIT
#include "host/core/cpu/spreading.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/model/laplacian.hpp"

#include <climits>
#include <functional>

namespace dermis::cpu {
namespace {

constexpr size_t most_beside = 64 * 64; // cells of a pad that stands beside others: larger ones would leave the cache
constexpr int margin = 16, margin_beside = 8; // zero nodes on each side of a row
constexpr size_t slack = 64;                  // numbers behind the last row that a register may read

int margin_of(int beside) { return beside > 1 ? margin_beside : margin; }

} // namespace

template <class K>
Spreading<K>::NodeMap::NodeMap(const model::SpreadLevel& level, int beside)
    : low(level.y.low), pitch(size_t(level.x.count() + 2 * margin_of(beside)) * size_t(beside)),
      front(size_t(margin_of(beside) * beside)), all(pitch * size_t(level.y.count()) + slack) {}

template <class K>
Spreading<K>::Spreading(const model::PreparedSkin& skin, std::vector<Class> classes, size_t pitch, size_t pads,
                        bool gained, int threads, const simd::Isa& isa)
    : classes_(std::move(classes)), loops_(isa.of<K>()), width_(skin.width()), height_(skin.height()),
      stencil_(skin.stencil), edges_(skin.edges), pitch_(pitch), constants_(model::constants_of<K>(skin, skin.whole())),
      rest_pitch_(size_t(skin.pitch)), pool_(simd::useful_threads(4 * skin.cells() * pads, threads)) {
    if (gained && constants_.curvature_length != 0) rest_ = model::padded_rest_curvature<real>(skin);
    const model::Spread surface{{.x = {0, width_ - 1}, .y = {0, height_ - 1}}}; // a level that passes signals on
    for (Class& c : classes_) {
        if (!c.spread) c.spread = std::make_shared<const model::Spread>(surface);
        std::vector<std::vector<real>>& levels = weights_.emplace_back();
        for (const model::SpreadLevel& l : *c.spread) levels.emplace_back(l.weights.begin(), l.weights.end());
    }
    const bool small = pads >= size_t(loops_.beside) / 2 && pads > 1 && skin.cells() <= most_beside;
    const int beside = small ? loops_.beside : 1;
    for (int i = 0; i < (small ? pool_.threads() : 1); ++i) units_.push_back(unit_of(beside));
    for (int i = 0; i < pool_.threads(); ++i) of_threads_.push_back(rows_of(beside));
    constexpr int together = 16; // rows: fewer would widen too many twice
    if (!small) steps_.push_back(steps_of(0, classes_.size(), pool_.threads() > 1 ? together : INT_MAX));
    for (size_t c = 0; small && c < classes_.size(); ++c) steps_.push_back(steps_of(c, c + 1, INT_MAX));
}

template <class K> typename Spreading<K>::Rows Spreading<K>::rows_of(int beside) const {
    const size_t front = size_t(32 * beside) + slack, room = size_t(width_ + 64) * size_t(beside) + 4 * slack + front;
    Rows rows;
    rows.memory.resize(room * (4 + std::size(rows.fold) + std::size(rows.wide)));
    real* at = rows.memory.data() + front;
    const auto next = [&] { return std::exchange(at, at + room); };
    rows.column = next(), rows.even = next(), rows.odd = next(), rows.zeros = next();
    for (real*& row : rows.fold) row = next();
    for (real*& row : rows.wide) row = next();
    return rows;
}

template <class K> typename Spreading<K>::Unit Spreading<K>::unit_of(int beside) const {
    Unit u;
    u.beside = beside;
    u.pitch = beside > 1 ? size_t(width_ * beside) : pitch_;
    u.from.resize(classes_.size()), u.to.resize(classes_.size());
    for (const Class& c : classes_) {
        std::vector<NodeMap>&down = u.down.emplace_back(), &up = u.up.emplace_back();
        const model::SpreadLevel none{{0, -1}, {0, -1}};
        for (const model::SpreadLevel& level : *c.spread) {
            const bool coarse = &level != &c.spread->front();
            down.emplace_back(coarse || level.radius >= 0 ? level : none, beside);
            up.emplace_back(coarse ? level : none, beside);
        }
    }
    const size_t cells = size_t(width_) * size_t(height_) * size_t(beside);
    if (!rest_.empty()) u.gain.resize(cells + slack);
    if (beside == 1) return u;
    u.in.resize(cells), u.out.resize(cells);
    if (!rest_.empty()) u.in_strain.resize(cells);
    return u;
}

// Makes rows of the level behind the step's.
template <class K> void Spreading<K>::halve(Unit& u, const Step& step, size_t begin, Rows& rows) {
    const auto [pass, of, level, first, last, after] = step;
    const model::SpreadLevel &fine = (*classes_[of].spread)[size_t(level)],
                             &coarse = (*classes_[of].spread)[size_t(level) + 1];
    simd::HalveRow<K> h{.row = {},
                        .low = fine.x.low,
                        .high = fine.x.high,
                        .coarse_low = coarse.x.low,
                        .count = coarse.x.count(),
                        .beside = u.beside,
                        .column = rows.column,
                        .even = rows.even,
                        .odd = rows.odd,
                        .to = nullptr};
    for (int j = coarse.y.low + first; j < coarse.y.low + last; ++j) {
        for (int k = 0; k < 7; ++k) {
            const int y = 2 * j - 3 + k;
            if (y < fine.y.low || y > fine.y.high) h.row[k] = rows.zeros;
            else h.row[k] = level == 0 ? u.from[of] + begin + size_t(y) * u.pitch : u.down[of][size_t(level)].row(y);
        }
        h.to = u.down[of][size_t(level) + 1].row(j);
        loops_.halve_row(h);
    }
}

// Makes rows of a level that comes up; of level 0 they answer.
template <class K> void Spreading<K>::raise(Unit& u, const Step& step, size_t begin, Rows& rows) {
    const auto [pass, of, level, first, last, after] = step;
    const model::Spread& levels = *classes_[of].spread;
    const model::SpreadLevel& own = levels[size_t(level)];
    const bool coarser = size_t(level) + 1 < levels.size();
    const int low = own.x.low, q0 = low >> 1;
    simd::SpreadRow<K> s{.count = own.x.count(),
                         .beside = u.beside,
                         .radius = own.radius,
                         .weight = own.radius >= 0 ? weights_[of][size_t(level)].data() : nullptr,
                         .quantity = level == 0 ? classes_[of].quantity : 0};
    std::ranges::copy(rows.fold, s.fold);
    int widened[4] = {INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN}; // the coarser row in each of rows.wide
    for (int y = own.y.low + first; y < own.y.low + last; ++y) {
        const auto at = [&, of = of, level = level](int row) -> const real* {
            if (level > 0 || own.radius >= 0)
                return row < own.y.low || row > own.y.high ? rows.zeros : u.down[of][size_t(level)].row(row);
            return u.from[of] + begin + size_t(row) * u.pitch;
        };
        s.here = at(y);
        for (int b = 1; b <= own.radius; ++b) s.low[b] = at(y - b), s.high[b] = at(y + b);
        const int q = y >> 1;
        s.odd = y & 1;
        for (int k = 0; coarser && k < 4; ++k) {
            const int row = q - 1 + k, place = row & 3;
            const model::Nodes& there = levels[size_t(level) + 1].y;
            s.wide[k] = rows.zeros;
            if (row < there.low || row > there.high || (k == 3 && !s.odd)) continue;
            const model::Nodes& across = levels[size_t(level) + 1].x;
            if (std::exchange(widened[place], row) != row)
                loops_.widen_row(u.up[of][size_t(level) + 1].row(row) + (q0 - across.low) * u.beside, s.count / 2 + 1,
                                 u.beside, rows.wide[place]);
            s.wide[k] = rows.wide[place] + (low & 1) * u.beside;
        }
        s.gain = level == 0 && !u.gain.empty() ? u.gain.data() + size_t(y) * size_t(width_ * u.beside) : nullptr;
        s.to = level == 0 ? u.to[of] + begin + size_t(y) * u.pitch : u.up[of][size_t(level)].row(y);
        loops_.spread_row(s, constants_);
    }
}

// Makes the gain of each cell from the strain.
template <class K> void Spreading<K>::bend(Unit& u, const Step& step, size_t begin) {
    for (int y = step.first; y < step.last; ++y)
        loops_.gain_row(simd::neighbours<real>(y, width_, height_, stencil_, edges_,
                                               [&](int row) { return u.strain + begin + size_t(row) * u.pitch; }),
                        u.beside, rest_.data() + size_t(y) * rest_pitch_, constants_,
                        u.gain.data() + size_t(y) * size_t(width_ * u.beside));
}

// Copies rows of a map to level 0, which has a stencil.
template <class K> void Spreading<K>::take(Unit& u, const Step& step, size_t begin) {
    for (int y = step.first; y < step.last; ++y)
        std::copy_n(u.from[step.of] + begin + size_t(y) * u.pitch, size_t(width_ * u.beside),
                    u.down[step.of][0].row(y));
}

template <class K> void Spreading<K>::run(Unit& u, const Step& step, size_t begin, Rows& rows) {
    if (step.pass == Step::bend) bend(u, step, begin);
    else if (step.pass == Step::take) take(u, step, begin);
    else if (step.pass == Step::halve) halve(u, step, begin, rows);
    else raise(u, step, begin, rows);
}

// Returns the steps that take classes first .. last - 1 down and up. A step makes `together` rows, or a whole level if
// it has few nodes.
template <class K>
std::vector<typename Spreading<K>::Step> Spreading<K>::steps_of(size_t first, size_t last, int together) const {
    constexpr int few = 4096;
    std::vector<Step> steps;
    size_t after = 0, most = 0;
    const auto add = [&](auto pass, size_t of, size_t level, const model::SpreadLevel& made) {
        const int rows = made.y.count(), some = made.x.count() * rows > few ? together : rows;
        for (int y = 0; y < rows; y += some)
            steps.push_back({pass, of, int(level), y, std::min(y + some, rows), after});
    };
    const auto each = [&](auto add_of) {
        for (size_t c = first; c < last; ++c) add_of(c, *classes_[c].spread);
        after = steps.size();
    };
    if (first == 0 && last > 0 && !rest_.empty()) add(Step::bend, 0, 0, classes_[0].spread->front());
    each([&](size_t c, const model::Spread& levels) {
        most = std::max(most, levels.size());
        if (levels[0].radius >= 0) add(Step::take, c, 0, levels[0]);
    });
    for (size_t l = 1; l < most; ++l)
        each([&](size_t c, auto& levels) {
            if (l < levels.size()) add(Step::halve, c, l - 1, levels[l]);
        });
    for (size_t l = most; l-- > 0;)
        each([&](size_t c, auto& levels) {
            if (l < levels.size()) add(Step::raise, c, l, levels[l]);
        });
    return steps;
}

// Takes up to a register of pads, from the `first` one on.
template <class K>
void Spreading<K>::spread_beside(int thread, const model::PadList& pads, size_t first, const real* const* from,
                                 real* const* to, const real* strain) {
    Unit& u = units_[size_t(thread)];
    const size_t cells = pitch_ * size_t(height_), count = size_t(loops_.beside);
    const real* in[16];
    real* out[16];
    const auto begin = [&](size_t p) { return size_t(pads[std::min(first + p, pads.count - 1)]) * cells; };
    const auto turned = [&](const real* map, std::vector<real>& to_map) {
        for (size_t p = 0; p < count; ++p) in[p] = map + begin(p);
        loops_.to_beside(in, int(cells), to_map.data());
    };
    if (!rest_.empty()) turned(strain, u.in_strain);
    u.strain = u.in_strain.data();
    for (size_t c = 0; c < classes_.size(); ++c) {
        turned(from[c], u.in);
        u.from[c] = u.in.data(), u.to[c] = u.out.data();
        for (const Step& step : steps_[c]) run(u, step, 0, of_threads_[size_t(thread)]);
        for (size_t p = 0; p < count; ++p) out[p] = to[c] + begin(p);
        loops_.from_beside(u.out.data(), int(cells), out);
    }
}

template <class K>
void Spreading<K>::spread(const model::PadList& pads, const real* const* from, real* const* to, const real* strain) {
    const DefaultFloats guard;
    next_ = ended_ = 0;
    const size_t together = size_t(units_[0].beside);
    const auto beside = [&](int thread) {
        for (size_t i; (i = next_.fetch_add(together)) < pads.count;) spread_beside(thread, pads, i, from, to, strain);
    };
    if (together > 1) return pool_.each(std::ref(beside), false);
    const size_t steps = steps_[0].size();
    Unit& u = units_[0];
    std::copy_n(from, classes_.size(), u.from.begin()), std::copy_n(to, classes_.size(), u.to.begin());
    u.strain = strain;
    const auto alone = [&](int thread) { // threads take the steps of one pad after another
        for (size_t i; (i = next_++) < pads.count * steps; ++ended_) {
            const Step& step = steps_[0][i % steps];
            while (ended_ < i - i % steps + step.after) std::this_thread::yield();
            run(u, step, size_t(pads[i / steps]) * pitch_ * size_t(height_), of_threads_[size_t(thread)]);
        }
    };
    pool_.each(std::ref(alone), false);
}

template class Spreading<f32>;
template class Spreading<f64>;

} // namespace dermis::cpu
