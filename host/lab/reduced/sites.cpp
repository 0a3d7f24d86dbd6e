// SPDX-License-Identifier: MIT
#include "host/lab/reduced/sites.hpp"

#include "host/core/base/pool.hpp"
#include "host/lab/reduced/site_stepper.hpp"

namespace dermis::reduced {
namespace {

class Sites : public model::Stepper {
  public:
    Sites(const model::PreparedSkin& skin, const model::Schedule& schedule, const model::SiteCells& cells,
          const std::vector<int>& classes, bool gains, int threads, Sink sink)
        : skin_(skin), schedule_(schedule), gains_(gains), sink_(std::move(sink)),
          pool_(simd::useful_threads(8 * cells.cells.size(), threads)), deep_(skin, schedule, cells, classes),
          stepper_(skin, schedule, cells, deep_.places),
          materials_(schedule.modes.empty() ? cells.materials : elements_of(skin, schedule)),
          columns_(cells.points.size()) {
        const model::PressedCells pressed = pressed_cells(schedule);
        for (size_t i = 0; i < columns_; ++i) {
            const Cell c = cells.points[i];
            if (ever_pressed(pressed, skin.number_of(c), skin.width()) || has_deep(i))
                points_.push_back({{skin, cells, c}, i, classes[i]}); // all that the others have is 0
        }
        std::ranges::sort(points_,
                          [](const Point& a, const Point& b) { return a.at.stencil.here < b.at.stencil.here; });
        sample_.points.assign(columns_ * answered, 0);
    }

    void frame(const std::vector<double>& pressure) override { stepper_.frame(pressure); }

    void press(const model::Step& step) override {
        f64::Constants c = model::constants_of<f64>(skin_, schedule_.pressed);
        c.start = step.constant_start();
        c.rise = step.constant_rise();
        c.jump = step.jump;
        if (!gains_) c.gain_plus = 1, c.gain_minus = -1;
        if (!step.same_coefficients(lanes_of_)) {
            lanes_of_ = step;
            model::fill_table<f64>(step, materials_, skin_.chain, skin_.rule, table_);
            lanes_.resize(table_.size());
            std::ranges::transform(table_, lanes_.begin(), f64::lanes_of);
        }
        pool_.share(int(stepper_.size()),
                    [&](int first, int last) { stepper_.advance(c, lanes_.data(), size_t(first), size_t(last)); });
        if (step.trace >= 0) {
            pool_.share(int(points_.size()), [&](int first, int last) {
                for (int i = first; i < last; ++i) respond(points_[size_t(i)], c);
            });
            sink_(step, sample_);
        }
        if (step.keep) stepper_.keep();
    }

    void read(const std::vector<Quantity>&, std::vector<std::vector<double>>&) override {} // model::why_not: no fields

  private:
    static constexpr int answered = int(Quantity::curvature) + 1; // quantities of a sample
    struct Point {
        model::SitePlace<f64> at;
        size_t column; // of a sample
        int quantity;  // the one that is asked for, or every_quantity
    };

    bool has_deep(size_t point) const {
        return std::ranges::any_of(deep_.of_point[point], [](size_t cell) { return cell > 0; });
    }

    void respond(const Point& p, const f64::Constants& c) {
        for (int q = 0; q < answered; ++q)
            if (p.quantity == every_quantity || p.quantity == q)
                sample_.points[size_t(q) * columns_ + p.column] =
                    stepper_.value(p.at, Quantity(q), deep_.of_point[p.column][size_t(q)], c, lanes_.data());
    }

    const model::PreparedSkin& skin_;
    const model::Schedule& schedule_;
    const bool gains_; // whether FA2 has its gains
    Sink sink_;
    simd::Pool pool_;
    const model::DeepCells deep_;
    model::SiteStepper<f64> stepper_;
    const std::vector<model::Element> materials_;
    size_t columns_;            // of a sample: all points
    std::vector<Point> points_; // the points that are ever pressed
    std::vector<f64::Coefficients> table_;
    std::vector<f64::LaneCoefficients> lanes_;
    model::Step lanes_of_; // what lanes_ was made from
    model::Sample sample_{};
};

} // namespace

std::vector<int> classes_of(const model::PreparedSkin& skin, const model::Schedule& schedule) {
    std::vector<int> classes(schedule.output.probes.size(), every_quantity);
    for (const Site& site : skin.description.sites) classes.push_back(int(site.type));
    return classes;
}

std::unique_ptr<model::Stepper> sites(const model::PreparedSkin& skin, const model::Schedule& schedule,
                                      const model::SiteCells& cells, const std::vector<int>& classes, int threads,
                                      model::Stepper::Sink sink, bool gains) {
    return std::make_unique<Sites>(skin, schedule, cells, classes, gains, threads, std::move(sink));
}

} // namespace dermis::reduced
