// SPDX-License-Identifier: MIT
// Steps one cell of each part under unit pressure, or under each product's envelope, and turns its signals into means,
// extremes, points and fields. A term is a part, or a product.
#include "host/core/model/laplacian.hpp"
#include "host/lab/reduced/moments.hpp"
#include "host/lab/schedule/cell.hpp"
#include "host/lab/schedule/timeline.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::reduced {
namespace {

class Separable : public model::Stepper {
  public:
    Separable(const model::PreparedSkin& skin, const model::Schedule& schedule, std::shared_ptr<const Moments> moments,
              bool points_only, Sink sink)
        : skin_(skin), schedule_(schedule), moments_(std::move(moments)), points_only_(points_only),
          sink_(std::move(sink)), elements_(elements_of(skin, schedule)),
          visible_(skin.materials.size() / skin.chain.length + schedule.others.size()), most_(visible_) {
        for (size_t term = 0; term < visible_.size(); ++term)
            cells_.push_back({skin.chain, &skin.materials[first_element(term)], schedule.time.duration});
        for (const model::Schedule& other : schedule.others)
            timelines_.emplace_back(other, elements_, skin.rule, schedule.method);
        for (const model::Element& mode : schedule.modes) modes_.push_back({alone_, &mode, schedule.time.duration});
    }

    void frame(const std::vector<double>&) override {} // model::why_not refuses frames

    // Sums are compensated: with one cell of each term to step, that costs nothing.
    void press(const model::Step& step) override {
        const f64::Load load = f64::load(step.start, step.rise, step.jump);
        model::fill_table<f64>(step, skin_.materials, skin_.chain, skin_.rule, table_);
        press_modes(step, load);
        const size_t parts = visible_.size() - timelines_.size();
        for (size_t part = 0; part < parts; ++part) press_term(part, step, load, schedule_);
        for (size_t i = 0; i < timelines_.size(); ++i) {
            model::Step of;
            timelines_[i].next(of); // as many as the first product's
            model::fill_table<f64>(of, skin_.materials, skin_.chain, skin_.rule, table_);
            press_term(parts + i, of, f64::load(of.start, of.rise, of.jump), schedule_.others[i]);
        }
        if (step.trace >= 0 && greatest_strain(visible_) > greatest_strain(most_)) most_ = visible_;
        if (step.trace >= 0 || step.impulse >= 0) points_only_ ? deliver_sites(step) : deliver(step);
    }

    // The greatest curvature at the end, and at the output with the greatest strain.
    model::StencilEstimate estimate(const model::PreparedSkin& skin) override {
        model::StencilEstimate now = estimate_now(skin);
        if (greatest_strain(most_) == greatest_strain(visible_)) return now;
        visible_.swap(most_);
        now.curvature = std::max(now.curvature, estimate_now(skin).curvature);
        visible_.swap(most_);
        return now;
    }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const size_t width = size_t(skin_.width());
        const Grid unit = model::without_spacing(skin_.description.grid);
        maps.resize(what.size());
        for (auto& map : maps) map.resize(skin_.cells());
        std::vector<double> rest(width);
        std::vector<std::vector<double>> L(visible_.size(), rest); // L(p_m) per cell^2
        for (int y = 0; y < skin_.height(); ++y) {
            model::rest_curvature_row(skin_, y, 0, skin_.width(), rest.data());
            for (size_t m = 0; m < L.size(); ++m)
                model::laplacian_row(moments_->pressures[m], y, 0, skin_.width(), unit, skin_.stencil, skin_.edges,
                                     L[m].data());
            for (size_t i = 0; i < what.size(); ++i)
                read_row(what[i], size_t(y) * width, rest, L, maps[i].data() + size_t(y) * width);
        }
    }

  private:
    using Signals = std::array<double, REDUCED_MAPS>;

    // Steps the elements whose sum is the stress that classes follow.
    void press_modes(const model::Step& step, const f64::Load& load) {
        stress_.fill(0);
        for (size_t i = 0; i < modes_.size(); ++i) {
            f64::Coefficients k;
            const size_t first = skin_.materials.size();
            model::fill_chain<f64>(step, elements_, alone_, skin_.rule, first + i, &k);
            modes_[i].press(load, &k);
            for (size_t q = 0; q < stress_.size(); ++q) stress_[q] += schedule_.shares[i] * modes_[i].signal(int(q));
            if (step.keep) modes_[i].keep();
        }
    }

    // Index of a term's first element.
    size_t first_element(size_t term) const { return is_sum() ? 0 : term * skin_.chain.length; }
    bool is_sum() const { return !schedule_.others.empty(); }
    // Steps the cell of a term, whose coefficients are in table_.
    void press_term(size_t term, const model::Step& step, const f64::Load& load, const model::Schedule& of) {
        model::ProductCell<f64>& cell = cells_[term];
        cell.press(load, table_.data() + first_element(term));
        for (int q = 0; q < REDUCED_MAPS; ++q)
            visible_[term][size_t(q)] = 0 + of.unit * cell.signal(q); // 0 in place of -0
        visible_[term][QUANTITY_FA2] *= skin_.constants.gain_plus;
        for (size_t q = 0; q < stress_.size(); ++q)
            if (of.follows[q]) visible_[term][q] = 0 + of.unit * stress_[q];
        if (step.keep) cell.keep();
    }

