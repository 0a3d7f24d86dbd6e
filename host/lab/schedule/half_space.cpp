// SPDX-License-Identifier: MIT
#include "host/lab/schedule/half_space.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#define kissfft dermis_kissfft // a host may have another version
#include <kissfft/kissfft.hh>

namespace dermis::model {
namespace {

using Complex = std::complex<long double>;

// The least number >= n without prime factors above 5.
size_t smooth(size_t n) {
    for (;; ++n) {
        size_t rest = n;
        for (size_t factor : {2, 3, 5})
            while (rest % factor == 0) rest /= factor;
        if (rest == 1) return n;
    }
}

// At least the root of the sum of squares of all weights; squares may be too small for a double.
double length_of(const HalfSpace& space) {
    return space.squares() > 1e-280 ? std::sqrt(space.squares()) : space.norm();
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
            kissfft<long double> transform(width, inverse);
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
            kissfft<long double> transform(height, inverse);
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
    : depth_(depth), in_cells_{depth.depth / *grid.spacing, depth.kernel, depth.poisson}, width_(grid.width),
      height_(grid.height), weights_(size_t(grid.width) * size_t(grid.height)) {
    const long double h = *grid.spacing;
    const PointForce<long double> below(depth);
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x) {
            const double w = double(of_square(x * h, y * h, h, below)), of = (x == 0 ? 1 : 2) * (y == 0 ? 1 : 2);
            weights_[size_t(y) * size_t(width_) + size_t(x)] = w;
            norm_ += of * std::abs(w);
            squares_ += of * w * w;
            most_ = std::max(most_, std::abs(w));
        }
}

// A weight is off by at most `units` roundings of its terms. Those of a strain cancel, fully at the surface of what
// keeps its volume: one is a stress, of which all cells have 1 in sum and one has 3/(2 pi) of the square of
// spacing/depth.
double HalfSpace::excess(double magnitudes, double sum, int digits) const {
    constexpr double units = 16, of_axis = 1.5 / std::numbers::pi;
    const double z = in_cells_.depth, stress = (1 + depth_.poisson) * std::min(1.0, sum * of_axis / (z * z)),
                 terms = magnitudes + (depth_.kernel == DepthKernel::strain ? 2 * stress : 0);
    return std::max(units * std::ldexp(terms, -digits) - 0.1 * 0x1p-53 * magnitudes, 0.0);
}

std::shared_ptr<const Spread> HalfSpace::spread() const {
    if (!spread_) spread_ = std::make_shared<const Spread>(spread_of(in_cells_, width_, height_));
    return spread_;
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
    // The transform of a map of weights, which is even, is real: two of them make one, as real and imaginary part. Both
    // are made alike in size, because the roundings of each reach the other.
    for (size_t i = 0; i < spaces.size(); i += 2) {
        const HalfSpace &first = *spaces[i], &second = *spaces[std::min(i + 1, spaces.size() - 1)];
        const double ratio = std::log2(length_of(first) / length_of(second));
        const long double alike = std::isfinite(ratio) ? std::exp2(std::round(ratio)) : 1;
        std::fill(both.values().begin(), both.values().end(), Complex());
        for (int y = 1 - int(height); y < int(height); ++y)
            for (int x = 1 - int(width); x < int(width); ++x)
                both(x < 0 ? both.width - size_t(-x) : size_t(x),
                     y < 0 ? both.height - size_t(-y) : size_t(y)) = {first.weight(x, y), alike * second.weight(x, y)};
        both.forward(both.height, pool);
        for (size_t k = 0; k < both.values().size(); ++k) {
            const Complex p = pressure.values()[k], w = both.values()[k];
            both.values()[k] = {p.real() * w.real() - p.imag() * w.imag(), p.real() * w.imag() + p.imag() * w.real()};
        }
        both.backward(height, pool);
        const long double scale = 1 / static_cast<long double>(both.values().size());
        for (size_t y = 0; y < height; ++y)
            for (size_t x = 0; x < width; ++x) {
                stresses[i][y * width + x] = double(both(x, y).real() * scale);
                if (i + 1 < spaces.size()) stresses[i + 1][y * width + x] = double(both(x, y).imag() * scale / alike);
            }
    }
    return stresses;
}

// A transform of n numbers is off by at most 22 log2(n) units of the root of its sum of squares, and each of its
// numbers by as much of the sum of magnitudes that it transforms: 17 are of the twiddle factors' angles (units of half
// a last place). The products of two transforms have magnitudes of at most |map| |weights| n in sum, |.| the root of a
// sum of squares, so that all three transforms are off by parts of |map| |weights|. Of two half-spaces that share a
// transform, |weights| is at most 1.8 times that of either.
double error_of_stresses(const std::vector<double>& map, const Grid& grid, const HalfSpace& space) {
    constexpr double unit = double(std::numeric_limits<long double>::epsilon()) / 2;
    double most = 0, sum = 0, squares = 0;
    for (double p : map) most = std::max(most, std::abs(p));
    for (double p : map) sum += most == 0 ? 0 : std::abs(p) / most, squares += most == 0 ? 0 : (p / most) * (p / most);
    const double both = std::sqrt(squares) * length_of(space),
                 magnitudes = std::min({space.norm(), both, sum * space.most()});      // no stress has more
    const double rounded = 1.1 * 0x1p-53 * magnitudes + space.excess(magnitudes, sum); // of the weights
    if (is_small(grid)) return (1 + 1e-9) * most * (rounded + space.roundings<long double>() * magnitudes);
    const double levels = std::log2(double(smooth(size_t(2 * grid.width - 1)) * smooth(size_t(2 * grid.height - 1))));
    return (1 + 1e-9) * most * (rounded + unit * (3 * 22 * levels + 4) * 1.8 * both);
}

} // namespace dermis::model
