// SPDX-License-Identifier: MIT
// What is pressed to a depth: a flat punch, a ball while it sinks, or each cell by itself. The depth gives the strain,
// in every material: the maps made here are strains, to be multiplied by Load::intensity.
#include "host/lab/scenes/waveform.hpp"

#include "host/lab/scenes/scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace dermis::scene {
namespace {

// The arithmetic-geometric mean of two numbers from 1 to 65536.
double mean_of(double a, double b) {
    for (int i = 0; i < 12; ++i) b = std::sqrt(b * std::exchange(a, (a + b) / 2));
    return a;
}

// The integral of (1 - x^2 - y^2)^(-1/2), or of (1 - x^2 - y^2)^(1/2), over what the rectangle from [0, 0] to [u, v]
// and the unit circle have in common; u and v are in 0..1. Beyond the circle all angles are pi/2.
double flat_to(double u, double v) {
    const double s = std::sqrt(std::max(0.0, 1 - u * u - v * v));
    return u * std::atan2(v, s) + v * std::atan2(u, s) - std::atan2(u * v, s);
}
double round_to(double u, double v) {
    const double s = std::sqrt(std::max(0.0, 1 - u * u - v * v)), across = std::atan2(v, s), down = std::atan2(u, s);
    return (2 * (u * v * s - std::atan2(u * v, s)) + u * (3 - u * u) * across + v * (3 - v * v) * down) / 6;
}

// Half-axes along x and y, in cells, of an ellipse around the middle of Load::center.
struct Ellipse {
    double a, b;
};

// Returns `factor` times the integral over each cell that one of the functions above has, in units of the half-axes; 0
// in cells that the ellipse does not reach.
std::vector<double> integrals(const Scene& s, Ellipse e, double (*to)(double, double), double factor) {
    const int width = s.grid.width, height = s.grid.height;
    const auto ends = [](int cells, int center, double axis) { // of the cells along an axis
        std::vector<double> all;
        for (int i = 0; i <= cells; ++i) all.push_back((i - center - 0.5) / axis);
        return all;
    };
    const auto nearest = [](const std::vector<double>& of, int i) { // distance of a cell from the middle
        const double from = of[size_t(i)], last = of[size_t(i) + 1];
        return from * last < 0 ? 0 : std::min(std::abs(from), std::abs(last));
    };
    const std::vector<double> along = ends(width, s.load.center->x, e.a), down = ends(height, s.load.center->y, e.b);
    std::vector<double> map(size_t(width) * size_t(height)), above(along.size()), below(along.size());
    for (int y = -1; y < height; ++y) {
        above.swap(below);
        const double v = down[size_t(y + 1)];
        for (size_t x = 0; x < along.size(); ++x)
            below[x] = std::copysign(to(std::min(std::abs(along[x]), 1.0), std::min(std::abs(v), 1.0)), along[x] * v);
        for (int x = 0; y >= 0 && x < width; ++x) {
            const size_t i = size_t(x);
            if (std::hypot(nearest(along, x), nearest(down, y)) < 1)
                map[size_t(y) * size_t(width) + i] = factor * ((below[i + 1] - below[i]) - (above[i + 1] - above[i]));
        }
    }
    return map;
}

// A ball of radius R while it sinks (Lee and Radok 1960): the strain e(r, t) = 2 sqrt(R d(t) - r^2)/(pi (1 - nu^2) R),
// in its contact, is that of cells under the ball's pressure. A frame is its mean over each cell at an output.
class Sinking : public Frames {
  public:
    explicit Sinking(const Scene& s) : scene_(s), envelope_(s.load.envelope, s.time) {}

    long long maps() const override { return outputs(scene_.time) + 1; }

    void read(long long k, std::vector<double>& values) override {
        const Instant t = Instant::multiple(double(k), scene_.time.step);
        const double depth = scene_.load.intensity * (k == 0 ? envelope_.after(t) : envelope_.before(t));
        if (depth != depth_) frame_ = frame_at(depth_ = depth);
        values = frame_;
    }

  private:
    std::vector<double> frame_at(double depth) const {
        const Load& l = scene_.load;
        if (!(depth > 0)) return std::vector<double>(size_t(scene_.grid.width) * size_t(scene_.grid.height));
        const double nu = *scene_.receptors.poisson, R = *l.ball_radius, contact = std::sqrt(R * depth),
                     a = contact / *scene_.grid.spacing;
        return integrals(scene_, {a, a}, round_to,
                         2 * contact * a * a / (std::numbers::pi * (1 - nu * nu) * R * l.intensity));
    }

    const Scene scene_;
    const Waveform envelope_;
    double depth_ = NAN; // of frame_
    std::vector<double> frame_;
};

// Frames of depths, as strains.
class Pressed : public Frames {
  public:
    Pressed(const Scene& s, std::shared_ptr<Frames> depths) : scene_(s), depths_(std::move(depths)) {}
    long long maps() const override { return depths_->maps(); }
    void read(long long k, std::vector<double>& values) override {
        depths_->read(k, values);
        to_strain(scene_, values);
    }

  private:
    const Scene scene_;
    const std::shared_ptr<Frames> depths_;
};

} // namespace

// Of an ellipse with the half-axes a and b (Johnson, Contact Mechanics, 3.5): the mean over each cell of
// M (1 - x^2/a^2 - y^2/b^2)^(-1/2)/(pi (1 - nu^2) a b), 1/m per metre of depth, with the arithmetic-geometric mean M of
// a and b. The force is 2 M/(1 - nu^2) per metre and Pa of E(t); in the book it is written with K = pi a/(2 M).
std::vector<double> punch_map(const Scene& s) {
    const double a = *s.load.radius, b = *s.load.radius_y, nu = *s.receptors.poisson;
    return integrals(s, {a, b}, flat_to, mean_of(a, b) / (std::numbers::pi * (1 - nu * nu) * *s.grid.spacing));
}

std::shared_ptr<Frames> ball_frames(const Scene& s) { return std::make_shared<Sinking>(s); }

std::shared_ptr<Frames> pressed_frames(const Scene& s, std::shared_ptr<Frames> depths) {
    return std::make_shared<Pressed>(s, std::move(depths));
}

void to_strain(const Scene& s, std::vector<double>& depths) {
    const bool up = s.load.intensity >= 0; // the sign that presses
    for (double& v : depths) v = (up ? v > 0 : v < 0) ? v / *s.material.thickness : 0;
}

} // namespace dermis::scene
