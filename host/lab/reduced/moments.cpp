// SPDX-License-Identifier: MIT
#include "host/lab/reduced/moments.hpp"

#include "host/core/base/pool.hpp"
#include "host/core/model/laplacian.hpp"
#include "host/core/simd/isa.hpp"
#include "host/lab/schedule/schedule.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::reduced {
namespace {

std::vector<Map> pressures_of_parts(const model::PreparedSkin& skin, const model::Schedule& schedule) {
    if (skin.uniform()) return {schedule.pressure};
    std::vector<Map> parts(skin.materials.size(), std::vector<double>(skin.cells()));
    std::vector<double*> cells;
    for (Map& part : parts) cells.push_back(part.edit().data());
    for (size_t i = 0; i < skin.cells(); ++i) cells[skin.material_at(i)][i] = schedule.pressure[i];
    return parts;
}

// product: that the layer is of.
void add_points(Moments::Layer& layer, const std::vector<Map>& parts, const model::PreparedSkin& skin,
                const model::Schedule& schedule, size_t product) {
    const Grid unit = model::without_spacing(skin.description.grid);
    const double length = skin.constants.curvature_length, bend = skin.constants.bend;
    for (const Cell& c : schedule.points) {
        const size_t cell = skin.number_of(c);
        const double p = layer.map[cell], rest = model::rest_curvature_at(skin, c);
        layer.points.push_back(
            {.part = skin.material_at(cell) + product, .p = p, .a = p * (1 + length * rest), .b = {}});
        for (const Map& part : parts) {
            const double L = model::laplacian_at(part, c, unit, skin.stencil, skin.edges);
            layer.points.back().b.push_back(p * (length * (bend * L)));
        }
    }
}

bool is_finite(const Moments::Means& m) {
    return std::isfinite(m.p) && std::isfinite(m.a) &&
           std::ranges::all_of(m.b, [](double b) { return std::isfinite(b); });
}

// The values a = p*(1 + l*L(S)) and b = p*l*h*L(p) of the cells in columns first .. last - 1 of one row after another.
class MomentRow {
  public:
    // map: Moments::Layer::map.
    MomentRow(const model::PreparedSkin& skin, const model::Schedule& schedule, const Map& map, int first, int last)
        : skin_(skin), schedule_(schedule), map_(map), unit_(model::without_spacing(skin.description.grid)),
          first_(first), last_(last), rest_(size_t(last - first)), L_(rest_) {}

    void compute(int y, double* a, double* b, const simd::ColumnSums& sums) {
        laplacians(y);
        simd::best().moments(at(y), rest_.data(), L_.data(), last_ - first_, skin_.constants.curvature_length,
                             skin_.constants.bend, a, b, sums);
    }
    // Adds only to the sums of p, a and b.
    void add_means(int y, const simd::ColumnSums& sums) {
        laplacians(y);
        simd::best().means(at(y), rest_.data(), L_.data(), last_ - first_, skin_.constants.curvature_length,
                           skin_.constants.bend, sums);
    }

  private:
    const double* at(int y) const { return map_.data() + size_t(y) * size_t(unit_.width) + size_t(first_); }
    void laplacians(int y) {
        model::rest_curvature_row(skin_, y, first_, last_, rest_.data());
        model::laplacian_row(schedule_.pressure, y, first_, last_, unit_, skin_.stencil, skin_.edges, L_.data());
    }

    const model::PreparedSkin& skin_;
    const model::Schedule& schedule_;
    const Map& map_;
    const Grid unit_;
    const int first_, last_;
    std::vector<double> rest_, L_;
};

constexpr int block = 256; // columns at a time; their values stay in the first-level cache

// Column sums of a block.
struct BlockSums {
    double p[2][block] = {}, a[2][block] = {}, b[2][block] = {}; // sums in two parts
    double least[block], greatest[block];

    BlockSums() {
        std::fill_n(least, block, INFINITY);
        std::fill_n(greatest, block, -INFINITY);
    }
    simd::ColumnSums columns() {
        return {.p = {p[0], p[1]}, .a = {a[0], a[1]}, .b = {b[0], b[1]}, .least = least, .greatest = greatest};
    }
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

void add(f64::LongSum& sum, double x, double rest = 0) { sum = f64::joined(sum, {x, rest}); }

// The sums of p, a and each b in two parts, so that their number adds no error.
struct Sums {
    f64::LongSum p{0, 0}, a{0, 0};
    std::vector<f64::LongSum> b; // of each part

