// SPDX-License-Identifier: MIT
#include "host/reduced/moments.hpp"

#include "host/simd/isa.hpp"
#include "host/simd/pool.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::reduced {
namespace {

using Point = Moments::Point;

// L(S), L(p), a and b of columns first .. last - 1 of a row.
struct Shape {
    int first, last;
    std::vector<double> rest, L;

    Shape(int from, int to) : first(from), last(to), rest(size_t(to - from)), L(rest) {}

    // a and b null: their sums alone.
    void take(const plan::Plan& plan, int y, double* a, double* b, const simd::Columns& sums) {
        Grid unit = plan.scene.grid;
        unit.spacing.reset();
        plan::laplacian_row(plan.maps.surface, y, first, last, plan.scene.grid, plan.stencil, plan.edges, rest.data());
        plan::laplacian_row(plan.maps.pressure, y, first, last, unit, plan.stencil, plan.edges, L.data());
        const double* p = plan.maps.pressure.data() + size_t(y) * size_t(unit.width) + first;
        if (!a) {
            simd::best().means(p, rest.data(), L.data(), last - first, plan.constants.curvature_length,
                                plan.constants.bend, sums);
            return;
        }
        simd::best().shape(p, rest.data(), L.data(), last - first, plan.constants.curvature_length,
                            plan.constants.bend, a, b, sums);
    }
};

// Both sides of the hull of points (b[i], a[i]), which lie between `least` and `greatest` in b; (0, 0) is one point
// however often it comes. Quickhull, sorting apart without branches: of the points above a line between two vertices
// the furthest is a vertex, and what is not above the two lines to it is inside.
class Sides {
  public:
    std::vector<Point> upper, lower; // the lower one upside down

    Sides(const double* b, const double* a, size_t n, double least, double greatest)
        : above_(new Point[n + 2]), below_(new Point[n + 2]), aside_(new Point[n + 2]) {
        Point from{least, -INFINITY}, to{greatest, -INFINITY}, from_low = from, to_low = to;
        from_low.a = to_low.a = INFINITY;
        for (size_t i = 0; i < n; ++i) {
            if (b[i] == least) from.a = std::max(from.a, a[i]), from_low.a = std::min(from_low.a, a[i]);
            if (b[i] == greatest) to.a = std::max(to.a, a[i]), to_low.a = std::min(to_low.a, a[i]);
        }
        size_t high = 0, low = 0;
        bool none = false;
        for (size_t i = 0; i < n; ++i) {
            const Point p{b[i], a[i]};
            const bool empty = (p.a == 0) & (p.b == 0);
            above_[high] = p;
            high += (above(from, to, p) > 0) & !empty;
            below_[low] = {p.b, -p.a};
            low += (above(from_low, to_low, p) < 0) & !empty;
            none |= empty;
        }
        if (none && above(from, to, {0, 0}) > 0) above_[high++] = {0, 0};
        if (none && above(from_low, to_low, {0, 0}) < 0) below_[low++] = {0, 0};
        side(upper, from, to, above_.get(), high);
        side(lower, {from_low.b, -from_low.a}, {to_low.b, -to_low.a}, below_.get(), low);
    }

  private:
    // How far p lies above the line from one point to another.
    static double above(const Point& from, const Point& to, const Point& p) {
        return (p.a - from.a) * (to.b - from.b) - (p.b - from.b) * (to.a - from.a);
    }

    void side(std::vector<Point>& vertices, Point from, Point to, Point* points, size_t n) {
        vertices.push_back(from);
        between(vertices, from, to, points, n, aside_.get());
        if (to.b > from.b) vertices.push_back(to);
    }

    void between(std::vector<Point>& vertices, Point from, Point to, Point* points, size_t n, Point* aside) {
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
        between(vertices, from, top, points, left, aside + right);
        vertices.push_back(top);
        between(vertices, top, to, aside, right, points);
    }

    std::unique_ptr<Point[]> above_, below_, aside_;
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

class Separable : public plan::Stepper {
  public:
    Separable(const plan::Plan& plan, std::shared_ptr<const Moments> moments, Sink sink)
        : plan_(plan), moments_(std::move(moments)), sink_(std::move(sink)) {}

    void frame(const std::vector<double>&) override {} // none, see plan::why_not

