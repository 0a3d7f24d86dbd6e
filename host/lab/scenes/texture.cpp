// SPDX-License-Identifier: MIT
// A texture that slides over the skin: frames made one at a time, whatever the duration.
#include "host/lab/scenes/scene.hpp"
#include "host/lab/scenes/spline.hpp"

#include <cmath>

namespace dermis::scene {
namespace {

class Sliding : public Frames {
  public:
    explicit Sliding(const Scene& s)
        : scene_(s), patch_(shape_of(s)), texture_(*s.load.texture), spline_(texture_.map) {
        to_spline(spline_.edit(), texture_.width, texture_.height, Border::periodic);
    }

    long long maps() const override { return outputs(scene_.time) + 1; }

    void read(long long k, std::vector<double>& values) override {
        const int width = scene_.grid.width, height = scene_.grid.height;
        const std::vector<SplineTaps> along = taps(k, width, 0), down = taps(k, height, 1);
        const long long first = along.front().first;
        std::vector<double> row(size_t(along.back().first + 4 - first));
        values.resize(size_t(width) * size_t(height));
        for (int y = 0; y < height; ++y) {
            const SplineTaps& of_row = down[size_t(y)];
            const double* lines[4];
            for (int j = 0; j < 4; ++j)
                lines[j] = spline_.data() +
                           index_beyond(of_row.first + j, texture_.height, Border::periodic) * size_t(texture_.width);
            for (size_t i = 0, at = index_beyond(first, texture_.width, Border::periodic); i < row.size(); ++i) {
                row[i] = 0;
                for (int j = 0; j < 4; ++j) row[i] += of_row.weights[j] * lines[j][at];
                if (++at == size_t(texture_.width)) at = 0;
            }
            for (int x = 0; x < width; ++x) {
                const SplineTaps& of_cell = along[size_t(x)];
                const double* from = row.data() + (of_cell.first - first);
                double sum = 0;
                for (int i = 0; i < 4; ++i) sum += of_cell.weights[i] * from[i];
                const size_t cell = size_t(y) * size_t(width) + size_t(x);
                values[cell] = patch_[cell] * sum;
            }
        }
    }

  private:
    // The taps of all cells of an axis at frame k. The shift is wrapped first, so that a long run loses no digits.
    std::vector<SplineTaps> taps(long long k, int cells, size_t axis) const {
        const double of_grid = scene_.grid.spacing.value_or(1), of_texture = *texture_.spacing,
                     n = axis == 0 ? texture_.width : texture_.height,
                     shift = std::fmod(texture_.velocity[axis] * scene_.time.step * double(k) / of_texture, n);
        std::vector<SplineTaps> all;
        for (int i = 0; i < cells; ++i) all.push_back(spline_taps(i * of_grid / of_texture - shift));
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
