// SPDX-License-Identifier: MIT
#include "host/model/separable.hpp"

#include "host/loops/loops.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::model {
namespace {

using Point = Moments::Point;

// p, L(S), a and b of the cells of a row.
struct Shape {
    const double* p = nullptr;
    std::vector<double> rest, L, a, b;

    void take(const plan::Plan& plan, int y, const loops::Columns& sums) {
        const SceneMaps& maps = plan.maps;
        const size_t width = size_t(plan.constants.width);
        for (auto* row : {&rest, &L, &a, &b}) row->resize(width);
        Grid unit = plan.scene.grid;
        unit.spacing.reset();
        plan::laplacian_row(maps.surface, y, plan.scene.grid, plan.stencil, plan.edges, rest.data());
        plan::laplacian_row(maps.pressure, y, unit, plan.stencil, plan.edges, L.data());
        p = maps.pressure.data() + size_t(y) * width;
        loops::best().shape(p, rest.data(), L.data(), int(width), plan.constants.curvature_length, plan.constants.bend,
                            a.data(), b.data(), sums);
    }
};

// Quickhull, over one array that is sorted apart without branches: of the points above a line between two vertices the
// furthest is a vertex, and what is not above the two lines to it is inside.
class Hull {
  public:
    // The side that is seen from above; the points of least and greatest b are known.
    static std::vector<Point> seen(const std::vector<Point>& points, Point from, Point to) {
        Hull h;
        h.above_.resize(points.size() + 1);
        h.aside_.resize(points.size() + 1);
        size_t n = 0;
        for (const Point& p : points) {
            h.above_[n] = p;
            n += above(from, to, p) > 0;
        }
        h.vertices_.push_back(from);
        h.between(from, to, h.above_.data(), n, h.aside_.data());
        if (to.b > from.b) h.vertices_.push_back(to);
        return std::move(h.vertices_);
    }

  private:
    // How far p lies above the line from one point to another.
    static double above(const Point& from, const Point& to, const Point& p) {
        return (p.a - from.a) * (to.b - from.b) - (p.b - from.b) * (to.a - from.a);
    }

    void between(const Point& from, const Point& to, Point* points, size_t n, Point* aside) {
        if (n == 0) return;
        Point top = points[0];
        double furthest = above(from, to, top);
        for (size_t i = 1; i < n; ++i)
            if (const double way = above(from, to, points[i]); way > furthest) furthest = way, top = points[i];
        size_t left = 0, right = 0;
        for (size_t i = 0; i < n; ++i) {
            const Point p = points[i];
            aside[right] = p;
            points[left] = p;
            left += above(from, top, p) > 0;
            right += above(top, to, p) > 0;
        }
        between(from, top, points, left, aside + right);
        vertices_.push_back(top);
        between(top, to, aside, right, points);
    }

    std::vector<Point> vertices_, above_, aside_;
};

// Both sides of some points' hull; the lower one is kept upside down.
struct Sides {
    std::vector<Point> upper, lower;

    // Of at least one point; turns them upside down.
    explicit Sides(std::vector<Point>& points) {
        Point ends[4] = {points[0], points[0], points[0], points[0]}; // first and last, of the upper and the lower side
        for (const Point& p : points) {
            if (p.b <= ends[0].b && (p.b < ends[0].b || p.a > ends[0].a)) ends[0] = p;
            if (p.b >= ends[1].b && (p.b > ends[1].b || p.a > ends[1].a)) ends[1] = p;
            if (p.b <= ends[2].b && (p.b < ends[2].b || p.a < ends[2].a)) ends[2] = p;
            if (p.b >= ends[3].b && (p.b > ends[3].b || p.a < ends[3].a)) ends[3] = p;
        }
        upper = Hull::seen(points, ends[0], ends[1]);
        for (Point& p : points) p.a = -p.a;
        lower = Hull::seen(points, {ends[2].b, -ends[2].a}, {ends[3].b, -ends[3].a});
    }
};

Moments::Hull with_slopes(const std::vector<Point>& points, double sign) {
    Moments::Hull hull{points, {}};
    for (size_t i = 0; i < hull.points.size(); ++i) {
        hull.points[i].a *= sign;
        const Point &p = hull.points[i], &before = hull.points[i ? i - 1 : 0];
        if (i) hull.slopes.push_back((p.a - before.a) / (p.b - before.b));
    }
    return hull;
}

// Greatest (sign 1) or least (-1) of a - g*b.
double extreme(const Moments::Hull& hull, double g, double sign) {
    const auto edge = std::partition_point(hull.slopes.begin(), hull.slopes.end(),
                                           [=](double slope) { return sign * slope > sign * g; });
    const Point& p = hull.points[size_t(edge - hull.slopes.begin())];
    return p.a - g * p.b;
}

class Separable : public plan::Marcher {
  public:
    Separable(const plan::Plan& plan, std::shared_ptr<const Moments> moments, Sink sink)
        : plan_(plan), moments_(std::move(moments)), sink_(std::move(sink)) {}

