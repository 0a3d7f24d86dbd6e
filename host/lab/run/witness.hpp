// SPDX-License-Identifier: MIT
// Cells that are computed beside a run in long double, by steps of their own: the run's error there is measured, not
// bounded.
// So is that of means and extremes, by those of the run's own maps.
#pragma once

#include "dermis/run.hpp"
#include "host/lab/march/stepper.hpp"
#include "host/lab/planner/bound.hpp"
#include "host/lab/planner/magnitudes.hpp"
#include "host/lab/reduced/site_stepper.hpp"
#include "host/lab/schedule/references.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>

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
    Witness(const model::PreparedSkin& skin, const model::Schedule& schedule, const std::vector<WitnessCell>& cells,
            const planner::Peaks& scale, double stored)
        : whole_(schedule), schedule_(schedule.framed ? schedule : with_fewer_outputs(schedule, 64)),
          cells_(skin, {.box = {0, skin.height(), 0, skin.tiles}}, each(cells, &WitnessCell::cell)), // those around too
          materials_(schedule.framed && !schedule.modes.empty() ? elements_of(skin, schedule) : cells_.materials),
          rule_(skin.rule), scale_(scale), stored_(stored), telling_(planner::telling_outputs(skin, schedule)),
          constants_(model::constants_of<extended>(skin, schedule.pressed)),
          deep_(skin, schedule_, cells_, each(cells, &WitnessCell::quantity)),
          stepper_(skin, schedule_, cells_, deep_.places), timeline_(schedule_, materials_, rule_, Method::exact),
          references_(schedule_, materials_, rule_), lanes_(materials_.size() * (1 + schedule.parabolic())) {
        for (const WitnessCell& c : cells)
            points_.push_back({.of = c,
                               .number = skin.number_of(c.cell),
                               .at = {skin, cells_, c.cell},
                               .surface = (long double)skin.heights[skin.number_of(c.cell)] * skin.relief,
                               .deep = deep_.of_point[points_.size()]});
        field_.resize(points_.size());
    }

    void frame(const std::vector<double>& pressure) { stepper_.frame(pressure); } // as Stepper::frame
    // Takes all steps that end at `end` or before. To be called before the run takes its own step to that instant.
    void advance(scene::Instant end) {
        for (bool first = true; !points_.empty(); first = false) {
            if (!next_ && !timeline_.next(next_.emplace())) return next_.reset();
            const bool impulse = next_->impulse >= 0; // these come before the fields that precede them
            if (!impulse && (end < next_->end || (next_->leads() && !first))) return; // before its frames are given
            if (!impulse) press(*next_);
            next_.reset();
        }
    }
    // Compares an output of the run; outputs come in order, perhaps some steps later.
    void compare(const model::Step& step, const model::Sample& sample) {
        if (step.trace >= 0) totals_ = sample.totals;
        if (step.trace < 0 || outputs_.empty() || outputs_.front().row != step.trace) return;
        const std::vector<long double> values = std::move(outputs_.front().values);
        outputs_.pop_front();
        auto exact = values.begin();
        for (Point& p : points_)
            for (size_t q = 0; q < REDUCED_MAPS; ++q)
                if (compares(p, Quantity(q)))
                    take(sample.points[q * whole_.points.size() + p.of.column], *exact++, p, Quantity(q));
    }
    // Compares a field of the run at its last instant, width*height.
    void compare(Quantity q, const std::vector<double>& map) {
        if (!knows(q)) return;
        for (size_t i = 0; i < points_.size(); ++i)
            if (const WitnessCell& of = points_[i].of; of.quantity == WitnessCell::traced)
                take(map[points_[i].number], field_[i][size_t(q)], points_[i], q);
    }
    // Compares means and extremes at the outputs where a trace is greatest. To be called after each step of the run.
    // Where totals differ from those of the run's map, they or a value of the map are off by half of it or more.
    void read(const model::Step& step, model::Stepper& run) {
        std::vector<std::vector<double>> map;
        for (Quantity q : whole_.output.traces) {
            if (step.trace < 0 || step.trace != telling_[size_t(q)]) continue;
            run.read({q}, map);
            const auto [least, greatest] = std::ranges::minmax(map[0]);
            const long double mean = std::accumulate(map[0].begin(), map[0].end(), 0.0L) / (long double)map[0].size();
            const model::Totals& given = totals_[size_t(q)];
            take(std::abs(given.mean - double(mean)) / 2, q, scale_.all);
            if (!whole_.output.extremes) continue;
            take(std::max(std::abs(given.min - least), std::abs(given.max - greatest)) / 2, q, scale_.all);
        }
    }
    // Sets measured_error, measured_cells and unmeasured, after the last output.
    void tell(Result& result) const {
        for (const Point& p : points_)
            result.measured_cells += p.compared && (whole_.pressure[p.number] != 0 || std::ranges::max(p.deep) > 0);
        if (result.measured_cells > 0 || error_ > 0) result.measured_error = error_;
        const auto add = [&](const std::string& name) {
            (result.unmeasured += result.unmeasured.empty() ? "" : ", ") += name;
        };
        for (size_t q = 0; q < REDUCED_MAPS; ++q)
            if (whole_.wanted[q] && !knows(Quantity(q))) add(name(Quantity(q)) + std::string(" in cells"));
        if (!result.impulses.empty()) add("impulses");
    }

  private:
    template <class T> static std::vector<T> each(const std::vector<WitnessCell>& cells, T WitnessCell::*of) {
        std::vector<T> all;
        for (const WitnessCell& c : cells) all.push_back(c.*of);
        return all;
    }

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

    void press(const model::Step& step) {
        const bool measured = references_.take(step);
        std::array<extended::Coefficients, scene::most_in_series> k, past{};
        auto lanes = lanes_.begin();
        const size_t length = cells_.chain.length;
        for (size_t i = 0; i < materials_.size(); i += length) {
            for (size_t e = 0; e < length; ++e)
                k[e] = measured ? references_.coefficients(i + e, past[e])
                                : model::rounded<extended>(step.coefficients_of(i + e, materials_[i + e], rule_));
            for (auto* joined : {&k, &past})
                model::join_loads<extended>(joined->data(), length, cells_.chain.spring,
                                            measured ? references_.length() : (long double)step.length);
            for (size_t e = 0; e < length; ++e) {
                *lanes++ = extended::lanes_of(k[e]);
                if (step.parabolic) *lanes++ = extended::lanes_of(past[e]);
            }
        }
        constants_.start = step.constant_start();
        constants_.rise = step.constant_rise();
        constants_.jump = step.jump;
        if (schedule_.framed && !step.parabolic && step.frame >= 0 && step.rise != 0) {
            const scene::Instant from = timeline_.frame_time(step.frame), to = timeline_.frame_time(step.frame + 1);
            const long double interval = scene::difference<long double>(to, from);
            constants_.start = scene::difference<long double>(step.begin, from) / interval;
            constants_.rise = scene::difference<long double>(step.end, step.begin) / interval;
        } else if (measured && !schedule_.framed) {
            constants_.start = references_.start(step);
            constants_.jump = references_.jump(step);
        }
        stepper_.advance(constants_, lanes_.data(), 0, stepper_.size());
        if (step.trace >= 0) {
            Output& output = outputs_.emplace_back(Output{.row = step.trace * schedule_.every, .values = {}});
            for (const Point& p : points_)
                for (int q = 0; q < REDUCED_MAPS; ++q)
                    if (compares(p, Quantity(q))) output.values.push_back(value(p, Quantity(q)));
        }
        if (step.field >= 0)
            for (size_t i = 0; i < points_.size(); ++i)
                for (size_t q = 0; q < field_[i].size(); ++q) field_[i][q] = value(points_[i], Quantity(q));
        if (step.keep) stepper_.keep();
    }
    long double value(const Point& p, Quantity q) const {
        const auto at = [&](Quantity of, size_t deep) {
            return stepper_.value(p.at, of, deep, constants_, lanes_.data());
        };
        if (q == Quantity::deformation) return p.surface - constants_.thickness * at(Quantity::strain, 0);
        return at(q, p.deep[size_t(q)]);
    }
    // Under an envelope FA2 as a mean over a step is left out: steps here are longer, and far beyond the retardation
    // time a mean is the small difference of two large rates, in long double too.
    bool knows(Quantity q) const {
        return schedule_.others.empty() &&
               !(!schedule_.framed && q < Quantity::curvature && schedule_.follows[size_t(q)]) &&
               !(q == Quantity::fa2 && rule_.step_mean && !schedule_.framed);
    }
    bool compares(const Point& p, Quantity q) const {
        if (!knows(q)) return false;
        if (p.of.quantity != WitnessCell::traced) return int(q) == p.of.quantity;
        const std::vector<Quantity>& traces = whole_.output.traces;
        return std::find(traces.begin(), traces.end(), q) != traces.end();
    }
    void take(double x, long double exact, Point& p, Quantity q) {
        p.compared = true;
        take(double(std::abs((long double)x - exact)), q,
             p.of.quantity == WitnessCell::traced ? scale_.all : scale_.sites);
    }
    void take(double off, Quantity q, const planner::Errors& scale) {
        const double gain = double(std::max(std::abs(constants_.gain_plus), std::abs(constants_.gain_minus)));
        const double greatest = scale[size_t(q)] * (q == Quantity::fa2 ? gain : 1);
        if (off <= 5 * stored_ && greatest <= stored_) return; // an output that is 0 throughout
        const double error = off / std::max(greatest, stored_);
        error_ = std::isnan(error) ? INFINITY : std::max(error_, error);
    }

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

