// SPDX-License-Identifier: MIT
#include "host/lab/planner/replacement.hpp"

#include "host/core/model/laplacian.hpp"
#include "host/lab/planner/counted_run.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::planner {
namespace {

using plan::Element;
using plan::PreparedSkin;
using plan::Schedule;

// The responses of one cell under unit pressure, and the error of each in double.
struct Signals {
    Errors value{}, off{};

    double greatest(size_t q) const { return std::abs(value[q]) + off[q]; }
    friend Signals operator-(const Signals& a, const Signals& b) {
        Signals difference;
        for (size_t q = 0; q < REDUCED_MAPS; ++q) {
            difference.value[q] = a.value[q] - b.value[q];
            difference.off[q] = a.off[q] + b.off[q] + 0x1p-53 * std::abs(difference.value[q]);
        }
        return difference;
    }
};

// Leaves out the elements that both chains have.
Difference difference(const Elements& a, Elements b) {
    Difference d;
    for (const Element& m : a) {
        const auto same = std::find(b.begin(), b.end(), m);
        if (same == b.end()) d.added.push_back(m);
        else b.erase(same);
    }
    d.removed = b;
    return d;
}

// Steps the responses of a difference of chains from output to output.
class DifferenceRun {
  public:
    DifferenceRun(const Schedule& schedule, const Difference& d, const plan::ResponseRule& rule)
        : added_(d.added.size()), materials_(counted(d)), run_(schedule, materials_, rule, Method::exact) {}

    bool next(bool impulses = false) { return run_.next(impulses); }
    bool at_impulse() const { return run_.at_impulse(); }

    Signals signals() const {
        Signals s;
        const std::vector<CountedCell>& cells = run_.cells();
        for (int q = 0; q < REDUCED_MAPS; ++q) {
            double magnitude = 0;
            double &value = s.value[size_t(q)], &off = s.off[size_t(q)];
            for (size_t i = 0; i < cells.size(); ++i) {
                const double x = cells[i].value(q);
                value += i < added_ ? x : -x;
                off += cells[i].error(q);
                magnitude += std::abs(x);
            }
            off += double(cells.size()) * 0x1p-53 * magnitude;
        }
        return s;
    }

  private:
    static std::vector<CountedMaterial> counted(const Difference& d) {
        const CountedArithmetic in_double{
            .u = 0x1p-53, .peak = 1, .single = false, .bound = false, .carried = 1, .flush = 0};
        std::vector<CountedMaterial> materials;
        for (const Elements& chain : {d.added, d.removed})
            for (const Element& m : chain) materials.push_back({m, in_double, 1});
        return materials;
    }

    const size_t added_;
    const std::vector<CountedMaterial> materials_;
    CountedRun run_;
};

// The greatest signals of a cell under unit pressure times the envelope; of outputs also the strain at impulses.
Greatest greatest_under_envelope(const Schedule& schedule, const Difference& d, const plan::ResponseRule& rule) {
    Greatest greatest;
    DifferenceRun run(schedule, d, rule);
    while (run.next(true)) {
        const Signals s = run.signals();
        raise(greatest.outputs[QUANTITY_STRAIN], s.greatest(QUANTITY_STRAIN));
        Errors& read = run.at_impulse() ? greatest.impulses : greatest.outputs;
        for (size_t q = 0; q < REDUCED_MAPS; ++q) raise(read[q], s.greatest(q));
    }
    return greatest;
}

// The same schedule under unit pressure times an envelope, in place of frames.
Schedule under(const Schedule& schedule, const Envelope& envelope) {
    Schedule s;
    s.time = schedule.time;
    s.outputs = schedule.outputs;
    s.load.envelope = envelope;
    return s;
}

double greatest_of(const std::vector<double>& values, size_t first, size_t last) {
    double greatest = 0;
    for (size_t i = first; i < std::min(last, values.size()); ++i) greatest = std::max(greatest, values[i]);
    return greatest;
}

// The greatest |signals| of a cell under frames of known magnitudes. Its pressure is p_0 times a step, and each change
// p_(k+1) - p_k times a ramp from frame k to the next; or each p_k times a hat, the ramp up to frame k less the ramp
// away from it. The signals of steps and ramps add up in the same two ways, and each way gives a bound.
class UnderFrames {
  public:
    UnderFrames(const Schedule& schedule, const Difference& d, const plan::ResponseRule& rule)
        : interval_(*schedule.load.interval), whole_(size_t(scene::steps_per_frame(interval_, schedule.time.step))),
          frames_(schedule.frame_peaks.size()), of_step_(under(schedule, {})), of_ramp_(under(schedule, ramp())),
          step_(of_step_, d, rule), ramp_(of_ramp_, d, rule), before_(std::min(whole_, size_t(schedule.outputs))),
          hats_(before_.size()), ramps_(before_.size()) {
        const std::vector<double>& peaks = schedule.frame_peaks;
        first_ = peaks.front();
        last_ = frames_ > 1 ? peaks.back() : 0;
        middle_ = greatest_of(peaks, 1, frames_ - 1);
        change_ = greatest_of(schedule.frame_changes, 0, frames_);
    }