    void frame(const std::vector<double>&) override {} // none, see plan::why_not

    // One cell under unit pressure, by the rows of any method; without the flush, so that small scalars stay.
    void press(const plan::Step& step) override {
        const f64::Row& k = step.rows->front();
        const double r = step.start - k.E * state_.g;
        shown_.g = state_.g + (k.b * r + k.f * step.rise);
        shown_.G = state_.G + (k.i0 * state_.g + k.i1 * step.start + k.i2 * step.rise - k.leak * state_.G);
        shown_.rate = k.v0 * r + k.v1 * step.rise;
        shown_.acceleration = (k.a0 * r + k.a1 * step.rise + k.a2 * step.jump) * plan_.constants.gain_plus;
        if (step.trace >= 0 || step.impulse >= 0) hand_over(step);
        if (step.keep) state_ = shown_;
    }

    void finish() override {}

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const f64::Constants& c = plan_.constants;
        const double g = shown_.g;
        maps.resize(what.size());
        for (auto& map : maps) map.resize(plan_.maps.pressure.size());
        const size_t width = size_t(c.width);
        Shape row;
        std::vector<double> unused(5 * width);
        const loops::Columns sums{&unused[0], &unused[width], &unused[2 * width], &unused[3 * width],
                                  &unused[4 * width]};
        for (int y = 0; y < c.height; ++y) {
            row.take(plan_, y, sums);
            for (size_t q = 0; q < what.size(); ++q) {
                double* map = maps[q].data() + size_t(y) * width;
                const double* surface = plan_.maps.surface.data() + size_t(y) * width;
                const double X = scalar(what[q]);
                for (size_t x = 0; x < width; ++x)
                    if (what[q] == Quantity::strain) map[x] = row.p[x] * g;
                    else if (what[q] == Quantity::deformation) map[x] = surface[x] - c.thickness * row.p[x] * g;
                    else if (what[q] == Quantity::curvature) map[x] = row.rest[x] - c.bend * row.L[x] * g;
                    else map[x] = X * (row.a[x] - g * row.b[x]);
            }
        }
    }

  private:
    struct Scalars {
        double g = 0, G = 0, rate = 0, acceleration = 0;
    };

    double scalar(Quantity q) const {
        const double scalars[] = {shown_.g, shown_.g, shown_.G, shown_.rate, shown_.acceleration, 0, 0};
        return scalars[int(q)];
    }

    void hand_over(const plan::Step& step) {
        const Moments& m = *moments_;
        const double g = shown_.g;
        if (plan_.model == Model::sites) { // each its own class alone
            const std::vector<Site>& sites = plan_.scene.sites;
            const size_t n = m.places.size(), first = n - sites.size();
            sample_.probes.resize(n * REDUCED_MAPS);
            for (size_t i = 0; i < sites.size(); ++i) {
                const Moments::Place& p = m.places[first + i];
                sample_.probes[size_t(sites[i].type) * n + first + i] = scalar(sites[i].type) * (p.a - g * p.b);
            }
            return sink_(step, sample_);
        }
        const double high = extreme(m.upper, g, 1), low = extreme(m.lower, g, -1);
        const auto ordered = [](double x, double y) { return std::pair{std::min(x, y), std::max(x, y)}; };
        sample_.probes.clear();
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            const double X = scalar(Quantity(q));
            const bool strain = Quantity(q) == Quantity::strain;
            const auto [min, max] = strain ? ordered(X * m.least, X * m.greatest) : ordered(X * low, X * high);
            sample_.totals[q] = {strain ? X * m.p : X * (m.a - g * m.b), min, max};
            for (const Moments::Place& p : m.places) sample_.probes.push_back(strain ? p.p * X : X * (p.a - g * p.b));
        }
        sink_(step, sample_);
    }

    const plan::Plan& plan_;
    std::shared_ptr<const Moments> moments_;
    Sink sink_;
    plan::Sample sample_;
    Scalars state_, shown_;
};

