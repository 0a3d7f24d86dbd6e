// SPDX-License-Identifier: MIT
#include "host/reduced/sites.hpp"

#include "host/plan/site_stepper.hpp"
#include "host/simd/pool.hpp"

namespace dermis::reduced {
namespace {

class Sites : public plan::Stepper {
  public:
    Sites(const plan::PreparedSkin& skin, const plan::Schedule& schedule, const plan::SiteCells& cells, bool own_class,
          int threads, Sink sink)
        : skin_(skin), schedule_(schedule), sink_(std::move(sink)),
          pool_(simd::useful_threads(8 * cells.cells.size(), threads)),
          stepper_(skin, cells, variant_of(skin, schedule, Precision::f64)), cells_(cells.cells),
          columns_(cells.points.size()) {
        const std::vector<Site>& sites = skin.description.sites;
        const plan::PressedCells pressed = pressed_cells(schedule);
        for (size_t i = 0; i < columns_; ++i) {
            const Cell c = cells.points[i];
            if (!ever_pressed(pressed, size_t(c.y) * size_t(skin.width()) + size_t(c.x), skin.width()))
                continue; // all of its values are 0
            const bool site = own_class && i >= columns_ - sites.size();
            points_.push_back({stepper_.point(c), i, site ? int(sites[i - (columns_ - sites.size())].type) : -1});
        }
        std::sort(points_.begin(), points_.end(),
                  [](const Point& a, const Point& b) { return a.at.stencil.here < b.at.stencil.here; });
        for (size_t cell : cells_) {
            from_.push_back(0);
            to_.push_back(schedule.framed ? 0 : schedule.pressure[cell]);
        }
        sample_.points.assign(columns_ * REDUCED_MAPS, 0);
    }

    void frame(const std::vector<double>& pressure) override {
        from_.swap(to_);
        for (size_t i = 0; i < cells_.size(); ++i) to_[i] = pressure[cells_[i]];
    }

    void press(const plan::Step& step) override {
        const f64::Constants c = plan::constants_of<f64>(skin_, schedule_.pressed, step);
        if (step.coefficients != lanes_of_) {
            lanes_of_ = step.coefficients;
            lanes_.clear();
            for (const f64::Coefficients& k : *step.coefficients) lanes_.push_back(f64::lanes_of(k));
        }
        pool_.share(int(cells_.size()), [&](int first, int last) {
            stepper_.advance(c, lanes_.data(), pressures(), size_t(first), size_t(last));
        });
        if (step.trace >= 0) {
            pool_.share(int(points_.size()), [&](int first, int last) {
                for (int i = first; i < last; ++i) respond(points_[size_t(i)], c);
            });
            sink_(step, sample_);
        }
        if (step.keep) stepper_.keep();
    }

    void finish() override {}
    void read(const std::vector<Quantity>&, std::vector<std::vector<double>>&) override {
    } // plan::why_not refuses fields

  private:
    struct Point {
        plan::SiteStepper<f64>::Point at;
        size_t column; // index in a sample
        int type;      // quantity of a site that has only its own class; -1: every quantity
    };

    plan::SiteStepper<f64>::Pressures pressures() const {
        return {schedule_.framed ? from_.data() : to_.data(), to_.data()};
    }

    void respond(const Point& p, const f64::Constants& c) {
        for (int q = 0; q < REDUCED_MAPS; ++q)
            if (p.type < 0 || p.type == q)
                sample_.points[size_t(q) * columns_ + p.column] =
                    stepper_.value(p.at, Quantity(q), c, lanes_.data(), pressures());
    }

    const plan::PreparedSkin& skin_;
    const plan::Schedule& schedule_;
    Sink sink_;
    simd::Pool pool_;
    plan::SiteStepper<f64> stepper_;
    const std::vector<size_t>& cells_;
    size_t columns_;                // number of all points
    std::vector<Point> points_;     // those that are ever pressed
    std::vector<double> from_, to_; // pressure of cells_
    std::vector<f64::LaneCoefficients> lanes_;
    plan::SharedCoefficients lanes_of_; // source of lanes_
    plan::Sample sample_{};
};

} // namespace

std::unique_ptr<plan::Stepper> sites(const plan::PreparedSkin& skin, const plan::Schedule& schedule,
                                     const plan::SiteCells& cells, bool own_class, int threads,
                                     plan::Stepper::Sink sink) {
    return std::make_unique<Sites>(skin, schedule, cells, own_class, threads, std::move(sink));
}

} // namespace dermis::reduced
