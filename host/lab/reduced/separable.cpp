// SPDX-License-Identifier: MIT
// Steps one cell of each part under unit pressure, and turns its signals into means, extremes, points and fields.
#include "host/core/model/laplacian.hpp"
#include "host/lab/reduced/moments.hpp"
#include "host/lab/schedule/cell.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::reduced {
namespace {

class Separable : public plan::Stepper {
  public:
    Separable(const plan::PreparedSkin& skin, const plan::Schedule& schedule, std::shared_ptr<const Moments> moments,
              bool points_only, Sink sink)
        : skin_(skin), schedule_(schedule), moments_(std::move(moments)), points_only_(points_only),
          sink_(std::move(sink)), elements_(elements_of(skin, schedule)),
          visible_(skin.materials.size() / skin.chain.length), most_(visible_) {
        for (size_t i = 0; i < skin.materials.size(); i += skin.chain.length)
            cells_.push_back({skin.chain, &skin.materials[i], schedule.time.duration});
        for (const plan::Element& mode : schedule.modes) modes_.push_back({alone_, &mode, schedule.time.duration});
    }

    void frame(const std::vector<double>&) override {} // plan::why_not refuses frames

    // Sums are compensated: with one cell of each part to step, that costs nothing.
    void press(const plan::Step& step) override {
        const f64::Load load = f64::load(step.start, step.rise, step.jump);
        plan::fill_table<f64>(step, skin_.materials, skin_.chain, skin_.rule, table_);
        press_modes(step, load);
        for (size_t part = 0; part < cells_.size(); ++part) {
            plan::ProductCell<f64>& cell = cells_[part];
            cell.press(load, table_.data() + part * skin_.chain.length);
            for (int q = 0; q < REDUCED_MAPS; ++q)
                visible_[part][size_t(q)] = 0 + schedule_.unit * cell.signal(q); // 0 in place of -0
            visible_[part][QUANTITY_FA2] *= skin_.constants.gain_plus;
            for (size_t q = 0; q < stress_.size(); ++q)
                if (schedule_.follows[q]) visible_[part][q] = 0 + schedule_.unit * stress_[q];
            if (step.keep) cell.keep();
        }
        if (step.trace >= 0 && greatest_strain(visible_) > greatest_strain(most_)) most_ = visible_;
        if (step.trace >= 0 || step.impulse >= 0) points_only_ ? deliver_sites(step) : deliver(step);
    }

    // The greatest curvature at the end, and at the output with the greatest strain.
    plan::StencilEstimate estimate(const plan::PreparedSkin& skin) override {
        plan::StencilEstimate now = estimate_now(skin);
        if (greatest_strain(most_) == greatest_strain(visible_)) return now;
        visible_.swap(most_);
        now.curvature = std::max(now.curvature, estimate_now(skin).curvature);
        visible_.swap(most_);
        return now;
    }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const size_t width = size_t(skin_.width());
        const Grid unit = plan::without_spacing(skin_.description.grid);
        maps.resize(what.size());
        for (auto& map : maps) map.resize(skin_.cells());
        std::vector<double> rest(width);
        std::vector<std::vector<double>> L(visible_.size(), rest); // L(p_m) per cell^2
        for (int y = 0; y < skin_.height(); ++y) {
            plan::rest_curvature_row(skin_, y, 0, skin_.width(), rest.data());
            for (size_t m = 0; m < L.size(); ++m)
                plan::laplacian_row(moments_->pressures[m], y, 0, skin_.width(), unit, skin_.stencil, skin_.edges,
                                    L[m].data());
            for (size_t i = 0; i < what.size(); ++i)
                read_row(what[i], size_t(y) * width, rest, L, maps[i].data() + size_t(y) * width);
        }
    }

  private:
    using Signals = std::array<double, REDUCED_MAPS>;

    // Steps the elements whose sum is the stress that classes follow.
    void press_modes(const plan::Step& step, const f64::Load& load) {
        stress_.fill(0);
        for (size_t i = 0; i < modes_.size(); ++i) {
            f64::Coefficients k;
            const size_t first = skin_.materials.size();
            plan::fill_chain<f64>(step, elements_, alone_, skin_.rule, first + i, &k);
            modes_[i].press(load, &k);
            for (size_t q = 0; q < stress_.size(); ++q) stress_[q] += schedule_.shares[i] * modes_[i].signal(int(q));
            if (step.keep) modes_[i].keep();
        }
    }

    double strain(size_t part) const { return visible_[part][QUANTITY_STRAIN]; }
    // The greatest |strain| of a part under unit pressure.
    static double greatest_strain(const std::vector<Signals>& parts) {
        double greatest = 0;
        for (const Signals& s : parts) greatest = std::max(greatest, std::abs(s[QUANTITY_STRAIN]));
        return greatest;
    }

    plan::StencilEstimate estimate_now(const plan::PreparedSkin& skin) const {
        if (visible_.size() == 1) return plan::stencil_estimate(skin, schedule_.pressure, strain(0));
        return plan::stencil_estimate(skin, strains(), 1);
    }