void add_places(Moments& m, const plan::Plan& plan) {
    Grid unit = plan.scene.grid;
    unit.spacing.reset();
    const double length = plan.constants.curvature_length, bend = plan.constants.bend;
    for (const Cell& c : plan.places) {
        const double p = plan.maps.pressure[size_t(c.y) * unit.width + c.x],
                     rest = plan::laplacian_at(plan.maps.surface, c, plan.scene.grid, plan.stencil, plan.edges),
                     L = plan::laplacian_at(plan.maps.pressure, c, unit, plan.stencil, plan.edges);
        m.places.push_back({p, p * (1 + length * rest), p * (length * (bend * L))});
    }
}

// Of some rows: sums by columns, which stay short, and points of the hull.
struct Band {
    Moments sums;
    std::vector<Point> hull; // of its points, or more

    void take(const plan::Plan& plan, int first, int last) {
        const size_t width = size_t(plan.constants.width);
        const auto row_of = [&](const std::vector<double>& map) { return map.begin() + first * std::ptrdiff_t(width); };
        std::vector<double> p(width), a(width), b(width),
            least(row_of(plan.maps.pressure), row_of(plan.maps.pressure) + std::ptrdiff_t(width)), greatest = least;
        const loops::Columns columns{p.data(), a.data(), b.data(), least.data(), greatest.data()};
        std::vector<Point> points;
        Shape row;
        for (int y = first; y < last; ++y) {
            row.take(plan, y, columns);
            const size_t known = points.size();
            points.resize(known + width + 1);
            Point* next = points.data() + known;
            for (size_t x = 0; x < width; ++x) {
                *next = {row.b[x], row.a[x]};
                next += row.p[x] != 0;
            }
            if (size_t(next - points.data()) - known < width) *next++ = {0, 0}; // all without pressure are one point
            points.resize(size_t(next - points.data()));
        }
        for (size_t x = 0; x < width; ++x) {
            sums.p += p[x];
            sums.a += a[x];
            sums.b += b[x];
        }
        sums.least = *std::min_element(least.begin(), least.end());
        sums.greatest = *std::max_element(greatest.begin(), greatest.end());
        if (!std::isfinite(sums.p + sums.a + sums.b)) return; // see moments_of
        const Sides sides(points);
        hull = sides.upper;
        for (const Point& p : sides.lower) hull.push_back({p.b, -p.a});
    }
};

} // namespace

std::shared_ptr<const Moments> moments_of(const plan::Plan& plan) {
    auto m = std::make_shared<Moments>();
    add_places(*m, plan);
    if (plan.model == Model::sites) return m; // nothing else is asked for
    constexpr int band_rows = 64;             // the same on any machine, and so the bits
    const int height = plan.constants.height;
    std::vector<Band> bands(size_t((height + band_rows - 1) / band_rows));
    for (size_t i = 0; i < bands.size(); ++i)
        bands[i].take(plan, int(i) * band_rows, std::min(int(i + 1) * band_rows, height));
    std::vector<Point> points;
    m->least = m->greatest = plan.maps.pressure[0];
    for (Band& band : bands) {
        m->p += band.sums.p;
        m->a += band.sums.a;
        m->b += band.sums.b;
        m->least = std::min(m->least, band.sums.least);
        m->greatest = std::max(m->greatest, band.sums.greatest);
        points.insert(points.end(), band.hull.begin(), band.hull.end());
    }
    for (double* mean : {&m->p, &m->a, &m->b}) {
        if (!std::isfinite(*mean))
            throw Error(
                Error::Code::bad_input, "",
                "pressure times curvature overflows; allowed: loads and lengths whose products stay below 1.8e308");
        *mean /= double(plan.maps.pressure.size());
    }
    const Sides sides(points);
    m->upper = with_slopes(sides.upper, 1);
    m->lower = with_slopes(sides.lower, -1);
    return m;
}

std::unique_ptr<plan::Marcher> separable(const plan::Plan& plan, std::shared_ptr<const Moments> moments,
                                         plan::Marcher::Sink sink) {
    return std::make_unique<Separable>(plan, std::move(moments), std::move(sink));
}

} // namespace dermis::model
