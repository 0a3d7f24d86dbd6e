// SPDX-License-Identifier: MIT
#include "host/core/contact/foundation.hpp"

#include "host/core/contact/bodies.hpp"

namespace dermis::contact {
namespace {

Sums sums_above(const Bed& bed, const Plane& plane) {
    Sums s;
    loops().sums(bed.cells(), plane, &s);
    return s;
}

// The second moments of a pressure about its centre, and the centre; in cells.
struct Spread {
    double x, y, xx, xy, yy;
    explicit Spread(const Sums& s)
        : x(s.ex / s.e), y(s.ey / s.e), xx(s.exx / s.e - x * x), xy(s.exy / s.e - x * y), yy(s.eyy / s.e - y * y) {}
    double least() const { return 0.5 * (xx + yy) - std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy); }
    double greatest() const { return xx + yy - least(); }
};

// Hertz's pressure of a radius of two cells has this second moment, cells^2, and less at no place in a cell.
constexpr double least_moment = 2.0 / 3;

// Passes after which a search ends as it stands. They take about ten.
constexpr int most_passes = 100;

// A light press, or one of an edge, would jump from cell to cell. So the level is raised until the smaller second
// moment is the least one, but at most to where 1/256 of the stiffness carries the force. If the body or the pad is so
// narrow that an even pressure hardly has it, each moment, with a cell's, is only to be 0.6 of the even pressure's.
double wide_enough(const Bed& bed, double level, double asked) {
    constexpr double softest = 1.0 / 256, right_to = 1e-7;
    const auto part_of = [](double even) { return std::min(0.6 * even - 0.4 / 12, least_moment); };
    const Spread even(sums_above(bed, {-0.1 * not_below, 0, 0}));
    const double across = part_of(even.least()), along = part_of(even.greatest());
    const auto missing = [&](double at) {
        const Spread s(sums_above(bed, {at, 0, 0}));
        return std::min(s.least() - across, s.greatest() - along);
    };
    double low = level, high = level_of(bed, asked / softest);
    double at_low = missing(low), at_high = missing(high);
    if (at_high <= 0) return high;
    if (at_low >= 0) return low;
    double before = high;
    // Regula falsi; the value of an end that stays twice counts half (Illinois).
    for (int side = 0, pass = 0; pass < most_passes; ++pass) {
        const double middle = low + (high - low) * at_low / (at_low - at_high);
        if (std::abs(middle - before) <= right_to * middle) return middle;
        before = middle;
        const double found = missing(middle);
        const int now = found < 0 ? -1 : 1;
        double& stays = found < 0 ? at_high : at_low;
        if (now == side) stays *= 0.5;
        if (found < 0) low = middle, at_low = found;
        else high = middle, at_high = found;
        side = now;
    }
    return before;
}

// The level and the tilts for which the pressure has the force's centre, as far as tilts do not change the depths by
// more than 0.6 of their mean (root mean square): else a centre on a border would shrink the patch to a line. They
// minimise a convex function, about the centre of the pressure by the level alone.
class Tilts {
  public:
    Tilts(const Bed& bed, const Sums& alone, double level, const Push& push)
        : bed_(bed), own_(alone), force_(alone.e), mean_(alone.ee / alone.e), off_{push.x - own_.x, push.y - own_.y},
          gxx_(own_.xx + 1.0 / 12), gxy_(own_.xy), gyy_(own_.yy + 1.0 / 12) {
        State now = at({level, 0, 0}, alone);
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
                if (!(std::abs(g) <= 1e-6 * force)) return false;
            return true;
        }
    };

