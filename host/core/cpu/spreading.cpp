// SPDX-License-Identifier: MIT
#include "host/core/cpu/spreading.hpp"

#include "host/core/base/float_environment.hpp"
#include "host/core/model/laplacian.hpp"

#include <numeric>

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
    for (const Class& c : classes_) {
        std::vector<std::vector<real>>& levels = weights_.emplace_back();
        for (size_t l = 0; c.spread && l < c.spread->size(); ++l) {
            const std::vector<double>& w = (*c.spread)[l].weights;
            levels.emplace_back(w.begin(), w.end());
        }
    }
    const bool small = pads >= size_t(loops_.beside) / 2 && pads > 1 && skin.cells() <= most_beside;
    const int beside = small ? loops_.beside : 1;
    for (int i = 0; i < (small ? pool_.threads() : 1); ++i) units_.push_back(unit_of(beside));
    for (int i = 0; i < pool_.threads(); ++i) of_threads_.push_back(rows_of(beside));
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
        const size_t levels = c.spread ? c.spread->size() : 0;
        for (size_t l = 0; l < levels; ++l) {
            const model::SpreadLevel& level = (*c.spread)[l];
            down.emplace_back(l > 0 || level.radius >= 0 ? level : model::SpreadLevel{{0, -1}, {0, -1}}, beside);
            up.emplace_back(l > 0 ? level : model::SpreadLevel{{0, -1}, {0, -1}}, beside);
        }
    }
    const size_t cells = size_t(width_) * size_t(height_) * size_t(beside);
    if (!rest_.empty()) u.gain.resize(cells + slack);
    if (beside == 1) return u;
    u.in.resize(cells), u.out.resize(cells);
    if (!rest_.empty()) u.in_strain.resize(cells);
    return u;
}

// Copies rows of a map to level 0, where that has a stencil.
template <class K> void Spreading<K>::take(Unit& u, size_t of, int first, int last) {
    for (int y = first; y < last; ++y)
        std::copy_n(u.from[of] + size_t(y) * u.pitch, size_t(width_ * u.beside), u.down[of][0].row(y));
}

// Makes rows first .. last - 1, counted from 0, of the level behind `level`.
template <class K> void Spreading<K>::halve(Unit& u, size_t of, int level, int first, int last, Rows& rows) {
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
            else h.row[k] = level == 0 ? u.from[of] + size_t(y) * u.pitch : u.down[of][size_t(level)].row(y);
        }
        h.to = u.down[of][size_t(level) + 1].row(j);
        loops_.halve_row(h);
    }
}