    Errors greatest() {
        Errors all{};
        for (size_t n = 0; step_.next() && ramp_.next(); ++n) {
            const Signals step = step_.signals(), ramp = ramp_.signals(), hat = ramp - before_[n % whole_],
                          first = step - ramp;
            before_[n % whole_] = ramp;
            const bool last = frames_ > 1 && n > (frames_ - 2) * whole_;
            for (size_t q = 0; q < REDUCED_MAPS; ++q) {
                double &hats = hats_[n % whole_][q], &ramps = ramps_[n % whole_][q];
                ramps += ramp.greatest(q);
                raise(longest_[q], ramp.greatest(q));
                const double by_change = first_ * step.greatest(q) + change_ * ramps;
                double by_peak = first_ * (frames_ > 1 ? first : step).greatest(q);
                hats += hat.greatest(q);
                by_peak += middle_ * hats + (last ? last_ * longest_[q] : 0);
                raise(all[q], (1 + 0x1p-40) * std::min(by_change, by_peak)); // sums are rounded
            }
        }
        return all;
    }

  private:
    Envelope ramp() const {
        Envelope e;
        e.kind = Envelope::Kind::ramp;
        e.rise = interval_;
        return e;
    }

    const double interval_;
    const size_t whole_, frames_; // steps from frame to frame; frames
    const Schedule of_step_, of_ramp_;
    DifferenceRun step_, ramp_;
    std::vector<Signals> before_;      // the ramp's signals in the last `whole_` steps
    std::vector<Errors> hats_, ramps_; // sums of greatest signals at the steps before, a whole number of frames apart
    Errors longest_{};                 // the greatest of a ramp so far
    double first_, middle_, last_;     // greatest |pressure| of the first frame, of the frames between, of the last
    double change_;                    // greatest of a cell from frame to frame
};

} // namespace

ReplacementBound::ReplacementBound(const PreparedSkin& skin, const Schedule& schedule, const Peaks& peaks,
                                   std::optional<double> first_jump)
    : skin_(skin), schedule_(schedule), peaks_(peaks), first_jump_(first_jump),
      l_(std::abs(skin.constants.curvature_length)), exact_(greatest({skin.materials, {}})) {
    const Output& o = schedule.output;
    if (first_jump || !o.traces.empty() || !o.fields.empty())
        everywhere_ = magnitudes_of({.everything = true, .quantity = 0});
    for (const Site& site : skin.description.sites) {
        std::optional<Magnitudes>& of = at_sites_[size_t(site.type)];
        if (!of) of = magnitudes_of({.everything = false, .quantity = int(site.type)});
    }
}

