// SPDX-License-Identifier: MIT
// What is pressed to a depth: a flat punch, a ball while it sinks, or each cell by itself. The depth gives the strain,
// in every material: the maps made here are strains, to be multiplied by Load::intensity.
#include "host/lab/scenes/waveform.hpp"

#include "host/core/base/quadrature.hpp"
#include "host/lab/scenes/scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace dermis::scene {
namespace {

// The arithmetic-geometric mean of two numbers from 1 to 65536.
long double mean_of(long double a, long double b) {
    for (int i = 0; i < 12; ++i) b = std::sqrt(b * std::exchange(a, (a + b) / 2));
    return a;
}

// An edge between cells: its distance from the middle over the half-axis, and the square of that, square + rest.
struct Edge {
    double at = 0, square = 0, rest = 0;
};

Edge edge_of(double cells, long double axis) {
    const double a = double(axis), x = std::min(cells, 2 * a), r = x / a,
                 off = (std::fma(-r, a, x) - r * double(axis - a)) / a, s = r * r;
    return {r, s, std::fma(r, r, -s) + 2 * r * off};
}

long double difference(const Edge& from, const Edge& to) {
    return (static_cast<long double>(to.square) - from.square) + (to.rest - from.rest);
}

// Returns 1 - u^2 - v^2. It keeps its digits beside the rim, where it is near 0.
long double inside(const Edge& u, const Edge& v) {
    const double most = std::max(u.square, v.square), least = std::min(u.square, v.square), h = 1 - most,
                 left = h - least;
    return static_cast<long double>(left) + ((1 - h - most) + (h - left - least) - (u.rest + v.rest));
}

// A stretch of a line towards its point `root`, where the integrand has a root or a pole.
struct Stretch {
    long double root, low, high;
    long double of_low, of_high; // root^2 - low^2, root^2 - high^2
    long double squares;         // high^2 - low^2
};

// Returns the integral of f(root^2 - x^2) from low to high; root - x is the square of a number that the rule divides.
template <class F> long double towards(const Stretch& s, Rule<long double> rule, F f) {
    const long double begin = std::sqrt(s.of_high / (s.root + s.high)), end = std::sqrt(s.of_low / (s.root + s.low));
    return integral(rule, begin, s.squares / ((s.high + s.low) * (begin + end)),
                    [&](long double t) { return 2 * t * f(t * t * (2 * s.root - t * t)); });
}

// Returns the integral of f(1 - u^2 - v^2) over what the unit circle has of the rectangle from [u0, v0] to [u1, v1].
// The inner one is along v, along which the circle is the steeper one.
template <class F> long double in_circle(const Edge& u0, const Edge& u1, const Edge& v0, const Edge& v1, F f) {
    const long double of_u = difference(u0, u1), of_v = difference(v0, v1);
    if (of_v < of_u) return in_circle(v0, v1, u0, u1, f);
    const long double near = inside(u0, v0), right = inside(u1, v0), above = inside(u0, v1), far = inside(u1, v1);
    const Rule<long double> rule = 1.004L * far > near  ? Rule<long double>(four_points<long double>)
                                   : 1.15L * far > near ? Rule<long double>(eight_points<long double>)
                                                        : Rule<long double>(sixteen_points<long double>);
    const long double top = std::sqrt(std::max(inside({}, v1), 0.0L)),
                      bottom = std::sqrt(inside({}, v0)); // the circle's u
    long double sum = 0;
    if (above > 0) {                            // up to v1
        const auto up = [&](long double left) { // 1 - u^2 - v1^2
            const long double s = std::sqrt(left + v1.square);
            return towards({s, v0.at, v1.at, left + of_v, left, of_v}, rule, f);
        };
        sum +=
            towards(far > 0 ? Stretch{top, u0.at, u1.at, above, far, of_u} : Stretch{top, u0.at, top, above, 0, above},
                    rule, up);
    }
    if (far < 0) {                              // up to the circle
        const auto up = [&](long double left) { // 1 - u^2 - v0^2
            const long double s = std::sqrt(left + v0.square);
            return towards({s, v0.at, s, left, 0, left}, rule, f);
        };
        const long double squares = above > 0 ? (right > 0 ? -far : of_v) : right > 0 ? of_u : near;
        sum += towards({bottom, above > 0 ? top : u0.at, right > 0 ? u1.at : bottom, above > 0 ? of_v : near,
                        std::max(right, 0.0L), squares},
                       rule, up);
    }
    return sum;
}

// Half-axes along x and y, in cells, of an ellipse around the middle of Load::center.
struct Ellipse {
    long double a, b;
};

// Returns `factor` times the integral of f(1 - x^2/a^2 - y^2/b^2) over each cell, in units of the half-axes; 0 in cells
// that the ellipse does not reach. A quarter of them stands for all.
template <class F> std::vector<double> integrals(const Scene& s, Ellipse e, long double factor, F f) {
    const int width = s.grid.width, height = s.grid.height, x0 = s.load.center->x, y0 = s.load.center->y;
    const auto edges = [](int cells, int center, long double axis) { // of the cells on one side
        std::vector<Edge> all(1);
        for (int i = 0; i <= std::max(std::abs(center), std::abs(cells - 1 - center)); ++i)
            all.push_back(edge_of(i + 0.5, axis));
        return all;
    };
    const std::vector<Edge> along = edges(width, x0, e.a), down = edges(height, y0, e.b);
    const size_t columns = along.size() - 1;
    std::vector<double> quarter(columns * (down.size() - 1)), map(size_t(width) * size_t(height));
    for (size_t y = 0; y + 1 < down.size(); ++y)
        for (size_t x = 0; x < columns && inside(along[x], down[y]) > 0; ++x)
            quarter[y * columns + x] = double(factor * (x == 0 ? 2 : 1) * (y == 0 ? 2 : 1) *
                                              in_circle(along[x], along[x + 1], down[y], down[y + 1], f));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            map[size_t(y) * size_t(width) + size_t(x)] =
                quarter[size_t(std::abs(y - y0)) * columns + size_t(std::abs(x - x0))];
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
        const long double nu = *scene_.receptors.poisson, R = *l.ball_radius, contact = std::sqrt(R * depth),
                          a = contact / *scene_.grid.spacing;
        return integrals(scene_, {a, a},
                         2 * contact * a * a / (std::numbers::pi_v<long double> * (1 - nu * nu) * R * l.intensity),
                         [](long double left) { return std::sqrt(left); });
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
    const long double a = *s.load.radius, b = *s.load.radius_y, nu = *s.receptors.poisson;
    return integrals(s, {a, b}, mean_of(a, b) / (std::numbers::pi_v<long double> * (1 - nu * nu) * *s.grid.spacing),
                     [](long double left) { return 1 / std::sqrt(left); });
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