    explicit Sums(size_t parts) : b(parts, {0, 0}) {}
    void add_all(const Sums& other) {
        p = f64::joined(p, other.p);
        a = f64::joined(a, other.a);
        for (size_t m = 0; m < b.size(); ++m) b[m] = f64::joined(b[m], other.b[m]);
    }
    Moments::Means over(size_t cells) const {
        const auto mean = [cells](const f64::LongSum& s) { return (s.sum + s.rest) / double(cells); };
        Moments::Means means{.p = mean(p), .a = mean(a), .b = {}};
        for (const f64::LongSum& sum : b) means.b.push_back(mean(sum));
        return means;
    }
};

// Sums and hull of some rows within a box, outside which the map is 0.
struct Stripe {
    Sums sums{1};
    double least = INFINITY, greatest = -INFINITY;
    std::vector<Vertex> hull;
    std::vector<simd::HalfPlane> polygon; // inscribed in this stripe's own hull

    // Adds rows first, first + step .. below last of the box. `others` is a polygon inscribed in the hull of other
    // rows, or empty: points inside it are no vertices of the whole and are left out.
    void add_rows(const model::PreparedSkin& skin, const model::Schedule& schedule, const Map& map,
                  const model::PressedBox& box, int first, int last, int step,
                  const std::vector<simd::HalfPlane>& others) {
        const int from = box.first_column(), to = box.last_column(skin.width());
        Candidates points;
        for (int column = from; column < to; column += block) {
            const int end = std::min(column + block, to);
            const size_t width = size_t(end - column);
            BlockSums columns;
            MomentRow row(skin, schedule, map, column, end);
            for (int y = first; y < last; y += step) {
                if (!schedule.output.extremes) {
                    row.add_means(y, columns.columns());
                    continue;
                }
                points.reserve(width);
                row.compute(y, points.a.data() + points.count, points.b.data() + points.count, columns.columns());
                points.keep(width, others);
            }
            add_sums(columns, width);
        }
        if (points.count == 0 || !is_finite(sums.over(1))) return; // moments_of() refuses what is not finite
        const auto [left, right] =
            std::minmax_element(points.b.begin(), points.b.begin() + std::ptrdiff_t(points.count));
        const HullSides sides(points.b.data(), points.a.data(), points.count, *left, *right);
        hull = sides.upper;
        for (const Vertex& v : sides.lower) hull.push_back({v.b, -v.a});
        if (others.empty()) polygon = inscribed_polygon(sides);
    }

