// SPDX-License-Identifier: MIT
// Cells that are computed beside a run in long double, by steps of their own: the run's error there is measured, not
// bounded.
// So is that of means and extremes, by those of the run's own maps.
#pragma once

#include "dermis/run.hpp"
#include "host/lab/march/stepper.hpp"
#include "host/lab/planner/bound.hpp"
#include "host/lab/reduced/site_stepper.hpp"
#include "host/lab/schedule/references.hpp"

#include <deque>

namespace dermis {

// A cell, and the quantities that the run writes there.
struct WitnessCell {
    static constexpr int traced = -1; // the quantities of traces and fields
    Cell cell;
    int quantity;  // traced, or the class of a site
    size_t column; // index among Schedule::points
};

class Witness {
  public:
    // The run's skin and schedule, before anything is done to make it cheaper; they need not outlive the witness.
    // peaks: what errors are relative to. stored: the least magnitude that the run stores.
    Witness(const model::PreparedSkin&, const model::Schedule&, const std::vector<WitnessCell>&, const planner::Peaks&,
            double stored);

    void frame(const std::vector<double>& pressure) { stepper_.frame(pressure); } // as Stepper::frame
    // Takes all steps that end at `end` or before. To be called before the run takes its own step to that instant.
    void advance(scene::Instant end);
    // Compares an output of the run; outputs come in order, perhaps some steps later.
    void compare(const model::Step&, const model::Sample&);
    // Compares a field of the run at its last instant, width*height.
    void compare(Quantity, const std::vector<double>& map);
    // Compares means and extremes at the outputs where a trace is greatest. To be called after each step of the run.
    void read(const model::Step&, model::Stepper&);
    // Sets measured_error, measured_cells and unmeasured, after the last output.
    void tell(Result&) const;

  private:
    using Extended = model::SiteStepper<extended>;
    struct Point {
        WitnessCell of;
        size_t number; // of the cell, y*width + x
        model::SitePlace<extended> at;
        long double surface;                                      // m, at rest
        std::array<size_t, size_t(Quantity::curvature) + 1> deep; // DeepCells::of_point
        bool compared = false;                                    // ever
    };
    // The values at an output: of each cell and quantity that is compared.
    struct Output {
        long long row;
        std::vector<long double> values;
    };

    void press(const model::Step&);
    long double value(const Point&, Quantity) const;
    bool knows(Quantity) const;
    bool compares(const Point&, Quantity) const;
    void take(double x, long double exact, Point&, Quantity);
    void take(double off, Quantity, const planner::Errors& scale);

    const model::Schedule whole_;
    const model::Schedule schedule_;
    const model::SiteCells cells_;
    const std::vector<model::Element> materials_; // of the timeline
    const model::ResponseRule rule_;
    const planner::Peaks scale_;
    const double stored_;
    const std::array<long long, REDUCED_MAPS> telling_; // planner::telling_outputs
    extended::Constants constants_;
    const model::DeepCells deep_;
    Extended stepper_;
    model::Timeline timeline_;
    model::References references_;
    std::vector<Point> points_;
    std::vector<extended::LaneCoefficients> lanes_;
    std::vector<std::array<long double, size_t(Quantity::deformation) + 1>> field_; // of each point, at the last field
    std::optional<model::Step> next_;                  // the step that advance() has not come to
    std::deque<Output> outputs_;                       // outputs that the run has not delivered yet
    std::array<model::Totals, REDUCED_MAPS> totals_{}; // at the last output that the run has delivered
    double error_ = 0; // the greatest |X - X_exact| so far, by the greatest |X_exact| of its quantity
};

// The witness of a run by a candidate, in some 4 to 32 cells or sites. Cells become the last of the schedule's points.
// Of a sum of loads only means and extremes are compared. Null for a run in double if long double has no more digits.
std::unique_ptr<Witness> witness_of(model::PreparedRun&, const Candidate&, const planner::Peaks&);

} // namespace dermis
