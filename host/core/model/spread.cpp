// SPDX-License-Identifier: MIT
// The fit of a pyramid's weights: least squares over pairs of cells, a pressed one and one below which it acts, each
// pair with its place among the nodes. The pyramid is not the same for all cells, so that a fit to its mean would hide
// errors ten times as large.
#include "host/core/model/spread.hpp"

#include <cstdint>

namespace dermis::model {
namespace {

constexpr int reaching = 3; // nodes of the finer level on each side that a coarser node reaches

// A sequence of numbers from 0 to 1, the same everywhere.
class Numbers {
  public:
    double next() {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        return double(state_ >> 11) * 0x1p-53;
    }
    int below(int n) { return int(next() * n); }

  private:
    uint64_t state_ = 1;
};

// What a cell leaves on the nodes of a level along an axis, from `first` on.
struct Line {
    int first;
    std::vector<double> w;

    Line coarser() const {
        constexpr double mask[] = {1 / 64., 6 / 64., 15 / 64., 20 / 64., 15 / 64., 6 / 64., 1 / 64.};
        const int last = first + int(w.size()) - 1;
        const Nodes to = Nodes{first, last}.coarser();
        Line c{to.low, std::vector<double>(size_t(to.count()))};
        for (int j = to.low; j <= to.high; ++j)
            for (int i = std::max(first, 2 * j - reaching); i <= std::min(last, 2 * j + reaching); ++i)
                c.w[size_t(j - to.low)] += mask[i - 2 * j + reaching] * w[size_t(i - first)];
        return c;
    }
};

// How two cells join by a weight m nodes away, on either side, m = 0 .. radius.
std::array<double, 8> joined(const Line& a, const Line& b, int radius) {
    std::array<double, 8> sums{};
    for (int m = -radius; m <= radius; ++m)
        for (int j = std::max(b.first, a.first - m); j < b.first + int(b.w.size()) && j + m < a.first + int(a.w.size());
             ++j)
            sums[size_t(std::abs(m))] += a.w[size_t(j + m - a.first)] * b.w[size_t(j - b.first)];
    return sums;
}

// A square matrix and a right side, of least squares.
class Normal {
  public:
    explicit Normal(size_t n) : n_(n), matrix_(n * n), side_(n) {}
    void add(const std::vector<double>& row, double value, double weight) {
        for (size_t a = 0; a < n_; ++a) {
            const double v = weight * row[a];
            if (v == 0) continue;
            side_[a] += v * value;
            for (size_t b = 0; b <= a; ++b) at(a, b) += v * row[b];
        }
    }
    // By Cholesky's method, of the matrix scaled to a diagonal of 1.
    std::vector<double> solved() {
        std::vector<double> scale(n_);
        for (size_t a = 0; a < n_; ++a) scale[a] = at(a, a) > 0 ? 1 / std::sqrt(at(a, a)) : 0;
        for (size_t a = 0; a < n_; ++a) {
            side_[a] *= scale[a];
            for (size_t b = 0; b <= a; ++b) at(a, b) *= scale[a] * scale[b];
            at(a, a) += 1e-12;
        }
        for (size_t a = 0; a < n_; ++a)
            for (size_t b = 0; b <= a; ++b) {
                double v = at(a, b);
                for (size_t c = 0; c < b; ++c) v -= at(a, c) * at(b, c);
                at(a, b) = a == b ? std::sqrt(std::max(v, 1e-300)) : v / at(b, b);
            }
        for (size_t a = 0; a < n_; ++a) {
            for (size_t c = 0; c < a; ++c) side_[a] -= at(a, c) * side_[c];
            side_[a] /= at(a, a);
        }
        for (size_t a = n_; a-- > 0;) {
            for (size_t c = a + 1; c < n_; ++c) side_[a] -= at(c, a) * side_[c];
            side_[a] /= at(a, a);
        }
        for (size_t a = 0; a < n_; ++a) side_[a] *= scale[a];
        return side_;
    }

  private:
    double& at(size_t a, size_t b) { return matrix_[a * n_ + b]; }
    size_t n_;
    std::vector<double> matrix_, side_;
};

// Draws offsets between two cells: half of them evenly within the core, the others evenly in rings whose radii grow by
// an eighth, up to the reach.
class Offsets {
  public:
    Offsets(double core, double reach) : radii_{0, core} {
        while (radii_.back() < reach) radii_.push_back(radii_.back() * 1.125);
    }
    struct Offset {
        int x, y;
        double density; // of draws, for each cell
    };
    Offset next(Numbers& numbers) {
        const size_t rings = radii_.size() - 2;
        const bool in_core = numbers.next() < 0.5;
        const size_t ring = in_core ? 0 : 1 + size_t(numbers.below(int(rings)));
        const double low = radii_[ring], high = radii_[ring + 1], square = high * high - low * low,
                     r = std::sqrt(low * low + square * numbers.next());
        double a, b, length;
        do { // a direction
            a = 2 * numbers.next() - 1, b = 2 * numbers.next() - 1, length = a * a + b * b;
        } while (length > 1 || length < 1e-6);
        const double scale = r / std::sqrt(length);
        return {int(std::floor(a * scale + 0.5)), int(std::floor(b * scale + 0.5)),
                0.5 / (in_core ? 1 : double(rings)) / (std::numbers::pi * square)};
    }