    void add_sums(const BlockSums& of, size_t width) {
        for (size_t x = 0; x < width; ++x) {
            add(sums.p, of.p[0][x], of.p[1][x]);
            add(sums.a, of.a[0][x], of.a[1][x]);
            add(sums.b[0], of.b[0][x], of.b[1][x]);
            least = std::min(least, of.least[x]);
            greatest = std::max(greatest, of.greatest[x]);
        }
    }
};

void add_hull(Moments::Layer& m, const std::vector<Vertex>& vertices) {
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

constexpr int stripe_rows = 16; // fixed, because the bits depend on it

void check_finite(const Moments::Means& m) {
    if (!is_finite(m))
        throw Error(Error::Code::bad_input, "",
                    "pressure times curvature overflows; allowed: loads and lengths whose products stay below 1.8e308");
}

// Calls of_rows(first, last) on the threads for each stripe of the rows that are pressed; returns what it returns.
template <class Of> auto of_stripes(const model::PressedBox& box, simd::Pool& pool, Of of_rows) {
    const int rows = box.last_row - box.first_row, count = (rows + stripe_rows - 1) / stripe_rows;
    std::vector<decltype(of_rows(0, 0))> stripes(static_cast<size_t>(count));
    pool.share(count, [&](int first, int last) {
        for (int i = first; i < last && !pool.failed(); ++i)
            stripes[size_t(i)] =
                of_rows(box.first_row + i * stripe_rows, box.first_row + std::min((i + 1) * stripe_rows, rows));
    });
    return stripes;
}

// The sums of a map in each of several parts, or of one product under all, over rows first .. last - 1 of a box,
// without extremes.
std::vector<Sums> sums_of_parts(const model::PreparedSkin& skin, const Map& map, const model::PressedBox& box,
                                const std::vector<Map>& parts, int first, int last) {
    const Grid unit = model::without_spacing(skin.description.grid);
    const double length = skin.constants.curvature_length, bend = skin.constants.bend;
    const int from = box.first_column(), to = box.last_column(skin.width());
    const size_t width = size_t(to - from);
    std::vector<Sums> sums(parts.size(), Sums(parts.size()));
    std::vector<double> rest(width), L(width);
    for (int y = first; y < last; ++y) {
        const size_t row = skin.number_of({from, y});
        model::rest_curvature_row(skin, y, from, to, rest.data());
        for (size_t x = 0; x < width; ++x) {
            Sums& s = sums[skin.material_at(row + x)];
            const double p = map[row + x];
            add(s.p, p);
            add(s.a, p * (1 + length * rest[x]));
        }
        for (size_t m = 0; m < parts.size(); ++m) {
            model::laplacian_row(parts[m], y, from, to, unit, skin.stencil, skin.edges, L.data());
            for (size_t x = 0; x < width; ++x)
                add(sums[skin.material_at(row + x)].b[m], map[row + x] * (length * (bend * L[x])));
        }
    }
    return sums;
}

// The sums, range and hull of one part.
void add_one_part(Moments::Layer& m, const model::PreparedSkin& skin, const model::Schedule& schedule,
                  const model::PressedBox& box, simd::Pool& pool) {
    constexpr int sampled = 8; // rows; fixed, because the bits depend on it
    const int rows = box.last_row - box.first_row;
    Stripe sample; // evenly spaced rows: their hull contains most points of the others
    if (rows > 0 && schedule.output.extremes)
        sample.add_rows(skin, schedule, m.map, box, box.first_row, box.last_row, std::max(rows / sampled, 1), {});
    const auto stripes = of_stripes(box, pool, [&](int first, int last) {
        Stripe stripe;
        stripe.add_rows(skin, schedule, m.map, box, first, last, 1, sample.polygon);
        return stripe;
    });
    const bool full = rows == skin.height() && box.first_tile == 0 && box.last_tile == skin.tiles;
    std::vector<Vertex> vertices = sample.hull;
    if (!full) vertices.push_back({0, 0}); // cells outside the pressed box
    m.least = full ? stripes[0].least : 0;
    m.greatest = full ? stripes[0].greatest : 0;
    Sums sums(1);
    for (const Stripe& stripe : stripes) {
        sums.add_all(stripe.sums);
        vertices.insert(vertices.end(), stripe.hull.begin(), stripe.hull.end());
        m.least = std::min(m.least, stripe.least);
        m.greatest = std::max(m.greatest, stripe.greatest);
    }
    m.means = {sums.over(skin.cells())};
    check_finite(m.means[0]); // before the hull, which takes finite points
    if (schedule.output.extremes) add_hull(m, vertices);
}

// The means of each part of a layer, or of a product's layer under the curvature of all products.
void add_means(Moments::Layer& layer, const model::PreparedSkin& skin, const model::PressedBox& box,
               const std::vector<Map>& pressures, simd::Pool& pool) {
    const auto stripes = of_stripes(
        box, pool, [&](int first, int last) { return sums_of_parts(skin, layer.map, box, pressures, first, last); });
    for (size_t k = 0; k < (skin.uniform() ? 1 : pressures.size()); ++k) {
        Sums sums(pressures.size());
        for (const auto& stripe : stripes) sums.add_all(stripe[k]);
        layer.means.push_back(sums.over(skin.cells()));
        check_finite(layer.means.back());
    }
}

// The layers of one product: its pressure, and its stress at each depth.
void add_layers(Moments& m, const model::Schedule& schedule) {
    m.layers.push_back({.map = schedule.pressure});
    for (size_t q = 0; q < schedule.stress.size(); ++q) {
        const Map& map = schedule.stress[q];
        if (map.empty()) continue;
        size_t& layer = m.layer_of[q];
        for (layer = 1; layer < m.layers.size() && m.layers[layer].map.data() != map.data();) ++layer;
        if (layer == m.layers.size()) m.layers.push_back({.map = map});
    }
}

} // namespace

std::shared_ptr<const Moments> moments_of(const model::PreparedSkin& skin, const model::Schedule& schedule,
                                          bool points_only, int threads) {
    auto m = std::make_shared<Moments>();
    m->pressures = pressures_of_parts(skin, schedule);
    m->cells = schedule.points;
    for (const model::Schedule& other : schedule.others) m->pressures.push_back(other.pressure);
    m->others.resize(schedule.others.size());
    simd::Pool pool(points_only ? 1 : simd::useful_threads(skin.cells(), threads));
    for (size_t i = 0; i < schedule.products(); ++i) {
        Moments& of = i == 0 ? *m : m->others[i - 1];
        add_layers(of, schedule.product(i));
        for (Moments::Layer& layer : of.layers) {
            add_points(layer, m->pressures, skin, schedule, i);
            const model::PressedBox box = &layer == &of.layers.front() ? schedule.product(i).pressed : skin.whole();
            if (points_only) continue;
            if (skin.uniform() && schedule.others.empty()) add_one_part(layer, skin, schedule, box, pool);
            else add_means(layer, skin, box, m->pressures, pool); // materials that differ are pressed alone
        }
    }
    return m;
}

} // namespace dermis::reduced
