// SPDX-License-Identifier: MIT
#include "host/lab/run/witness.hpp"

#include "host/lab/planner/magnitudes.hpp"
#include "host/lab/schedule/cell.hpp"

#include <algorithm>
#include <cmath>

namespace dermis {
namespace {

constexpr long long most_outputs = 64; // under an envelope

std::vector<Cell> places_of(const std::vector<WitnessCell>& cells) {
    std::vector<Cell> places;
    for (const WitnessCell& c : cells) places.push_back(c.cell);
    return places;
}

std::vector<int> quantities_of(const std::vector<WitnessCell>& cells) {
    std::vector<int> quantities;
    for (const WitnessCell& c : cells) quantities.push_back(c.quantity);
    return quantities;
}

// Under frames a witness takes every output.
plan::Schedule outputs_of(const plan::Schedule& schedule) {
    if (schedule.framed) return schedule;
    return with_fewer_outputs(schedule, most_outputs);
}

// Cells that show most of a run's error, as many as a fiftieth of the run's time allows, 4 to 32. The last of the
// schedule's points then are the chosen cells that are no sites.
std::vector<WitnessCell> witness_cells(const plan::PreparedSkin& skin, plan::Schedule& schedule,
                                       const Candidate& taken) {
    constexpr double share = 1.0 / 50, step_of_cell = 2e-6; // s: of a cell and those that its stencil reads
    const double steps = schedule.framed ? double(taken.steps) : 64, cost = step_of_cell * double(skin.chain.length);
    const size_t count = size_t(std::clamp(share * taken.seconds / (steps * cost), 4.0, 32.0));
    std::vector<WitnessCell> chosen;
    const std::vector<Site>& sites = skin.description.sites;
    const size_t probes = schedule.output.probes.size(), of_sites = std::min(sites.size(), count);
    for (size_t i = 0; i < of_sites; ++i) {
        const size_t k = i * sites.size() / of_sites;
        chosen.push_back({.cell = sites[k].cell, .quantity = int(sites[k].type), .column = probes + k});
    }
    if (schedule.output.traces.empty() && schedule.output.fields.empty()) return chosen;
    const std::vector<Cell> cells = planner::telling_cells(skin, schedule);
    for (size_t i = 0; i < std::min(cells.size(), count); ++i) { // half of them from all over
        const size_t k = i % 2 == 0 ? i / 2 : (i + 1) * (cells.size() - 1) / count;
        chosen.push_back({.cell = cells[k], .quantity = WitnessCell::traced, .column = schedule.points.size()});
        schedule.points.push_back(cells[k]);
    }
    return chosen;
}

} // namespace

Witness::Witness(const plan::PreparedSkin& skin, const plan::Schedule& schedule, const std::vector<WitnessCell>& cells,
                 const planner::Peaks& scale, double stored)
    : whole_(schedule), schedule_(outputs_of(schedule)), cells_(skin, pressed_cells(whole_), places_of(cells)),
      materials_(schedule.framed && !schedule.modes.empty() ? elements_of(skin, schedule) : cells_.materials),
      rule_(skin.rule), scale_(scale), stored_(stored),
      constants_(plan::constants_of<extended>(skin, schedule.pressed)),
      deep_(skin, schedule_, cells_, quantities_of(cells)), stepper_(skin, schedule_, cells_, deep_.places),
      timeline_(schedule_, materials_, rule_, Method::exact), references_(schedule_, materials_, rule_),
      lanes_(materials_.size() * (1 + schedule.bent())) {
    const plan::PressedCells pressed = pressed_cells(whole_);
    for (const WitnessCell& c : cells)
        points_.push_back({.of = c,
                           .number = skin.number_of(c.cell),
                           .at = {skin, cells_, c.cell},
                           .pressed = ever_pressed(pressed, skin.number_of(c.cell), skin.width()),
                           .deep = deep_.of_point[points_.size()]});
    field_.resize(points_.size());
}

void Witness::advance(scene::Instant end) {
    for (bool first = true;; first = false) {
        if (!next_ && !timeline_.next(next_.emplace())) return next_.reset();
        const bool impulse = next_->impulse >= 0; // these come before the fields that precede them
        if (!impulse && (end < next_->end || (next_->leads() && !first))) return; // before its frames are given
        if (!impulse) press(*next_);
        next_.reset();
    }
}

void Witness::press(const plan::Step& step) {
    const bool measured = references_.take(step);
    std::array<extended::Coefficients, scene::most_in_series> k, past{};
    auto lanes = lanes_.begin();
    const size_t length = cells_.chain.length;
    for (size_t i = 0; i < materials_.size(); i += length) {
        for (size_t e = 0; e < length; ++e)
            k[e] = measured ? references_.coefficients(i + e, past[e])
                            : plan::rounded<extended>(step.coefficients_of(i + e, materials_[i + e], rule_));
        for (auto* joined : {&k, &past})
            plan::join_loads<extended>(joined->data(), length, cells_.chain.spring,
                                       measured ? references_.length() : (long double)step.length);
        for (size_t e = 0; e < length; ++e) {
            *lanes++ = extended::lanes_of(k[e]);
            if (step.bent) *lanes++ = extended::lanes_of(past[e]);
        }
    }
    constants_.start = step.constant_start();
    constants_.rise = step.constant_rise();
    constants_.jump = step.jump;
    if (schedule_.framed && !step.bent && step.frame >= 0 && step.rise != 0) {
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

// Under an envelope FA2 as a mean over a step is left out: steps here are longer, and far beyond the retardation time a
// mean is the small difference of two large rates, in long double too.
bool Witness::knows(Quantity q) const {
    return q <= Quantity::curvature &&
           !(!schedule_.framed && q < Quantity::curvature && schedule_.follows[size_t(q)]) &&
           !(q == Quantity::fa2 && rule_.step_mean && !schedule_.framed);
}

bool Witness::compares(const Point& p, Quantity q) const {
    if (!knows(q)) return false;
    if (p.of.quantity != WitnessCell::traced) return int(q) == p.of.quantity;
    const std::vector<Quantity>& traces = whole_.output.traces;
    return std::find(traces.begin(), traces.end(), q) != traces.end();
}

long double Witness::value(const Point& p, Quantity q) const {
    if (p.pressed || p.deep[size_t(q)]) return stepper_.value(p.at, q, p.deep[size_t(q)], constants_, lanes_.data());
    return q == Quantity::curvature ? p.at.rest_curvature : 0;
}

void Witness::compare(const plan::Step& step, const plan::Sample& sample) {
    if (step.trace < 0 || outputs_.empty() || outputs_.front().row != step.trace) return;
    const std::vector<long double> values = std::move(outputs_.front().values);
    outputs_.pop_front();
    auto exact = values.begin();
    for (const Point& p : points_)
        for (size_t q = 0; q < REDUCED_MAPS; ++q)
            if (compares(p, Quantity(q)))
                take(sample.points[q * whole_.points.size() + p.of.column], *exact++, p, Quantity(q));
}

void Witness::compare(Quantity q, const std::vector<double>& map) {
    if (!knows(q)) return;
    for (size_t i = 0; i < points_.size(); ++i)
        if (const WitnessCell& of = points_[i].of; of.quantity == WitnessCell::traced)
            take(map[points_[i].number], field_[i][size_t(q)], points_[i], q);
}

void Witness::take(double x, long double exact, const Point& p, Quantity q) {
    const double off = double(std::abs((long double)x - exact));
    const double gain = double(std::max(std::abs(constants_.gain_plus), std::abs(constants_.gain_minus)));
    const planner::Errors& scale = p.of.quantity == WitnessCell::traced ? scale_.all : scale_.sites;
    const double greatest = scale[size_t(q)] * (q == Quantity::fa2 ? gain : 1);
    if (off <= 5 * stored_ && greatest <= stored_) return; // an output that is 0 throughout
    const double error = off / std::max(greatest, stored_);
    error_ = std::isnan(error) ? INFINITY : std::max(error_, error);
}

std::unique_ptr<Witness> witness_of(plan::PreparedRun& run, const Candidate& taken, const planner::Peaks& peaks) {
    const bool frames_of_baseline = run.schedule.framed && run.schedule.method != Method::exact;
    if (run.schedule.method == Method::published || frames_of_baseline || !run.schedule.others.empty()) return nullptr;
    const std::vector<WitnessCell> cells = witness_cells(run.skin, run.schedule, taken);
    const Precision precision = taken.model == Model::march ? taken.precision : Precision::f64;
    return std::make_unique<Witness>(run.skin, run.schedule, cells, peaks,
                                     planner::arithmetic_of(precision, false).stored);
}

long long most_strained_output(const plan::PreparedSkin& skin, const plan::Schedule& schedule) {
    if (schedule.framed) {
        const std::vector<double>& peaks = schedule.frame_peaks;
        const double frame = double(std::ranges::max_element(peaks) - peaks.begin());
        const double output = std::ceil(frame * *schedule.load.interval / schedule.time.step);
        return std::min(static_cast<long long>(std::min(output, 1e18)), schedule.outputs - 1);
    }
    const plan::Schedule few = with_fewer_outputs(schedule, 512);
    const size_t most = planner::greatest_cell(schedule.pressure);
    const auto first = skin.materials.begin() + std::ptrdiff_t(skin.material_at(most));
    const std::vector<plan::Element> elements(first, first + std::ptrdiff_t(skin.chain.length));
    plan::ProductCell<f64> cell(skin.chain, elements.data(), schedule.time.duration);
    std::vector<f64::Coefficients> table;
    plan::Timeline timeline(few, elements, skin.rule, few.every == 1 ? schedule.method : Method::exact);
    double greatest = 0;
    long long output = 0;
    for (plan::Step step; timeline.next(step);) {
        if (!step.keep) continue;
        plan::fill_table<f64>(step, elements, skin.chain, skin.rule, table);
        cell.press(f64::load(step.start, step.rise, step.jump), table.data());
        cell.keep();
        const double strain = std::abs(cell.signal(QUANTITY_STRAIN));
        if (strain > greatest && step.trace >= 0) greatest = strain, output = step.trace * few.every;
    }
    return output;
}

} // namespace dermis
