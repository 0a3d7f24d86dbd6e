// SPDX-License-Identifier: MIT
#include "host/reduced/moments.hpp"

#include "host/reduced/moment_row.hpp"
#include "host/simd/pool.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::reduced {
namespace {

void add_points(Moments& m, const plan::PreparedSkin& skin, const plan::Schedule& schedule) {
    const Grid unit = plan::without_spacing(skin.description.grid);
    const double length = skin.constants.curvature_length, bend = skin.constants.bend;
    for (const Cell& c : schedule.points) {
        const double p = schedule.pressure[size_t(c.y) * size_t(unit.width) + size_t(c.x)],
                     rest = plan::rest_curvature_at(skin, c),
                     L = plan::laplacian_at(schedule.pressure, c, unit, skin.stencil, skin.edges);
        m.points.push_back({p, p * (1 + length * rest), p * (length * (bend * L))});
    }
}

constexpr int block = 256; // columns at a time; their values stay in the first-level cache

// Column sums of a block.
struct BlockSums {
    double p[block] = {}, a[block] = {}, b[block] = {}, least[block], greatest[block];

    BlockSums() {
        std::fill_n(least, block, INFINITY);
        std::fill_n(greatest, block, -INFINITY);
    }
    simd::ColumnSums columns() { return {.p = p, .a = a, .b = b, .least = least, .greatest = greatest}; }
};

// Points (b, a) that may be vertices of the hull.
struct Candidates {
    std::vector<double> a, b;
    size_t count = 0; // number of candidates; memory for more follows them

    // Makes room for the points of one more row.
    void reserve(size_t width) {
        if (a.size() < count + width) a.resize(2 * count + width), b.resize(2 * count + width);
    }

    // Keeps the points that were written after the candidates, except those inside the polygon.
    void keep(size_t width, const std::vector<simd::HalfPlane>& polygon) {
        if (polygon.empty()) {
            count += width;
            return;
        }
        double distance[block];
        double *a_row = a.data() + count, *b_row = b.data() + count;
        if (!simd::best().outside(a_row, b_row, int(width), polygon.data(), distance)) return;
        size_t kept = 0;
        for (size_t x = 0; x < width; ++x) { // branch-free
            a_row[kept] = a_row[x];
            b_row[kept] = b_row[x];
            kept += distance[x] > 0;
        }
        count += kept;
    }
};

// Sums and hull of some rows within the pressed box.
struct Stripe {
    double p = 0, a = 0, b = 0, least = INFINITY, greatest = -INFINITY;
    std::vector<Vertex> hull;
    std::vector<simd::HalfPlane> polygon; // inscribed in this stripe's own hull

    // Adds rows first, first + step .. below last. `others` is a polygon inscribed in the hull of other rows, or empty:
    // points inside it are no vertices of the whole and are left out.
    void add_rows(const plan::PreparedSkin& skin, const plan::Schedule& schedule, int first, int last, int step,
                  const std::vector<simd::HalfPlane>& others) {
        const int from = schedule.pressed.first_column(), to = schedule.pressed.last_column(skin.width());
        Candidates points;
        for (int column = from; column < to; column += block) {
            const int end = std::min(column + block, to);
            const size_t width = size_t(end - column);
            BlockSums sums;
            MomentRow row(skin, schedule, column, end);
            for (int y = first; y < last; y += step) {
                if (!schedule.output.extremes) {
                    row.add_means(y, sums.columns());
                    continue;
                }
                points.reserve(width);
                row.compute(y, points.a.data() + points.count, points.b.data() + points.count, sums.columns());
                points.keep(width, others);
            }
            add_sums(sums, width);
        }
        if (points.count == 0 || !std::isfinite(p + a + b)) return; // moments_of() refuses what is not finite
        const auto [left, right] =
            std::minmax_element(points.b.begin(), points.b.begin() + std::ptrdiff_t(points.count));
        const HullSides sides(points.b.data(), points.a.data(), points.count, *left, *right);
        hull = sides.upper;
        for (const Vertex& v : sides.lower) hull.push_back({v.b, -v.a});
        if (others.empty()) polygon = inscribed_polygon(sides);
    }

    void add_sums(const BlockSums& sums, size_t width) {
        for (size_t x = 0; x < width; ++x) {
            p += sums.p[x];
            a += sums.a[x];
            b += sums.b[x];
            least = std::min(least, sums.least[x]);
            greatest = std::max(greatest, sums.greatest[x]);
        }
    }
};

void add_hull(Moments& m, const std::vector<Vertex>& vertices) {
    std::vector<double> a, b;
    for (const Vertex& v : vertices) {
        a.push_back(v.a);
        b.push_back(v.b);
    }
    const auto [least, greatest] = std::minmax_element(b.begin(), b.end());
    const HullSides sides(b.data(), a.data(), b.size(), *least, *greatest);
    m.upper = with_slopes(sides.upper, 1);
    m.lower = with_slopes(sides.lower, -1);
}

} // namespace

std::shared_ptr<const Moments> moments_of(const plan::PreparedSkin& skin, const plan::Schedule& schedule,
                                          bool points_only, int threads) {
    auto m = std::make_shared<Moments>();
    add_points(*m, skin, schedule);
    if (points_only) return m;
    constexpr int stripe_rows = 16, sampled = 8; // fixed, because the bits depend on them
    const plan::PressedBox& box = schedule.pressed;
    const int rows = box.last_row - box.first_row, count = (rows + stripe_rows - 1) / stripe_rows;
    std::vector<Stripe> stripes(static_cast<size_t>(count));
    Stripe sample; // evenly spaced rows: their hull contains most points of the others
    if (rows > 0 && schedule.output.extremes)
        sample.add_rows(skin, schedule, box.first_row, box.last_row, std::max(rows / sampled, 1), {});
    simd::Pool pool(simd::useful_threads(skin.cells(), threads));
    pool.share(count, [&](int first, int last) {
        for (int i = first; i < last; ++i)
            stripes[size_t(i)].add_rows(skin, schedule, box.first_row + i * stripe_rows,
                                        box.first_row + std::min((i + 1) * stripe_rows, rows), 1, sample.polygon);
    });
    const bool full = rows == skin.height() && box.first_tile == 0 && box.last_tile == skin.tiles;
    std::vector<Vertex> vertices = sample.hull;
    if (!full) vertices.push_back({0, 0}); // cells outside the pressed box
    m->least = full ? stripes[0].least : 0;
    m->greatest = full ? stripes[0].greatest : 0;
    for (const Stripe& stripe : stripes) {
        m->p += stripe.p;
        m->a += stripe.a;
        m->b += stripe.b;
        vertices.insert(vertices.end(), stripe.hull.begin(), stripe.hull.end());
        m->least = std::min(m->least, stripe.least);
        m->greatest = std::max(m->greatest, stripe.greatest);
    }
    for (double* mean : {&m->p, &m->a, &m->b}) {
        if (!std::isfinite(*mean))
            throw Error(
                Error::Code::bad_input, "",
                "pressure times curvature overflows; allowed: loads and lengths whose products stay below 1.8e308");
        *mean /= double(skin.cells());
    }
    if (schedule.output.extremes) add_hull(*m, vertices);
    return m;
}

} // namespace dermis::reduced