    State at(const std::array<double, 3>& u) const {
        return at(u, sums_above(bed_, {u[0] - u[1] * own_.x - u[2] * own_.y, u[1], u[2]}));
    }
    State at(const std::array<double, 3>& u, const Sums& m) const {
        State s{.u = u, .plane = {u[0] - u[1] * own_.x - u[2] * own_.y, u[1], u[2]}, .sums = m};
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
    // A step of Newton's, halved until cells carry the force and the value falls, or is as good as before but for
    // rounding.
    State better(const State& s) const {
        const auto& g = s.gradient;
        const double l1 = s.nx / s.sums.n, l2 = s.ny / s.sums.n; // the matrix as L*D*transposed L
        const double d1 = s.hxx - l1 * s.nx, m = s.hxy - l1 * s.ny, l21 = m / d1, d2 = s.hyy - l2 * s.ny - l21 * m;
        const double b1 = l1 * g[0] - g[1], b2 = l2 * g[0] - g[2] - l21 * b1;
        const double y = b2 / d2, x = b1 / d1 - l21 * y, level = -g[0] / s.sums.n - l1 * x - l2 * y;
        const double slope = g[0] * level + g[1] * x + g[2] * y, rounding = 1e-6 * force_ * mean_;
        for (double part = 1;; part *= 0.5) {
            const State next = at({s.u[0] + part * level, s.u[1] + part * x, s.u[2] + part * y});
            const bool falls = next.value <= s.value + 1e-4 * part * slope + rounding, last = part < 1e-5;
            if (next.sums.e > 0.1 * force_ && (falls || last)) return next;
            if (last) return s;
        }
    }

    const Bed& bed_;
    const Spread own_;
    const double force_, mean_; // m: the sum of excesses asked, and the mean depth by the level alone
    const double off_[2];       // from its centre to the force's
    const double gxx_, gxy_, gyy_;
    State found_;
};

} // namespace

void Bed::reserve(int columns, int rows) {
    const size_t cells = size_t((columns + 7) / 8 * 8) * size_t(rows);
    deep.reserve(cells);
    for (auto* numbers : {&depth, &share, &pressure}) numbers->reserve(cells);
}

void Bed::resize(int columns, int rows, int first_x, int first_y) {
    width = columns, height = rows, pitch = size_t((columns + 7) / 8 * 8), left = first_x, top = first_y;
    const size_t cells = pitch * size_t(rows);
    deep.assign(cells, not_below);
    for (auto* numbers : {&depth, &share, &pressure}) numbers->resize(cells);
}

bool Bed::settle(bool shares) {
    level = 0;
    deepest = loops().settle(deep.data(), deep.size(), depth.data(), shares ? share.data() : nullptr);
    return deepest > 0.5 * not_below;
}

bool Bed::presses_border() const {
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; x += y == 0 || y == height - 1 ? 1 : std::max(width - 1, 1))
            if (pressure[size_t(y) * pitch + size_t(x)] > 0) return true;
    return false;
}

double level_of(const Bed& bed, double asked) {
    // The deepest cell counts at any level above 0. From there Newton's steps lead to a level at which more cells count
    // than in the end, and fall onto it: the sum is convex in the level, and linear while the same cells count. So
    // each step after the first counts fewer cells. If a step counts more, the rounding of the level to a float has
    // brought a cell back, and the search ends. Every fourth row gives a first level.
    double level = asked;
    for (const int step : {bed.height < 16 ? 1 : 4, 1}) {
        double before = 0, n, e;
        for (int pass = 0; pass < most_passes; ++pass, before = n) {
            const float at = float(level);
            loops().level(bed.cells(), at, step, &n, &e);
            if (n == 0) break;
            level = double(at) + (asked / step - e) / n;
            if (n == before || (pass > 1 && n > before)) break;
        }
    }
    return level;
}

Rest press(Bed& bed, const Push& push) {
    double level = bed.level > 0 ? bed.level : level_of(bed, push.asked);
    Sums sums = sums_above(bed, {level, 0, 0});
    if (Spread(sums).least() < least_moment) {
        level = wide_enough(bed, level, push.asked);
        sums = sums_above(bed, {level, 0, 0});
    }
    Rest rest{.level = level};
    Plane plane{level, 0, 0};
    const Spread own(sums);
    if (push.centred && std::hypot(push.x - own.x, push.y - own.y) > 1e-3) {
        const Tilts tilts(bed, sums, level, push);
        plane = tilts.plane(), sums = tilts.sums(), rest.bound = tilts.bound();
    }
    const Spread got(sums);
    rest.x = got.x, rest.y = got.y, rest.round = got.xx + got.yy;
    rest.scale = push.force / (loops().write(bed.cells(), plane, bed.pressure.data()) * push.area);
    return rest;
}

} // namespace dermis::contact
