// SPDX-License-Identifier: MIT
#include "host/core/contact/foundation.hpp"

#include "host/core/contact/bodies.hpp"

namespace dermis::contact {
namespace {

// A rigid surface over the depths: the excess of a cell is depth + level + along_x*x + along_y*y, m; x and y in cells.
struct Plane {
    double level, along_x = 0, along_y = 0;
};

// Sums over the cells whose excess e is above 0, each by its share: of 1, x, y, x^2, xy, y^2, and of these times e.
struct Sums {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    double e = 0, ex = 0, ey = 0, exx = 0, exy = 0, eyy = 0, ee = 0;
};

double place(int i, int count) { return i + 0.5 - 0.5 * count; }

Sums sums_above(const Bed& bed, const Plane& p) {
    Sums all;
    for (int j = 0; j < bed.height; ++j) {
        const double y = place(j, bed.height), row = p.level + p.along_y * y;
        const size_t first = size_t(j) * size_t(bed.width);
        for (int i = 0; i < bed.width; ++i) {
            const double x = place(i, bed.width), excess = double(bed.depth[first + size_t(i)]) + (row + p.along_x * x);
            if (!(excess > 0)) continue;
            const double w = double(bed.share[first + size_t(i)]), e = w * excess;
            all.n += w, all.x += w * x, all.y += w * y, all.xx += w * x * x, all.xy += w * x * y, all.yy += w * y * y;
            all.e += e, all.ex += e * x, all.ey += e * y, all.exx += e * x * x, all.exy += e * x * y;
            all.eyy += e * y * y, all.ee += e * excess;
        }
    }
    return all;
}

// The level at which the excesses sum to `asked`, m. From a level at which all cells count, Newton's steps fall onto
// it: the sum is convex in the level, and linear while the same cells count.
double level_of(const Bed& bed, double asked) {
    double level = -not_below;
    for (double before = -1;;) {
        const Sums s = sums_above(bed, {level});
        level += (asked - s.e) / s.n;
        if (s.n == before) return level;
        before = s.n;
    }
}

// The second moments of a pressure about its centre, and the centre; in cells.
struct Spread {
    double x, y, xx, xy, yy;
    explicit Spread(const Sums& s)
        : x(s.ex / s.e), y(s.ey / s.e), xx(s.exx / s.e - x * x), xy(s.exy / s.e - x * y), yy(s.eyy / s.e - y * y) {}
    double least() const { return 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy); }
};

// A light press, or one of an edge, would jump from cell to cell. So the level is lowered until the patch is as wide as
// Hertz's of a radius of two cells, whose second moment is 2/3 of a cell^2; but at most to where 1/256 of the stiffness
// carries the force. The moments grow with the level; the root is looked for in its logarithm.
double wide_enough(const Bed& bed, double level, double asked) {
    constexpr double least = 2.0 / 3, softest = 1.0 / 256, right_to = 1e-7;
    const auto missing = [&](double log) { return Spread(sums_above(bed, {std::exp2(log)})).least() - least; };
    double low = std::log2(level), at_low = missing(low);
    if (at_low >= 0) return level;
    double high = std::log2(level_of(bed, asked / softest)), at_high = missing(high);
    if (at_high <= 0) return std::exp2(high);
    for (int side = 0; high - low > right_to;) { // regula falsi; an end that stays twice counts half (Illinois)
        const double middle = low + (high - low) * at_low / (at_low - at_high), found = missing(middle);
        if (found == 0) return std::exp2(middle);
        if (found < 0) {
            if (middle - low < right_to) return std::exp2(middle);
            low = middle, at_low = found;
            if (side == -1) at_high *= 0.5;
            side = -1;
        } else {
            if (high - middle < right_to) return std::exp2(middle);
            high = middle, at_high = found;
            if (side == 1) at_low *= 0.5;
            side = 1;
        }
    }
    return std::exp2(low);
}

// The level and the tilts for which the pressure has the force's centre, as far as tilts do not change the depths by
// more than 0.6 of their mean (root mean square): else a centre on a border would shrink the patch to a line. They
// minimise a convex function, about the centre of the pressure by the level alone.
class Tilts {
  public:
    Tilts(const Bed& bed, const Sums& level_alone, double level, const Push& push)
        : bed_(bed), own_(level_alone), force_(level_alone.e), mean_(level_alone.ee / level_alone.e),
          off_{push.x - own_.x, push.y - own_.y}, gxx_(own_.xx + 1.0 / 12), gxy_(own_.xy), gyy_(own_.yy + 1.0 / 12) {
        State now = at({level, 0, 0});
        for (int step = 0; step < most_steps && !now.balanced(force_); ++step) now = better(now);
        found_ = now;
    }
    Plane plane() const { return found_.plane; }
    const Sums& sums() const { return found_.sums; }
    bool bound() const { return found_.over > 0; }

  private:
    static constexpr int most_steps = 40;
    static constexpr double bound_share = 0.6, hardness = 10;

    // A place of the search: u = (level at the centre, tilts), the value, its gradient and its second derivatives.
    struct State {
        std::array<double, 3> u, gradient;
        double value, over, hxx, hxy, hyy, nx, ny;
        Plane plane;
        Sums sums;
        bool balanced(double force) const {
            for (double g : gradient)
                if (!(std::abs(g) <= 1e-7 * force)) return false;
            return true;
        }
    };