    // One cell under unit pressure, by the rows of any method; without the flush, so that small scalars stay.
    void press(const plan::Step& step) override {
        const f64::Coefficients& k = step.rows->front();
        const double r = step.start - k.E * state_.g;
        shown_.g = state_.g + (k.b * r + k.f * step.rise);
        shown_.G = state_.G + (k.i0 * state_.g + k.i1 * step.start + k.i2 * step.rise - k.leak * state_.G);
        shown_.rate = k.v0 * r + k.v1 * step.rise;
        shown_.acceleration = (k.a0 * r + k.a1 * step.rise + k.a2 * step.jump) * plan_.constants.gain_plus;
        if (step.trace >= 0 || step.impulse >= 0) hand_over(step);
        if (step.keep) state_ = shown_;
    }

    void finish() override {}

    plan::StencilEstimate estimate(const plan::Plan& plan) override {
        return plan::stencil_estimate(plan, plan.maps.pressure, shown_.g);
    }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const f64::Constants& c = plan_.constants;
        const double g = shown_.g;
        maps.resize(what.size());
        for (auto& map : maps) map.resize(plan_.maps.pressure.size());
        const size_t width = size_t(c.width);
        Shape row(0, c.width);
        std::vector<double> a(width), b(width), unused(5 * width);
        double* u = unused.data();
        const simd::Columns sums{u, u + width, u + 2 * width, u + 3 * width, u + 4 * width};
        for (int y = 0; y < c.height; ++y) {
            row.take(plan_, y, a.data(), b.data(), sums);
            for (size_t q = 0; q < what.size(); ++q) {
                const size_t at = size_t(y) * width;
                double* map = maps[q].data() + at;
                const double *surface = plan_.maps.surface.data() + at, *p = plan_.maps.pressure.data() + at;
                const double X = scalar(what[q]);
                for (size_t x = 0; x < width; ++x)
                    if (what[q] == Quantity::strain) map[x] = p[x] * g;
                    else if (what[q] == Quantity::deformation) map[x] = surface[x] - c.thickness * p[x] * g;
                    else if (what[q] == Quantity::curvature) map[x] = row.rest[x] - c.bend * row.L[x] * g;
                    else map[x] = X * (a[x] - g * b[x]);
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
        const bool extremes = plan_.scene.output.extremes;
        const double high = extremes ? extreme(m.upper, g, 1) : NAN, low = extremes ? extreme(m.lower, g, -1) : NAN;
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

// Edges of a polygon inside the hull, clockwise, so that what is beside none of them is no vertex. None: no such
// polygon.
std::vector<simd::Edge> fence_of(const Sides& sides) {
    std::vector<Point> polygon = sides.upper, fence;
    for (size_t i = sides.lower.size(); i-- > 0;) {
        const Point p{sides.lower[i].b, -sides.lower[i].a};
        if (p.b != polygon.back().b || p.a != polygon.back().a) polygon.push_back(p);
    }
    const size_t n = std::min(size_t(simd::fence_edges), polygon.size());
    for (size_t i = 0; i < n; ++i) fence.push_back(polygon[i * polygon.size() / n]);
    std::vector<simd::Edge> edges;
    for (size_t i = 0; n > 2 && i < simd::fence_edges; ++i) { // the last one as often as it takes
        const Point &p = fence[std::min(i, n - 1)], &next = fence[(std::min(i, n - 1) + 1) % n];
        edges.push_back({p.b, p.a, next.b - p.b, next.a - p.a});
    }
    return edges;
}

// Of some rows within what is pressed: sums by columns, which stay short, and vertices of the hull.
struct Band {
    double p = 0, a = 0, b = 0, least = 0, greatest = 0;
    std::vector<Point> hull;
    std::vector<simd::Edge> fence; // of this band's own

    // Of rows first, first + step .. before last. With a fence of other rows only points outside it are looked at.
    void take(const plan::Plan& plan, int first, int last, int step, const std::vector<simd::Edge>& others) {
        const int from = plan.pressed.first_tile * TILE_CELLS,
                  to = std::min(plan.pressed.last_tile * TILE_CELLS, plan.constants.width);
        constexpr int block = 256; // columns at a time, all of which stay in the first cache
        std::vector<double> all_a, all_b;
        size_t points = 0; // the first ones of all_a and all_b are looked at
        least = INFINITY;
        greatest = -INFINITY;
        for (int column = from; column < to; column += block) {
            const int end = std::min(column + block, to);
            const size_t width = size_t(end - column);
            double sums[3][block] = {}, low[block], high[block], way[block];
            std::fill_n(low, block, INFINITY);
            std::fill_n(high, block, -INFINITY);
            const simd::Columns columns{sums[0], sums[1], sums[2], low, high};
            Shape row(column, end);
            for (int y = first; y < last; y += step) {
                if (!plan.scene.output.extremes) {
                    row.take(plan, y, nullptr, nullptr, columns);
                    continue;
                }
                if (all_a.size() < points + width) all_a.resize(2 * points + width), all_b.resize(2 * points + width);
                double *a_row = all_a.data() + points, *b_row = all_b.data() + points;
                row.take(plan, y, a_row, b_row, columns);
                if (others.empty()) {
                    points += width;
                    continue;
                }
                if (!simd::best().beside(a_row, b_row, int(width), others.data(), way)) continue;
                size_t kept = 0;
                for (size_t x = 0; x < width; ++x) { // without branches
                    a_row[kept] = a_row[x];
                    b_row[kept] = b_row[x];
                    kept += way[x] > 0;
                }
                points += kept;
            }
            for (size_t x = 0; x < width; ++x) {
                p += sums[0][x];
                a += sums[1][x];
                b += sums[2][x];
                least = std::min(least, low[x]);
                greatest = std::max(greatest, high[x]);
            }
        }
        if (points == 0 || !std::isfinite(p + a + b)) return; // see moments_of
        const auto [left, right] = std::minmax_element(all_b.begin(), all_b.begin() + std::ptrdiff_t(points));
        const Sides sides(all_b.data(), all_a.data(), points, *left, *right);
        hull = sides.upper;
        for (const Point& v : sides.lower) hull.push_back({v.b, -v.a});
        if (others.empty()) fence = fence_of(sides);
    }
};

} // namespace

std::shared_ptr<const Moments> moments_of(const plan::Plan& plan, int threads) {
    auto m = std::make_shared<Moments>();
    add_places(*m, plan);
    if (plan.model == Model::sites) return m;  // nothing else is asked for
    constexpr int band_rows = 16, sampled = 8; // the same on any machine, and so the bits
    const plan::Pressed& box = plan.pressed;
    const int rows = box.last_row - box.first_row, count = (rows + band_rows - 1) / band_rows;
    std::vector<Band> bands(static_cast<size_t>(count));
    Band sample; // some rows from all over: the hull of these already holds most others
    if (rows > 0 && plan.scene.output.extremes)
        sample.take(plan, box.first_row, box.last_row, std::max(rows / sampled, 1), {});
    simd::Pool pool(simd::useful_threads(plan.maps.pressure.size(), threads));
    pool.rows(count, [&](int first, int last) {
        for (int i = first; i < last; ++i)
            bands[size_t(i)].take(plan, box.first_row + i * band_rows,
                                  box.first_row + std::min((i + 1) * band_rows, rows), 1, sample.fence);
    });
    const bool full = rows == plan.constants.height && box.first_tile == 0 && box.last_tile == plan.tiles;
    std::vector<Point> vertices = sample.hull;
    if (!full) vertices.push_back({0, 0}); // cells outside
    m->least = full ? bands[0].least : 0;
    m->greatest = full ? bands[0].greatest : 0;
    for (const Band& band : bands) {
        m->p += band.p;
        m->a += band.a;
        m->b += band.b;
        vertices.insert(vertices.end(), band.hull.begin(), band.hull.end());
        m->least = std::min(m->least, band.least);
        m->greatest = std::max(m->greatest, band.greatest);
    }
    for (double* mean : {&m->p, &m->a, &m->b}) {
        if (!std::isfinite(*mean))
            throw Error(
                Error::Code::bad_input, "",
                "pressure times curvature overflows; allowed: loads and lengths whose products stay below 1.8e308");
        *mean /= double(plan.maps.pressure.size());
    }
    if (!plan.scene.output.extremes) return m;
    std::vector<double> a, b;
    for (const Point& v : vertices) {
        a.push_back(v.a);
        b.push_back(v.b);
    }
    const auto [least, greatest] = std::minmax_element(b.begin(), b.end());
    const Sides sides(b.data(), a.data(), b.size(), *least, *greatest);
    m->upper = with_slopes(sides.upper, 1);
    m->lower = with_slopes(sides.lower, -1);
    return m;
}

std::unique_ptr<plan::Stepper> separable(const plan::Plan& plan, std::shared_ptr<const Moments> moments,
                                         plan::Stepper::Sink sink) {
    return std::make_unique<Separable>(plan, std::move(moments), std::move(sink));
}

} // namespace dermis::reduced
