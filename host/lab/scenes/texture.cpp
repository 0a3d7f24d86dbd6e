// SPDX-License-Identifier: MIT
// A texture that slides over the skin: frames made one at a time, whatever the duration.
#include "host/lab/scenes/scene.hpp"

#include <cmath>

namespace dermis::scene {
namespace {

// The coefficients of the cubic spline that runs through the numbers of a line, which repeats itself; in place. It is a
// recursion forwards and one backwards (Unser 1999), each of which starts as if it had run through the line for ever.
void to_spline(std::vector<double>& line) {
    const double z = std::sqrt(3.0) - 2, round = 1 - std::pow(z, double(line.size()));
    const size_t n = line.size();
    const auto start = [&](size_t first, size_t step) { // sum of z^k line[first + k step], over all rounds
        double sum = 0, power = 1;
        for (size_t k = 0; k < n && std::abs(power) > 1e-20; ++k, power *= z)
            sum += power * line[(first + k * step) % n];
        return sum / round;
    };
    double before = start(0, n - 1);
    line[0] = before;
    std::vector<double> forward(n);
    forward[0] = before;
    for (size_t i = 1; i < n; ++i) forward[i] = before = line[i] + z * before;
    line = forward;
    double after = -z * start(n - 1, 1);
    line[n - 1] = 6 * after;
    for (size_t i = n - 1; i-- > 0;) {
        after = z * (after - forward[i]);
        line[i] = 6 * after;
    }
}

// The four spline coefficients around a place, and their weights.
struct Taps {
    long long first;
    double weights[4];
};
Taps taps_at(double place) {
    const double whole = std::floor(place), t = place - whole, u = 1 - t;
    return {static_cast<long long>(whole) - 1,
            {u * u * u / 6, 2.0 / 3 - t * t * (2 - t) / 2, 2.0 / 3 - u * u * (2 - u) / 2, t * t * t / 6}};
}

class Sliding : public Frames {
  public:
    explicit Sliding(const Scene& s)
        : scene_(s), patch_(shape_of(s)), texture_(*s.load.texture), spline_(texture_.map) {
        const size_t width = size_t(texture_.width), height = size_t(texture_.height);
        std::vector<double>& map = spline_.edit();
        std::vector<double> line;
        for (size_t y = 0; y < height; ++y) {
            line.assign(map.begin() + long(y * width), map.begin() + long((y + 1) * width));
            to_spline(line);
            std::copy(line.begin(), line.end(), map.begin() + long(y * width));
        }
        line.resize(height);
        for (size_t x = 0; x < width; ++x) {
            for (size_t y = 0; y < height; ++y) line[y] = map[y * width + x];
            to_spline(line);
            for (size_t y = 0; y < height; ++y) map[y * width + x] = line[y];
        }
    }

    long long maps() const override { return outputs(scene_.time) + 1; }

    void read(long long k, std::vector<double>& values) override {
        const int width = scene_.grid.width, height = scene_.grid.height;
        const std::vector<Taps> along = taps(k, width, 0), down = taps(k, height, 1);
        const long long first = along.front().first;
        std::vector<double> row(size_t(along.back().first + 4 - first));
        values.resize(size_t(width) * size_t(height));
        for (int y = 0; y < height; ++y) {
            const Taps& of_row = down[size_t(y)];
            const double* lines[4];
            for (int j = 0; j < 4; ++j)
                lines[j] = spline_.data() + wrapped(of_row.first + j, texture_.height) * size_t(texture_.width);
            for (size_t i = 0, at = wrapped(first, texture_.width); i < row.size(); ++i) {
                row[i] = 0;
                for (int j = 0; j < 4; ++j) row[i] += of_row.weights[j] * lines[j][at];
                if (++at == size_t(texture_.width)) at = 0;
            }
            for (int x = 0; x < width; ++x) {
                const Taps& of_cell = along[size_t(x)];
                const double* from = row.data() + (of_cell.first - first);
                double sum = 0;
                for (int i = 0; i < 4; ++i) sum += of_cell.weights[i] * from[i];
                const size_t cell = size_t(y) * size_t(width) + size_t(x);
                values[cell] = patch_[cell] * sum;
            }
        }
    }

  private:
    static size_t wrapped(long long i, int n) { return size_t(((i % n) + n) % n); }

    // The taps of all cells of an axis at frame k. The shift is wrapped first, so that a long run loses no digits.
    std::vector<Taps> taps(long long k, int cells, size_t axis) const {
        const double of_grid = scene_.grid.spacing.value_or(1), of_texture = *texture_.spacing,
                     n = axis == 0 ? texture_.width : texture_.height,
                     shift = std::fmod(texture_.velocity[axis] * scene_.time.step * double(k) / of_texture, n);
        std::vector<Taps> all;
        for (int i = 0; i < cells; ++i) all.push_back(taps_at(i * of_grid / of_texture - shift));
        return all;
    }

    const Scene scene_;
    const Map patch_;
    const Texture texture_;
    Map spline_; // the texture's coefficients
};

} // namespace

std::shared_ptr<Frames> texture_frames(const Scene& s) { return std::make_shared<Sliding>(s); }

} // namespace dermis::scene