    std::vector<double> strains() const {
        std::vector<double> eps(skin_.cells());
        for (size_t i = 0; i < eps.size(); ++i) eps[i] = schedule_.pressure[i] * strain(skin_.material_at(i));
        return eps;
    }

    // at: the row's first cell.
    void read_row(Quantity q, size_t at, const std::vector<double>& rest, const std::vector<std::vector<double>>& L,
                  double* out) const {
        const f64::Constants& c = skin_.constants;
        std::vector<double> b(L.size());
        const Map& map = int(q) < REDUCED_MAPS ? schedule_.map_of(size_t(q)) : schedule_.pressure;
        for (size_t x = 0; x < rest.size(); ++x) {
            const size_t part = skin_.material_at(at + x);
            const double p = map[at + x];
            if (q == Quantity::strain) out[x] = p * strain(part);
            else if (q == Quantity::deformation)
                out[x] = skin_.heights[at + x] * skin_.relief - c.thickness * p * strain(part);
            else if (q == Quantity::curvature) {
                out[x] = rest[x];
                for (size_t m = 0; m < b.size(); ++m) out[x] -= c.bend * L[m][x] * strain(m);
            } else {
                for (size_t m = 0; m < b.size(); ++m) b[m] = p * (c.curvature_length * (c.bend * L[m][x]));
                out[x] = visible_[part][size_t(q)] * gained(p * (1 + c.curvature_length * rest[x]), b);
            }
        }
    }

    // a - sum of g_m*b_m.
    double gained(double a, const std::vector<double>& b) const {
        for (size_t m = 0; m < b.size(); ++m) a -= strain(m) * b[m];
        return a;
    }

    // Delivers the response of each site's own class.
    void deliver_sites(const plan::Step& step) {
        const std::vector<Site>& sites = skin_.description.sites;
        const size_t n = schedule_.points.size(), first = n - sites.size();
        sample_.points.resize(n * REDUCED_MAPS);
        for (size_t i = 0; i < sites.size(); ++i) {
            const size_t q = size_t(sites[i].type);
            const Moments::Point& p = moments_->of(q).points[first + i];
            sample_.points[q * n + first + i] = visible_[p.part][q] * gained(p.a, p.b);
        }
        sink_(step, sample_);
    }

    void deliver(const plan::Step& step) {
        const double g = strain(0); // extremes: of one part alone
        const bool extremes = schedule_.output.extremes && visible_.size() == 1;
        std::array<std::pair<double, double>, REDUCED_MAPS> ranges; // of a - g*b in each layer
        ranges.fill({NAN, NAN});
        for (size_t i = 0; extremes && i < moments_->layers.size(); ++i) {
            const Moments::Layer& m = moments_->layers[i];
            ranges[i] = {extreme(m.lower, g, -1), extreme(m.upper, g, 1)};
        }
        const auto ordered = [](double x, double y) { return std::pair{std::min(x, y), std::max(x, y)}; };
        sample_.points.clear();
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            const double X = visible_[0][q];
            const Moments::Layer& m = moments_->of(q);
            const auto [low, high] = ranges[moments_->layer_of[q]];
            const bool strained = q == QUANTITY_STRAIN;
            const auto [min, max] = strained ? ordered(X * m.least, X * m.greatest) : ordered(X * low, X * high);
            double mean = 0;
            for (size_t k = 0; k < m.means.size(); ++k) {
                const Moments::Means& sums = m.means[k];
                mean += visible_[k][q] * (strained ? sums.p : gained(sums.a, sums.b));
            }
            sample_.totals[q] = {mean, min, max};
            for (const Moments::Point& p : m.points)
                sample_.points.push_back(visible_[p.part][q] * (strained ? p.p : gained(p.a, p.b)));
        }
        sink_(step, sample_);
    }

    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    std::shared_ptr<const Moments> moments_;
    const bool points_only_;
    Sink sink_;
    plan::Sample sample_;
    const plan::Chain alone_;                   // an element by itself
    const std::vector<plan::Element> elements_; // of the timeline
    std::vector<plan::ProductCell<f64>> cells_; // of each part
    std::vector<plan::ProductCell<f64>> modes_; // of Schedule::modes
    Signals stress_{};                          // that classes follow, after the last step
    std::vector<f64::Coefficients> table_;      // of the parts' elements
    std::vector<Signals> visible_; // strain and signals of each part after the last step, under Schedule::unit
    std::vector<Signals> most_;    // the same at the output with the greatest strain
};

} // namespace

std::unique_ptr<plan::Stepper> separable(const plan::PreparedSkin& skin, const plan::Schedule& schedule,
                                         std::shared_ptr<const Moments> moments, bool points_only,
                                         plan::Stepper::Sink sink) {
    return std::make_unique<Separable>(skin, schedule, std::move(moments), points_only, std::move(sink));
}

} // namespace dermis::reduced