    double strain(size_t part) const { return visible_[part][QUANTITY_STRAIN]; }
    // The greatest |strain| of a part under unit pressure.
    static double greatest_strain(const std::vector<Signals>& parts) {
        double greatest = 0;
        for (const Signals& s : parts) greatest = std::max(greatest, std::abs(s[QUANTITY_STRAIN]));
        return greatest;
    }

    model::StencilEstimate estimate_now(const model::PreparedSkin& skin) const {
        if (visible_.size() == 1) return model::stencil_estimate(skin, schedule_.pressure, strain(0));
        return model::stencil_estimate(skin, strains(), 1);
    }

    std::vector<double> strains() const {
        std::vector<double> eps(skin_.cells());
        for (size_t product = 0; product < schedule_.products(); ++product)
            for (size_t i = 0; i < eps.size(); ++i)
                eps[i] += schedule_.product(product).pressure[i] * strain(is_sum() ? product : skin_.material_at(i));
        return eps;
    }

    // at: the row's first cell.
    void read_row(Quantity q, size_t at, const std::vector<double>& rest, const std::vector<std::vector<double>>& L,
                  double* out) const {
        if (q == Quantity::curvature) {
            for (size_t x = 0; x < rest.size(); ++x) {
                out[x] = rest[x];
                for (size_t m = 0; m < L.size(); ++m) out[x] -= skin_.constants.bend * L[m][x] * strain(m);
            }
            return;
        }
        add_product<true>(q, 0, at, rest, L, out);
        for (size_t i = 1; i < schedule_.products(); ++i) add_product<false>(q, i, at, rest, L, out);
        if (q != Quantity::deformation) return;
        for (size_t x = 0; x < rest.size(); ++x) out[x] = skin_.heights[at + x] * skin_.relief - out[x];
    }

    // Writes what the first product makes of a row, or adds what another one adds; of a deformation, the indentation.
    template <bool first>
    void add_product(Quantity q, size_t product, size_t at, const std::vector<double>& rest,
                     const std::vector<std::vector<double>>& L, double* out) const {
        const f64::Constants& c = skin_.constants;
        const model::Schedule& of = schedule_.product(product);
        const Map& map = int(q) < REDUCED_MAPS ? of.map_of(size_t(q)) : of.pressure;
        std::vector<double> b(L.size());
        const bool sum = is_sum();
        for (size_t x = 0; x < rest.size(); ++x) {
            const size_t term = sum ? product : skin_.material_at(at + x);
            const double p = map[at + x];
            double v;
            if (q == Quantity::strain) v = p * strain(term);
            else if (q == Quantity::deformation) v = c.thickness * p * strain(term);
            else {
                for (size_t m = 0; m < b.size(); ++m) b[m] = p * (c.curvature_length * (c.bend * L[m][x]));
                v = visible_[term][size_t(q)] * gained(p * (1 + c.curvature_length * rest[x]), b);
            }
            out[x] = first ? v : out[x] + v;
        }
    }

    // a - sum of g_m*b_m.
    double gained(double a, const std::vector<double>& b) const {
        for (size_t m = 0; m < b.size(); ++m) a -= strain(m) * b[m];
        return a;
    }

    // Delivers the response of each site's own class.
    void deliver_sites(const model::Step& step) {
        const std::vector<Site>& sites = skin_.description.sites;
        const size_t n = schedule_.points.size(), first = n - sites.size();
        sample_.points.resize(n * REDUCED_MAPS);
        for (size_t i = 0; i < sites.size(); ++i) {
            const size_t q = size_t(sites[i].type);
            sample_.points[q * n + first + i] = value_in(q, first + i);
        }
        sink_(step, sample_);
    }

    // A quantity in a point.
    double value_in(size_t q, size_t point) const {
        const auto of = [&](size_t product) {
            const Moments::Point& p = moments_->product(product).of(q).points[point];
            return visible_[p.part][q] * (q == QUANTITY_STRAIN ? p.p : gained(p.a, p.b));
        };
        double sum = of(0);
        for (size_t i = 1; i < schedule_.products(); ++i) sum += of(i);
        return sum;
    }

    double mean_of(size_t q) const {
        double mean = 0;
        for (size_t i = 0; i < schedule_.products(); ++i) {
            const std::vector<Moments::Means>& parts = moments_->product(i).of(q).means;
            for (size_t k = 0; k < parts.size(); ++k)
                mean += visible_[i + k][q] * (q == QUANTITY_STRAIN ? parts[k].p : gained(parts[k].a, parts[k].b));
        }
        return mean;
    }