    State at(const std::array<double, 3>& u) const {
        State s{.u = u};
        s.plane = {u[0] - u[1] * own_.x - u[2] * own_.y, u[1], u[2]};
        s.sums = sums_above(bed_, s.plane);
        const Sums& m = s.sums;
        const double tx = gxx_ * u[1] + gxy_ * u[2], ty = gxy_ * u[1] + gyy_ * u[2];
        const double size = std::sqrt(std::max(u[1] * tx + u[2] * ty, 0.0)), firm = hardness * force_ / mean_;
        s.over = std::max(size - bound_share * mean_, 0.0);
        s.value = 0.5 * m.ee - force_ * (u[0] + u[1] * off_[0] + u[2] * off_[1]) + 0.5 * firm * s.over * s.over;
        s.nx = m.x - own_.x * m.n, s.ny = m.y - own_.y * m.n;
        s.gradient = {m.e - force_, m.ex - own_.x * m.e - force_ * off_[0], m.ey - own_.y * m.e - force_ * off_[1]};
        const double small = 1e-9 * force_ / mean_; // keeps the matrix regular where the patch is a line
        s.hxx = m.xx - 2 * own_.x * m.x + own_.x * own_.x * m.n + small * gxx_;
        s.hxy = m.xy - own_.x * m.y - own_.y * m.x + own_.x * own_.y * m.n + small * gxy_;
        s.hyy = m.yy - 2 * own_.y * m.y + own_.y * own_.y * m.n + small * gyy_;
        if (s.over > 0) {
            const double part = s.over / size, rest = (1 - part) / (size * size);
            s.gradient[1] += firm * part * tx, s.gradient[2] += firm * part * ty;
            s.hxx += firm * (part * gxx_ + rest * tx * tx);
            s.hxy += firm * (part * gxy_ + rest * tx * ty);
            s.hyy += firm * (part * gyy_ + rest * ty * ty);
        }
        return s;
    }
    // A step of Newton's, halved until the value falls.
    State better(const State& s) const {
        const auto& g = s.gradient;
        const double l1 = s.nx / s.sums.n, l2 = s.ny / s.sums.n; // the matrix as L*D*transposed L
        const double d1 = s.hxx - l1 * s.nx, m = s.hxy - l1 * s.ny, l21 = m / d1, d2 = s.hyy - l2 * s.ny - l21 * m;
        const double b1 = l1 * g[0] - g[1], b2 = l2 * g[0] - g[2] - l21 * b1;
        const double y = b2 / d2, x = b1 / d1 - l21 * y, level = -g[0] / s.sums.n - l1 * x - l2 * y;
        const double slope = g[0] * level + g[1] * x + g[2] * y;
        for (double part = 1;; part *= 0.5) {
            const State next = at({s.u[0] + part * level, s.u[1] + part * x, s.u[2] + part * y});
            if (next.value <= s.value + 1e-4 * part * slope || part < 1e-5) return next;
        }
    }

    const Bed& bed_;
    const Spread own_;
    const double force_, mean_; // m: the sum of excesses asked, and the mean depth by the level alone
    const double off_[2];       // from its centre to the force's
    const double gxx_, gxy_, gyy_;
    State found_;
};

// Writes the pressures of a plane, scaled to the push's force.
void write(Bed& bed, const Plane& p, const Push& push, Rest& rest) {
    double sum = 0;
    rest.cells = {bed.width, -1, bed.height, -1};
    for (int j = 0; j < bed.height; ++j) {
        const double row = p.level + p.along_y * place(j, bed.height);
        const size_t first = size_t(j) * size_t(bed.width);
        for (int i = 0; i < bed.width; ++i) {
            const double e = double(bed.depth[first + size_t(i)]) + (row + p.along_x * place(i, bed.width));
            const float pressed = e > 0 ? float(double(bed.share[first + size_t(i)]) * e) : 0.0f;
            bed.pressure[first + size_t(i)] = pressed;
            sum += double(pressed);
            if (!(pressed > 0)) continue;
            rest.cells = {std::min(rest.cells[0], i), std::max(rest.cells[1], i), std::min(rest.cells[2], j),
                          std::max(rest.cells[3], j)};
        }
    }
    const double scale = push.force / (sum * push.area);
    for (float& cell : bed.pressure) cell = float(double(cell) * scale);
}

} // namespace

void Bed::reserve(size_t cells) {
    for (auto* depths : {&deep, &outer, &inner}) depths->reserve(cells);
    depth.reserve(cells), share.reserve(cells), pressure.reserve(cells);
}

void Bed::resize(int columns, int rows) {
    width = columns, height = rows;
    const size_t cells = size_t(columns) * size_t(rows);
    for (auto* depths : {&deep, &outer, &inner}) depths->assign(cells, not_below);
    share.assign(cells, 0.0f);
    depth.resize(cells);
    pressure.resize(cells);
}

bool Bed::settle() {
    deepest = not_below;
    for (size_t i = 0; i < deep.size(); ++i)
        if (share[i] > 0) deepest = std::max(deepest, deep[i]);
    for (size_t i = 0; i < deep.size(); ++i) depth[i] = float(share[i] > 0 ? deep[i] - deepest : 2 * not_below);
    return deepest > not_below;
}

Rest press(Bed& bed, const Push& push) {
    const double asked = push.force / (push.stiffness * push.area);
    const double alone = level_of(bed, asked), level = wide_enough(bed, alone, asked);
    Sums sums = sums_above(bed, {level});
    Rest rest{.stiffness = push.force / (push.area * sums.e)};
    Plane plane{level};
    const Spread own(sums);
    if (push.centred && std::hypot(push.x - own.x, push.y - own.y) > 1e-3) {
        const Tilts tilts(bed, sums, level, push);
        plane = tilts.plane(), sums = tilts.sums(), rest.bound = tilts.bound();
    }
    const Spread got(sums);
    rest.x = got.x, rest.y = got.y, rest.round = got.xx + got.yy;
    write(bed, plane, push, rest);
    return rest;
}

} // namespace dermis::contact