// Cells that show most of a run's error, as many as a fiftieth of the run's time allows, 4 to 32. The last of the
// schedule's points then are the chosen cells that are no sites.
inline std::vector<WitnessCell> witness_cells(const model::PreparedSkin& skin, model::Schedule& schedule,
                                              const Candidate& taken) {
    constexpr double share = 1.0 / 50, step_of_cell = 2e-6; // s: of a cell and those that its stencil reads
    const double steps = schedule.framed ? double(taken.steps) : 64,
                 sums = schedule.framed && schedule.spreads() ? 4e-9 * double(skin.cells()) : 0, // s: at depths
        cost = step_of_cell * double(skin.chain.length) + sums;
    const size_t count = size_t(std::clamp(share * taken.seconds / (steps * cost), 4.0, 32.0));
    std::vector<WitnessCell> chosen;
    if (!schedule.others.empty()) return chosen; // no cell of a sum is stepped
    const std::vector<Site>& sites = skin.description.sites;
    const std::vector<size_t> at = planner::telling_sites(skin, schedule);
    for (size_t i = 0; i < std::min(count, at.size()); ++i)
        chosen.push_back({sites[at[i]].cell, int(sites[at[i]].type), schedule.output.probes.size() + at[i]});
    if (schedule.output.traces.empty() && schedule.output.fields.empty()) return chosen;
    schedule.keeps_maps = true; // for means and extremes
    const std::vector<Cell> cells = planner::telling_cells(skin, schedule);
    for (size_t i = 0; i < std::min(count, cells.size()); ++i) {
        chosen.push_back({cells[i], WitnessCell::traced, schedule.points.size()});
        schedule.points.push_back(cells[i]);
    }
    return chosen;
}

// The witness of a run by a candidate, in some 4 to 32 cells or sites. Cells become the last of the schedule's points.
// Of a sum of loads only means and extremes are compared. Null for a run in double if long double has no more digits.
inline std::unique_ptr<Witness> witness_of(model::PreparedRun& run, const Candidate& taken,
                                           const planner::Peaks& peaks) {
    const Precision precision = taken.model == Model::march ? taken.precision : Precision::f64;
    if (precision == Precision::f64 && std::numeric_limits<long double>::digits == 53) return nullptr;
    const std::vector<WitnessCell> cells = witness_cells(run.skin, run.schedule, taken);
    return std::make_unique<Witness>(run.skin, run.schedule, cells, peaks,
                                     planner::arithmetic_of(precision, false).stored);
}

} // namespace dermis
