// SPDX-License-Identifier: MIT
// Steps the scalars of one cell under unit pressure, and turns them into means, extremes, points and fields.
#include "host/reduced/moment_row.hpp"
#include "host/reduced/moments.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::reduced {
namespace {

class Separable : public plan::Stepper {
  public:
    Separable(const plan::PreparedSkin& skin, const plan::Schedule& schedule, std::shared_ptr<const Moments> moments,
              bool points_only, Sink sink)
        : skin_(skin), schedule_(schedule), moments_(std::move(moments)), points_only_(points_only),
          sink_(std::move(sink)) {}

    void frame(const std::vector<double>&) override {} // plan::why_not refuses frames

    // Sums are compensated: with one cell to step, that costs nothing.
    void press(const plan::Step& step) override {
        const f64::LaneCoefficients k = f64::lanes_of(step.coefficients->front());
        const f64::Load load = f64::load(step.start, step.rise, step.jump);
        const f64::CellState after = f64::advanced(state_, load, k, 1);
        visible_.g = after.strain.value;
        visible_.G = after.integral.value;
        visible_.rate = f64::rate_after(state_.strain.value, load, k);
        visible_.acceleration = f64::acceleration_after(state_.strain.value, load, k) * skin_.constants.gain_plus;
        if (step.trace >= 0 || step.impulse >= 0) points_only_ ? deliver_sites(step) : deliver(step);
        if (step.keep) state_ = after;
    }

    void finish() override {}

    plan::StencilEstimate estimate(const plan::PreparedSkin& skin) override {
        return plan::stencil_estimate(skin, schedule_.pressure, visible_.g);
    }

    void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
        const size_t width = size_t(skin_.width());
        maps.resize(what.size());
        for (auto& map : maps) map.resize(skin_.cells());
        MomentRow row(skin_, schedule_, 0, skin_.width());
        std::vector<double> a(width), b(width), unused(5 * width);
        double* u = unused.data();
        for (int y = 0; y < skin_.height(); ++y) {
            row.compute(
                y, a.data(), b.data(),
                {.p = u, .a = u + width, .b = u + 2 * width, .least = u + 3 * width, .greatest = u + 4 * width});
            for (size_t i = 0; i < what.size(); ++i)
                read_row(what[i], y, row, a, b, maps[i].data() + size_t(y) * width);
        }
    }

  private:
    // Strain, integral, rate and acceleration per unit of pressure.
    struct Scalars {
        double g = 0, G = 0, rate = 0, acceleration = 0;
    };

    double scalar(Quantity q) const {
        switch (q) {
        case Quantity::strain:
        case Quantity::sa1: return visible_.g;
        case Quantity::sa2: return visible_.G;
        case Quantity::fa1: return visible_.rate;
        case Quantity::fa2: return visible_.acceleration;
        default: return 0;
        }
    }

    void read_row(Quantity q, int y, const MomentRow& row, const std::vector<double>& a, const std::vector<double>& b,
                  double* out) const {
        const f64::Constants& c = skin_.constants;
        const size_t width = size_t(c.width), at = size_t(y) * width;
        const double *heights = skin_.heights.data() + at, *p = schedule_.pressure.data() + at;
        const double X = scalar(q), g = visible_.g;
        for (size_t x = 0; x < width; ++x)
            if (q == Quantity::strain) out[x] = p[x] * g;
            else if (q == Quantity::deformation) out[x] = heights[x] * skin_.relief - c.thickness * p[x] * g;
            else if (q == Quantity::curvature) out[x] = row.rest()[x] - c.bend * row.load()[x] * g;
            else out[x] = X * (a[x] - g * b[x]);
    }

    // Delivers the response of each site's own class.
    void deliver_sites(const plan::Step& step) {
        const std::vector<Site>& sites = skin_.description.sites;
        const size_t n = moments_->points.size(), first = n - sites.size();
        sample_.points.resize(n * REDUCED_MAPS);
        for (size_t i = 0; i < sites.size(); ++i) {
            const Moments::Point& p = moments_->points[first + i];
            sample_.points[size_t(sites[i].type) * n + first + i] = scalar(sites[i].type) * (p.a - visible_.g * p.b);
        }
        sink_(step, sample_);
    }

    void deliver(const plan::Step& step) {
        const Moments& m = *moments_;
        const double g = visible_.g;
        const bool extremes = schedule_.output.extremes;
        const double high = extremes ? extreme(m.upper, g, 1) : NAN, low = extremes ? extreme(m.lower, g, -1) : NAN;
        const auto ordered = [](double x, double y) { return std::pair{std::min(x, y), std::max(x, y)}; };
        sample_.points.clear();
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            const double X = scalar(Quantity(q));
            const bool strain = q == QUANTITY_STRAIN;
            const auto [min, max] = strain ? ordered(X * m.least, X * m.greatest) : ordered(X * low, X * high);
            sample_.totals[size_t(q)] = {strain ? X * m.p : X * (m.a - g * m.b), min, max};
            for (const Moments::Point& p : m.points) sample_.points.push_back(strain ? p.p * X : X * (p.a - g * p.b));
        }
        sink_(step, sample_);
    }

    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    std::shared_ptr<const Moments> moments_;
    const bool points_only_;
    Sink sink_;
    plan::Sample sample_;
    f64::CellState state_{};
    Scalars visible_;
};

} // namespace

std::unique_ptr<plan::Stepper> separable(const plan::PreparedSkin& skin, const plan::Schedule& schedule,
                                         std::shared_ptr<const Moments> moments, bool points_only,
                                         plan::Stepper::Sink sink) {
    return std::make_unique<Separable>(skin, schedule, std::move(moments), points_only, std::move(sink));
}

} // namespace dermis::reduced
