// SPDX-License-Identifier: MIT
#include "host/lab/schedule/half_space.hpp"

#include "host/core/base/arc_tangent.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#define kissfft dermis_kissfft // a host may have another version
#include <kissfft/kissfft.hh>

namespace dermis::plan {
namespace {

using Complex = std::complex<double>;

// The share of an evenly pressed rectangle of which a corner lies above the point, a and b meters along its sides; odd
// in both. In long double, because four of them cancel.
long double corner(long double a, long double b, const Depth& d) {
    const long double z = d.depth, nu = d.poisson, R = std::sqrt(a * a + b * b + z * z);
    const long double A = arc_tangent(a * b / (z * R)), B = a * b * z / R * (1 / (a * a + z * z) + 1 / (b * b + z * z));
    const long double sum = d.kernel == Receptors::Kernel::stress ? A + B : (1 + nu) * ((1 - 2 * nu) * A + B);
    return sum / (2 * std::numbers::pi_v<long double>);
}

// The least number >= n without prime factors above 5.
size_t smooth(size_t n) {
    for (;; ++n) {
        size_t rest = n;
        for (size_t factor : {2, 3, 5})
            while (rest % factor == 0) rest /= factor;
        if (rest == 1) return n;
    }
}

// On so few cells the sums themselves are as quick as transforms, and closer.
bool is_small(const Grid& grid) { return grid.width * grid.height <= 1024; }

// A map of complex numbers that is transformed in place, with room for twice the grid, less one.
class Plane {
  public:
    explicit Plane(const Grid& grid)
        : width(smooth(size_t(2 * grid.width - 1))), height(smooth(size_t(2 * grid.height - 1))),
          values_(simd::map_of(width * height, Complex())) {}

    Complex& operator()(size_t x, size_t y) { return values_[y * width + x]; }
    std::vector<Complex>& values() { return values_; }

    // rows: only the first ones hold, or are read for, anything but 0; the others are left as they are.
    void forward(size_t rows, simd::Pool& pool) { along_x(false, rows, pool), along_y(false, pool); }
    void backward(size_t rows, simd::Pool& pool) { along_y(true, pool), along_x(true, rows, pool); }

    const size_t width, height;

  private:
    void along_x(bool inverse, size_t rows, simd::Pool& pool) {
        pool.share(int(rows), [&](int first, int last) {
            kissfft<double> transform(width, inverse);
            std::vector<Complex> row(width);
            for (size_t y = size_t(first); y < size_t(last); ++y) {
                Complex* here = values_.data() + y * width;
                transform.transform(here, row.data());
                std::copy(row.begin(), row.end(), here);
            }
        });
    }
    void along_y(bool inverse, simd::Pool& pool) {
        constexpr size_t beside = 4; // columns at a time: a cache line
        pool.share(int((width + beside - 1) / beside), [&](int first, int last) {
            kissfft<double> transform(height, inverse);
            std::vector<Complex> columns(beside * height), turned(columns);
            for (size_t x = size_t(first) * beside; x < std::min(size_t(last) * beside, width); x += beside) {
                const size_t count = std::min(beside, width - x);
                for (size_t y = 0; y < height; ++y)
                    for (size_t i = 0; i < count; ++i) columns[i * height + y] = values_[y * width + x + i];
                for (size_t i = 0; i < count; ++i)
                    transform.transform(columns.data() + i * height, turned.data() + i * height);
                for (size_t y = 0; y < height; ++y)
                    for (size_t i = 0; i < count; ++i) values_[y * width + x + i] = turned[i * height + y];
            }
        });
    }

    std::vector<Complex> values_;
};

} // namespace

HalfSpace::HalfSpace(const Grid& grid, const Depth& depth)
    : depth_(depth), width_(grid.width), height_(grid.height), weights_(size_t(grid.width) * size_t(grid.height)) {
    const long double h = *grid.spacing;
    std::vector<long double> below(size_t(width_) + 1), above(below); // corners of a row of cells
    const auto corners = [&](int y, std::vector<long double>& of) {
        for (size_t x = 0; x < of.size(); ++x)
            of[x] = corner((static_cast<long double>(x) - 0.5L) * h, (static_cast<long double>(y) - 0.5L) * h, depth_);
    };
    corners(0, above);
    for (int y = 0; y < height_; ++y) {
        below.swap(above);
        corners(y + 1, above);
        for (size_t x = 0; x < size_t(width_); ++x)
            weights_[size_t(y) * size_t(width_) + x] = double((above[x + 1] - above[x]) - (below[x + 1] - below[x]));
    }
    for (int y = 1 - height_; y < height_; ++y)
        for (int x = 1 - width_; x < width_; ++x) norm_ += std::abs(weight(x, y));
}

template <class T> T HalfSpace::at(const std::vector<double>& map, Cell c) const {
    T sum = 0;
    for (int y = 0; y < height_; ++y) {
        const double* row = map.data() + size_t(y) * size_t(width_);
        const double* of_row = weights_.data() + size_t(std::abs(y - c.y)) * size_t(width_);
        T parts[4] = {}; // so that the loop need not wait for each sum
        const auto along = [&](int first, int last, int step, const double* weight) {
            for (int x = first; x != last; x += step, ++weight) parts[x & 3] += T(*weight) * row[x];
        };
        along(c.x, width_, 1, of_row);
        along(c.x - 1, -1, -1, of_row + 1);
        sum += (parts[0] + parts[1]) + (parts[2] + parts[3]);
    }
    return sum;
}

double HalfSpace::magnitudes_at(const std::vector<double>& map, Cell c) const {
    double sum = 0;
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x)
            sum += std::abs(weight(x - c.x, y - c.y) * map[size_t(y) * size_t(width_) + size_t(x)]);
    return (1 + 1e-9) * sum;
}