  private:
    std::vector<double> radii_;
};

// The index of weight (a, b), b <= a, among the different weights of a stencil.
size_t place_of(int a, int b) { return size_t(a * (a + 1) / 2 + b); }

void fit(Spread& levels, const Depth& depth, double reach) {
    constexpr int samples = 9000;
    std::vector<size_t> first;
    size_t unknowns = 0;
    for (const SpreadLevel& level : levels) {
        first.push_back(unknowns);
        if (level.radius >= 0) unknowns += place_of(level.radius, level.radius) + 1;
    }
    const PointForce<double> below(depth), stress({depth.depth, DepthKernel::stress, 0});
    const int period = 1 << (levels.size() - 1);
    Numbers numbers;
    Offsets offsets(std::min(std::max(1.5 * depth.depth, 4.0), reach / 1.125), reach);
    Normal normal(unknowns);
    std::vector<double> row(unknowns);
    for (int i = 0; i < samples; ++i) {
        const auto [dx, dy, density] = offsets.next(numbers);
        const int x = numbers.below(period), y = numbers.below(period);
        Line ax{x + dx, {1}}, ay{y + dy, {1}}, bx{x, {1}}, by{y, {1}};
        double scale = 1; // nodes of a level stand for so many cells
        for (size_t l = 0; l < levels.size(); ++l, scale *= 4) {
            if (l > 0)
                for (Line* line : {&ax, &ay, &bx, &by}) *line = line->coarser();
            const int radius = levels[l].radius;
            if (radius < 0) continue;
            const auto along = joined(ax, bx, radius), across = joined(ay, by, radius);
            for (int a = 0; a <= radius; ++a)
                for (int b = 0; b <= a; ++b) {
                    const double one = along[size_t(a)] * across[size_t(b)],
                                 both = a == b ? one : one + along[size_t(b)] * across[size_t(a)];
                    row[first[l] + place_of(a, b)] = scale * both;
                }
        }
        const double x0 = dx, y0 = dy;
        normal.add(row, of_square(x0, y0, 1.0, below),
                   1 / density / std::sqrt(std::abs(of_square(x0, y0, 1.0, stress))));
    }
    const std::vector<double> fitted = normal.solved();
    for (size_t l = 0; l < levels.size(); ++l)
        for (int b = 0; b <= levels[l].radius; ++b)
            for (int a = 0; a <= levels[l].radius; ++a)
                levels[l].weights.push_back(fitted[first[l] + place_of(std::max(a, b), std::min(a, b))]);
}

} // namespace

Spread spread_of(const Depth& depth, int width, int height) {
    Spread levels{{.x = {0, width - 1}, .y = {0, height - 1}}};
    const int most = std::max(width, height);
    if (most <= 8) {
        const PointForce<double> below(depth);
        levels[0].radius = most - 1;
        for (int b = 0; b < most; ++b)
            for (int a = 0; a < most; ++a) levels[0].weights.push_back(of_square(double(a), double(b), 1.0, below));
        return levels;
    }
    const bool stress = depth.kernel == DepthKernel::stress;
    int stencils = stress ? 5 : 32; // beyond five levels is less than 1e-4 of the force of a stress
    // The last level joins cells up to so many of its nodes apart. Cells reach nodes on both sides, a stencil only
    // nodes 4 apart; what it leaves out counts most for a displacement, to which far cells matter most.
    const double apart = depth.kernel == DepthKernel::displacement ? 2 : 2.5;
    for (double node = 1;; node *= 2) {
        SpreadLevel& last = levels.back();
        // The first stencil's nodes are so far apart that it covers what acts nearby, but not further than the grid is.
        if (depth.depth < (node == 1 ? 8 : 7) * node || node >= most) {
            last.radius = node == 1 ? 5 : 4;
            if (--stencils == 0 || apart * node >= most - 1) {
                fit(levels, depth, stress ? std::min(std::max(30 * depth.depth, 8 * node), 1.5 * most) : 1.5 * most);
                return levels;
            }
        }
        levels.push_back({.x = last.x.coarser(), .y = last.y.coarser()});
    }
}

} // namespace dermis::model