Replacement ReplacementBound::of(const Elements& chain) const {
    Replacement r{.chain = chain};
    const Greatest off = greatest(difference(skin_.materials, chain));
    const auto bound = [&](size_t q, const Magnitudes& m) {
        if (q == QUANTITY_STRAIN) return m.peak * off.outputs[q];
        return error(exact_.outputs[q], off.outputs[q], off.outputs[QUANTITY_STRAIN], m);
    };
    for (size_t q = 0; q < REDUCED_MAPS; ++q) {
        if (everywhere_) r.cells[q] = bound(q, *everywhere_);
        if (at_sites_[q]) r.sites[q] = bound(q, *at_sites_[q]);
        if (!std::isfinite(r.cells[q]) || !std::isfinite(r.sites[q])) r.error = INFINITY;
    }
    const double strain = r.cells[QUANTITY_STRAIN];
    r.cells[size_t(Quantity::curvature)] = skin_.constants.bend * weight_of(skin_.stencil) * strain;
    r.cells[size_t(Quantity::deformation)] = skin_.constants.thickness * strain;
    Bounds cells{.error = r.cells, .throughout = {}, .greatest = {}},
        sites{.error = r.sites, .throughout = {}, .greatest = {}};
    cells.greatest.fill(INFINITY); // no output counts as exact
    sites.greatest.fill(INFINITY);
    const double stored = arithmetic_of(Precision::f64, false).stored;
    raise(r.error, worst_asked(skin_, schedule_, cells, sites, peaks_, stored).error);
    if (first_jump_) raise(r.error, impulse_error(off));
    return r;
}

Greatest ReplacementBound::greatest(const Difference& d) const {
    if (schedule_.framed) return {UnderFrames(schedule_, d, skin_.rule).greatest(), {}};
    return greatest_under_envelope(schedule_, d, skin_.rule);
}

Magnitudes ReplacementBound::magnitudes_of(const Read& read) const {
    const double weight = skin_.constants.bend * weight_of(skin_.stencil);
    Magnitudes m{.peak = 1, .rest = rest_peak(skin_, schedule_, !read.everything), .curved = weight};
    if (schedule_.framed) return m; // signals contain the frames' pressures
    const PressedMaterial pressed = pressed_materials(skin_, schedule_, read).front();
    const double peak = largest_of(schedule_.pressure);
    m.peak = pressed.peak;
    m.curved = std::min(weight * pressed.around, roughness_of(skin_, schedule_, peak).laplacian * peak);
    return m;
}

// A lower bound of the greatest impulse: the impulse of the first jump in the cell that is pressed most.
double ReplacementBound::greatest_impulse(int quantity) const {
    double of_unit = 0;
    for (const Element& m : skin_.materials) {
        if (quantity == QUANTITY_FA1 && is_elastic(m)) of_unit += final_strain(m, *first_jump_);
        if (quantity == QUANTITY_FA2 && !is_elastic(m)) of_unit += strain_rate(m, *first_jump_);
    }
    const size_t most = greatest_cell(schedule_.pressure);
    const int at = int(most), width = skin_.width();
    const double gain = 1 + skin_.constants.curvature_length * rest_curvature_at(skin_, {at % width, at / width});
    return (1 - 0x1p-40) * std::abs(schedule_.pressure[most] * of_unit * gain);
}

// The worst error of the impulses of the wanted responses, relative to the greatest of each.
double ReplacementBound::impulse_error(const Greatest& off) const {
    double worst = 0;
    for (int q : {QUANTITY_FA1, QUANTITY_FA2}) {
        const size_t i = size_t(q);
        if (!schedule_.wanted[i] || (exact_.impulses[i] == 0 && off.impulses[i] == 0)) continue;
        raise(worst, error(exact_.impulses[i], off.impulses[i], off.outputs[QUANTITY_STRAIN], *everywhere_) /
                         greatest_impulse(q));
    }
    return worst;
}

// The greatest error of X = x*(1 + l*C), where the signal x is off and so is the strain that C follows from.
double ReplacementBound::error(double x, double off, double strain_off, const Magnitudes& m) const {
    const double gain = 1 + l_ * (m.rest + m.curved * exact_.outputs[QUANTITY_STRAIN]);
    return m.peak * (off * gain + (x + off) * l_ * m.curved * strain_off);
}

} // namespace dermis::planner