    // Writes the least and the greatest value over all cells of each quantity that is asked for; no hull has those of a
    // sum.
    void take_ranges_of_cells() {
        const f64::Constants& c = skin_.constants;
        const size_t width = size_t(skin_.width());
        if (bends_.empty()) bends_ = bends();
        std::vector<double> gain(width), row(width);
        for (size_t q = 0; q < REDUCED_MAPS; ++q) sample_.totals[q].min = INFINITY, sample_.totals[q].max = -INFINITY;
        for (size_t at = 0; at < skin_.cells(); at += width) {
            model::rest_curvature_row(skin_, int(at / width), 0, int(width), gain.data());
            for (size_t m = 0; m < bends_.size(); ++m) add_row(bends_[m].data() + at, -strain(m), gain);
            for (double& C : gain) C = 1 + c.curvature_length * C;
            for (size_t q = 0; q < REDUCED_MAPS; ++q) {
                if (!schedule_.wanted[q]) continue;
                std::ranges::fill(row, 0);
                for (size_t term = 0; term < visible_.size(); ++term)
                    add_row(schedule_.product(term).map_of(q).data() + at, visible_[term][q], row);
                if (q != QUANTITY_STRAIN)
                    for (size_t x = 0; x < width; ++x) row[x] *= gain[x];
                model::Totals& totals = sample_.totals[q];
                for (double v : row) totals.min = std::min(totals.min, v), totals.max = std::max(totals.max, v);
            }
        }
    }

    static void add_row(const double* values, double factor, std::vector<double>& sum) {
        for (size_t x = 0; x < sum.size(); ++x) sum[x] += factor * values[x];
    }

    // By how much a strain of 1 under each term's pressure bends each cell, 1/m.
    std::vector<std::vector<double>> bends() const {
        std::vector<std::vector<double>> maps(visible_.size(), std::vector<double>(skin_.cells()));
        const size_t width = size_t(skin_.width());
        for (size_t m = 0; m < maps.size(); ++m)
            for (int y = 0; y < skin_.height(); ++y) {
                double* row = maps[m].data() + size_t(y) * width;
                model::laplacian_row(moments_->pressures[m], y, 0, skin_.width(),
                                     model::without_spacing(skin_.description.grid), skin_.stencil, skin_.edges, row);
                for (size_t x = 0; x < width; ++x) row[x] *= skin_.constants.bend;
            }
        return maps;
    }

    void deliver(const model::Step& step) {
        const double g = strain(0); // extremes by hulls: of one part alone
        const bool extremes = schedule_.output.extremes && visible_.size() == 1;
        std::array<std::pair<double, double>, REDUCED_MAPS> ranges; // of a - g*b in each layer
        ranges.fill({NAN, NAN});
        for (size_t i = 0; extremes && i < moments_->layers.size(); ++i) {
            const Moments::Layer& m = moments_->layers[i];
            ranges[i] = {extreme(m.lower, g, -1), extreme(m.upper, g, 1)};
        }
        const auto ordered = [](double x, double y) { return std::pair{std::min(x, y), std::max(x, y)}; };
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            const double X = visible_[0][q];
            const Moments::Layer& m = moments_->of(q);
            const auto [low, high] = ranges[moments_->layer_of[q]];
            const auto [min, max] =
                q == QUANTITY_STRAIN ? ordered(X * m.least, X * m.greatest) : ordered(X * low, X * high);
            sample_.totals[q] = {mean_of(q), min, max};
        }
        if (is_sum() && schedule_.output.extremes) take_ranges_of_cells();
        sample_.points.clear();
        for (size_t q = 0; q < REDUCED_MAPS; ++q)
            for (size_t point = 0; point < schedule_.points.size(); ++point)
                sample_.points.push_back(value_in(q, point));
        sink_(step, sample_);
    }

    const model::PreparedSkin& skin_;
    const model::Schedule& schedule_;
    std::shared_ptr<const Moments> moments_;
    const bool points_only_;
    Sink sink_;
    model::Sample sample_;
    const model::Chain alone_;                   // an element by itself
    const std::vector<model::Element> elements_; // of the timeline
    std::vector<model::ProductCell<f64>> cells_; // of each term
    std::vector<model::Timeline> timelines_;     // of Schedule::others
    std::vector<model::ProductCell<f64>> modes_; // of Schedule::modes
    Signals stress_{};                           // that classes follow, after the last step
    std::vector<f64::Coefficients> table_;       // of the parts' elements
    std::vector<std::vector<double>> bends_;     // of each term, once extremes are taken from cells
    std::vector<Signals> visible_; // strain and signals of each term after the last step, under Schedule::unit
    std::vector<Signals> most_;    // the same at the output with the greatest strain
};

} // namespace

std::unique_ptr<model::Stepper> separable(const model::PreparedSkin& skin, const model::Schedule& schedule,
                                          std::shared_ptr<const Moments> moments, bool points_only,
                                          model::Stepper::Sink sink) {
    return std::make_unique<Separable>(skin, schedule, std::move(moments), points_only, std::move(sink));
}

} // namespace dermis::reduced