template double HalfSpace::at(const std::vector<double>&, Cell) const;
template long double HalfSpace::at(const std::vector<double>&, Cell) const;

std::vector<std::vector<double>> stresses_of(const std::vector<double>& map, const Grid& grid,
                                             const std::vector<const HalfSpace*>& spaces, simd::Pool& pool) {
    const size_t width = size_t(grid.width), height = size_t(grid.height);
    std::vector<std::vector<double>> stresses(spaces.size(), std::vector<double>(map.size()));
    if (is_small(grid)) {
        for (size_t i = 0; i < spaces.size() * map.size(); ++i)
            stresses[i / map.size()][i % map.size()] = double(spaces[i / map.size()]->at<long double>(
                map, {int(i % map.size() % width), int(i % map.size() / width)}));
        return stresses;
    }
    Plane pressure(grid), both(grid);
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) pressure(x, y) = map[y * width + x];
    pressure.forward(height, pool);
    // The transform of a map of weights, which is even, is real: two of them make one, as real and imaginary part.
    for (size_t i = 0; i < spaces.size(); i += 2) {
        const HalfSpace &first = *spaces[i], &second = *spaces[std::min(i + 1, spaces.size() - 1)];
        std::fill(both.values().begin(), both.values().end(), Complex());
        for (int y = 1 - int(height); y < int(height); ++y)
            for (int x = 1 - int(width); x < int(width); ++x)
                both(x < 0 ? both.width - size_t(-x) : size_t(x),
                     y < 0 ? both.height - size_t(-y) : size_t(y)) = {first.weight(x, y), second.weight(x, y)};
        both.forward(both.height, pool);
        for (size_t k = 0; k < both.values().size(); ++k) {
            const Complex p = pressure.values()[k], w = both.values()[k];
            both.values()[k] = {p.real() * w.real() - p.imag() * w.imag(), p.real() * w.imag() + p.imag() * w.real()};
        }
        both.backward(height, pool);
        const double scale = 1 / double(both.values().size());
        for (size_t y = 0; y < height; ++y)
            for (size_t x = 0; x < width; ++x) {
                stresses[i][y * width + x] = both(x, y).real() * scale;
                if (i + 1 < spaces.size()) stresses[i + 1][y * width + x] = both(x, y).imag() * scale;
            }
    }
    return stresses;
}

// Two half-spaces of one kernel share a transform, so that each is off by what the larger one allows: 1.5 times the
// integral of |kernel| over the plane, or a bound of it. A transform of n numbers is off by a few log2(n) units of the
// root of its sum of squares; the twiddle factors of a line are off by a few units.
double error_of_stresses(const std::vector<double>& map, const Grid& grid, const HalfSpace& space) {
    constexpr double units = 32; // for each level of two transforms forward and one backward
    double squares = 0, most = 0;
    for (double p : map) most = std::max(most, std::abs(p));
    if (is_small(grid)) {
        double magnitudes = 0;
        for (int y = 0; y < grid.height; ++y)
            for (int x = 0; x < grid.width; ++x) magnitudes = std::max(magnitudes, space.magnitudes_at(map, {x, y}));
        return (0x1p-53 + space.roundings<long double>()) * magnitudes; // 0x1p-53: of weights
    }
    for (double p : map) squares += most == 0 ? 0 : (p / most) * (p / most);
    const auto& [depth, kernel, nu] = space.depth();
    const double both = 1.5 * (kernel == Receptors::Kernel::stress ? 1 : (1 + nu) * (3 - 2 * nu));
    const double levels = std::log2(4.0 * double(grid.width)) + std::log2(double(grid.height));
    return units * levels * 0x1p-53 * both * std::sqrt(squares) * most;
}

} // namespace dermis::plan
