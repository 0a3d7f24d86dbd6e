// SPDX-License-Identifier: MIT
#include "host/model/separable.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::model {
namespace {

using Point = Moments::Point;

// p, a and b of a cell.
struct Shape {
    const double *pressure, *rest_curvature, *laplacian;
    double length, bend;

    Shape(const double* p, const double* rest, const double* L, const plan::Plan& plan)
        : pressure(p), rest_curvature(rest), laplacian(L), length(plan.constants.curvature_length),
          bend(plan.constants.bend) {}
    Shape(const plan::Plan& plan, const Moments& m)
        : Shape(plan.maps.pressure.data(), plan.maps.rest_curvature.data(), m.laplacian.data(), plan) {}
    double p(size_t i) const { return pressure[i]; }
    double a(size_t i) const { return p(i) * (1 + length * rest_curvature[i]); }
    double b(size_t i) const { return p(i) * (length * (bend * laplacian[i])); }
};

double turn(Point o, Point p, Point q) { return (p.b - o.b) * (q.a - o.a) - (p.a - o.a) * (q.b - o.b); }

// Ascending in b, seen from above (sign 1) or below (-1).
std::vector<Point> hull_of(std::vector<Point> points, double sign) {
    std::sort(points.begin(), points.end(),
              [](const Point& x, const Point& y) { return x.b != y.b ? x.b < y.b : x.a < y.a; });
    std::vector<Point> hull;
    for (const Point& p : points) {
        while (hull.size() > 1 && sign * turn(hull[hull.size() - 2], hull.back(), p) >= 0) hull.pop_back();
        hull.push_back(p);
    }
    return hull;
}

// Of very many points: the outermost of each of some buckets make a hull that already holds most others inside, which
// one comparison per point finds out.
std::vector<Point> hull_of_many(const std::vector<Point>& points, double sign) {
    constexpr int buckets = 256;
    if (points.size() <= 4 * buckets) return hull_of(points, sign);
    double begin = points[0].b, end = points[0].b;
    for (const Point& p : points) {
        begin = std::min(begin, p.b);
        end = std::max(end, p.b);
    }
    const double width = end / buckets - begin / buckets, scale = width > 0 ? 1 / width : 0;
    const auto bucket_of = [&](const Point& p) { return std::min(int((p.b - begin) * scale), buckets - 1); };
    std::vector<const Point*> outer(buckets, nullptr), ends(2, nullptr);
    for (const Point& p : points) {
        const Point*& best = outer[size_t(bucket_of(p))];
        if (!best || sign * p.a > sign * best->a) best = &p;
        if (p.b == begin && (!ends[0] || sign * p.a > sign * ends[0]->a)) ends[0] = &p;
        if (p.b == end && (!ends[1] || sign * p.a > sign * ends[1]->a)) ends[1] = &p;
    }
    std::vector<Point> some = {*ends[0], *ends[1]};
    for (const Point* p : outer)
        if (p) some.push_back(*p);
    const std::vector<Point> rough = hull_of(some, sign);
    std::vector<size_t> segment; // that a bucket begins in: from vertex k - 1 to k
    for (size_t i = 0, k = 1; i < buckets; ++i) {
        while (k + 1 < rough.size() && rough[k].b < begin + double(i) * width) ++k;
        segment.push_back(k);
    }
    std::vector<Point> candidates = rough;
    for (const Point& p : points) {
        size_t k = segment[size_t(bucket_of(p))];
        while (k + 1 < rough.size() && rough[k].b < p.b) ++k;
        if (rough.size() < 2 || sign * turn(rough[k - 1], rough[k], p) > 0) candidates.push_back(p);
    }
    return hull_of(std::move(candidates), sign);
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
        const Shape shape(plan_, *moments_);
        const f64::Constants& c = plan_.constants;
        maps.resize(what.size());
        for (size_t q = 0; q < what.size(); ++q) {
            std::vector<double>& map = maps[q];
            map.resize(plan_.maps.pressure.size());
            const double g = shown_.g, X = scalar(what[q]);
            for (size_t i = 0; i < map.size(); ++i)
                if (what[q] == Quantity::strain) map[i] = shape.p(i) * g;
                else if (what[q] == Quantity::deformation)
                    map[i] = plan_.maps.surface[i] - c.thickness * shape.p(i) * g;
                else if (what[q] == Quantity::curvature)
                    map[i] = plan_.maps.rest_curvature[i] - c.bend * shape.laplacian[i] * g;
                else map[i] = X * (shape.a(i) - g * shape.b(i));
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
        double high = -INFINITY, low = INFINITY;
        for (const Point& p : m.upper) high = std::max(high, p.a - g * p.b);
        for (const Point& p : m.lower) low = std::min(low, p.a - g * p.b);
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

} // namespace

namespace {

void add_places(Moments& m, const plan::Plan& plan) {
    Grid unit = plan.scene.grid;
    unit.spacing.reset();
    for (const Cell& c : plan.places) {
        const double p = plan.maps.pressure[size_t(c.y) * unit.width + c.x],
                     rest = plan::laplacian_at(plan.maps.surface, c, plan.scene.grid, plan.stencil, plan.edges),
                     L = plan::laplacian_at(plan.maps.pressure, c, unit, plan.stencil, plan.edges);
        const Shape shape(&p, &rest, &L, plan);
        m.places.push_back({shape.p(0), shape.a(0), shape.b(0)});
    }
}

} // namespace

std::shared_ptr<const Moments> moments_of(const plan::Plan& plan) {
    const size_t cells = plan.maps.pressure.size(), width = size_t(plan.scene.grid.width);
    auto m = std::make_shared<Moments>();
    add_places(*m, plan);
    if (plan.model == Model::sites) return m; // nothing else is asked for
    Grid unit = plan.scene.grid;
    unit.spacing.reset();
    m->laplacian = plan::laplacian(plan.maps.pressure, unit, plan.stencil, plan.edges);
    const Shape shape(plan, *m);
    std::vector<Point> points;
    points.reserve(cells);
    m->least = m->greatest = shape.p(0);
    bool idle = false; // cells without pressure are one point
    for (size_t row = 0; row < cells; row += width) {
        double p = 0, a = 0, b = 0; // by rows: sums stay short
        for (size_t i = row; i < row + width; ++i) {
            const double pressure = shape.p(i);
            m->least = std::min(m->least, pressure);
            m->greatest = std::max(m->greatest, pressure);
            if (pressure == 0) {
                idle = true;
                continue;
            }
            points.push_back({shape.b(i), shape.a(i)});
            p += pressure;
            a += points.back().a;
            b += points.back().b;
        }
        m->p += p;
        m->a += a;
        m->b += b;
    }
    if (idle) points.push_back({0, 0});
    for (double* mean : {&m->p, &m->a, &m->b}) {
        if (!std::isfinite(*mean))
            throw Error(
                Error::Code::bad_input, "",
                "pressure times curvature overflows; allowed: loads and lengths whose products stay below 1.8e308");
        *mean /= double(cells);
    }
    m->upper = hull_of_many(points, 1);
    m->lower = hull_of_many(points, -1);
    return m;
}

std::unique_ptr<plan::Marcher> separable(const plan::Plan& plan, std::shared_ptr<const Moments> moments,
                                         plan::Marcher::Sink sink) {
    return std::make_unique<Separable>(plan, std::move(moments), std::move(sink));
}

} // namespace dermis::model