// Makes rows first .. last - 1, counted from 0, of a level that comes up; of level 0 they answer.
template <class K> void Spreading<K>::raise(Unit& u, size_t of, int level, int first, int last, Rows& rows) {
    static const model::Spread surface{{}};
    const model::Spread& levels = classes_[of].spread ? *classes_[of].spread : surface;
    const model::SpreadLevel& own = levels[size_t(level)];
    const bool coarser = size_t(level) + 1 < levels.size();
    const int low = level == 0 ? 0 : own.x.low, q0 = low >> 1;
    simd::SpreadRow<K> s{.count = level == 0 ? width_ : own.x.count(),
                         .beside = u.beside,
                         .radius = own.radius,
                         .weight = own.radius >= 0 ? weights_[of][size_t(level)].data() : nullptr,
                         .quantity = level == 0 ? classes_[of].quantity : 0};
    std::ranges::copy(rows.fold, s.fold);
    int widened[4] = {INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN}; // the coarser row in each of rows.wide
    const int from = level == 0 ? 0 : own.y.low;
    for (int y = from + first; y < from + last; ++y) {
        const auto at = [&](int row) -> const real* {
            if (level > 0 || own.radius >= 0)
                return row < own.y.low || row > own.y.high ? rows.zeros : u.down[of][size_t(level)].row(row);
            return u.from[of] + size_t(row) * u.pitch;
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
        s.to = level == 0 ? u.to[of] + size_t(y) * u.pitch : u.up[of][size_t(level)].row(y);
        loops_.spread_row(s, constants_);
    }
}

// Takes classes first .. last - 1 down and up. share(rows, f) calls f(class, first row, last row, Rows) for shares of
// rows(class) rows.
template <class K> template <class Share> void Spreading<K>::pass(Unit& u, size_t first, size_t last, Share share) {
    const auto levels = [this](size_t c) { return classes_[c].spread ? int(classes_[c].spread->size()) : 0; };
    int most = 1;
    for (size_t c = first; c < last; ++c) most = std::max(most, levels(c));
    share([&](size_t c) { return levels(c) > 0 && (*classes_[c].spread)[0].radius >= 0 ? height_ : 0; },
          [&](size_t c, int y, int end, Rows&) { take(u, c, y, end); });
    const auto rows = [&](size_t c, int l) { return l < levels(c) ? (*classes_[c].spread)[size_t(l)].y.count() : 0; };
    for (int l = 0; l + 1 < most; ++l)
        share([&](size_t c) { return rows(c, l + 1); },
              [&](size_t c, int y, int end, Rows& own) { halve(u, c, l, y, end, own); });
    for (int l = most - 1; l >= 0; --l)
        share([&](size_t c) { return l == 0 ? height_ : rows(c, l); },
              [&](size_t c, int y, int end, Rows& own) { raise(u, c, l, y, end, own); });
}

// Makes the gain of each cell from the strain.
template <class K> template <class Share> void Spreading<K>::bend(Unit& u, Share share) {
    if (rest_.empty()) return;
    share([&](size_t c) { return c == 0 ? height_ : 0; },
          [&](size_t, int first, int last, Rows&) {
              for (int y = first; y < last; ++y)
                  loops_.gain_row(simd::neighbours<real>(y, width_, height_, stencil_, edges_,
                                                         [&](int row) { return u.strain + size_t(row) * u.pitch; }),
                                  u.beside, rest_.data() + size_t(y) * rest_pitch_, constants_,
                                  u.gain.data() + size_t(y) * size_t(width_ * u.beside));
          });
}

template <class K>
void Spreading<K>::spread_alone(int pad, const real* const* from, real* const* to, const real* strain) {
    Unit& u = units_[0];
    const size_t begin = size_t(pad) * pitch_ * size_t(height_);
    for (size_t c = 0; c < classes_.size(); ++c) u.from[c] = from[c] + begin, u.to[c] = to[c] + begin;
    u.strain = strain ? strain + begin : nullptr;
    const auto share = [&](auto rows, auto f) {
        constexpr size_t together = 8, few = 8192; // rows; nodes of which one thread is as quick as several
        size_t all = 0;
        for (size_t c = 0; c < classes_.size(); ++c) all += size_t(rows(c));
        const auto some = [&](int thread, size_t first, size_t last) {
            for (size_t c = 0, at = 0; c < classes_.size(); at += size_t(rows(c)), ++c) {
                const size_t low = std::clamp(first, at, at + size_t(rows(c))),
                             high = std::clamp(last, at, at + size_t(rows(c)));
                if (low < high) f(c, int(low - at), int(high - at), of_threads_[size_t(thread)]);
            }
        };
        if (pool_.threads() == 1 || all * size_t(width_) < few) return some(0, 0, all);
        next_ = 0;
        const auto work = [&](int thread) {
            for (size_t i; (i = next_.fetch_add(together)) < all;) some(thread, i, std::min(i + together, all));
        };
        pool_.each(std::ref(work), false);
    };
    bend(u, share);
    pass(u, 0, classes_.size(), share);
}

// Takes up to a register of pads.
template <class K>
void Spreading<K>::spread_beside(int thread, const int* pads, size_t count, const real* const* from, real* const* to,
                                 const real* strain) {
    Unit& u = units_[size_t(thread)];
    const size_t cells = pitch_ * size_t(height_);
    const real* in[16];
    real* out[16];
    const auto turned = [&](const real* map, std::vector<real>& to_map) {
        for (size_t p = 0; p < size_t(loops_.beside); ++p) in[p] = map + size_t(pads[std::min(p, count - 1)]) * cells;
        loops_.to_beside(in, int(cells), to_map.data());
    };
    size_t only = 0;
    const auto share = [&](auto rows, auto f) {
        if (const int all = rows(only)) f(only, 0, all, of_threads_[size_t(thread)]);
    };
    if (!rest_.empty()) {
        turned(strain, u.in_strain);
        u.strain = u.in_strain.data();
        bend(u, share);
    }
    for (only = 0; only < classes_.size(); ++only) {
        turned(from[only], u.in);
        u.from[only] = u.in.data(), u.to[only] = u.out.data();
        pass(u, only, only + 1, share);
        for (size_t p = 0; p < size_t(loops_.beside); ++p)
            out[p] = to[only] + size_t(pads[std::min(p, count - 1)]) * cells;
        loops_.from_beside(u.out.data(), int(cells), out);
    }
}

template <class K>
void Spreading<K>::spread(const model::PadList& pads, const real* const* from, real* const* to, const real* strain) {
    const DefaultFloats guard;
    if (units_[0].beside == 1) {
        for (size_t i = 0; i < pads.count; ++i) spread_alone(pads[i], from, to, strain);
        return;
    }
    next_ = 0;
    const size_t together = size_t(units_[0].beside);
    const auto work = [&](int thread) {
        for (size_t i; (i = next_.fetch_add(together)) < pads.count;) {
            int some[16];
            const size_t n = std::min(together, pads.count - i);
            for (size_t k = 0; k < n; ++k) some[k] = pads[i + k];
            spread_beside(thread, some, n, from, to, strain);
        }
    };
    pool_.each(std::ref(work), false);
}

template class Spreading<f32>;
template class Spreading<f64>;

} // namespace dermis::cpu
