// SPDX-License-Identifier: MIT
#include "host/lab/planner/counted_run.hpp"

#include <algorithm>

namespace dermis::planner {
namespace {

using plan::Element;
using plan::Schedule;

std::vector<Element> elements_of(const std::vector<CountedMaterial>& materials) {
    std::vector<Element> elements;
    for (const CountedMaterial& m : materials) elements.push_back(m.element);
    return elements;
}

// The greatest |pressure| under the envelope, per unit of the map.
double envelope_peak(const scene::Waveform& load, const Envelope& envelope) {
    if (load.sine()) return std::abs(envelope.mean) + std::abs(envelope.amplitude);
    double peak = 0;
    for (const scene::Knot& k : load.knots()) peak = std::max({peak, std::abs(k.left), std::abs(k.right)});
    return peak;
}

// The rounding of a few operations, in units.
constexpr double few = 8;

// The errors in double of a step's shares of the change between two frames.
struct OffShares {
    double start, rise;
};

// The load between frames of a cell with the greatest |pressure| `peak`, per unit of it. Only magnitudes of the frames
// and of their change are known. The change, its share (in float) and their product are each rounded.
CountedLoad load_of_frames(const Schedule& schedule, const plan::Step& step, const OffShares& off, double peak,
                           const CountedArithmetic& as) {
    const auto share = [&](const std::vector<double>& of, long long k) {
        return peak == 0 ? 0.0 : of[std::min(size_t(k), of.size() - 1)] / peak;
    };
    if (step.frame < 0) return {};
    const double from = std::min(share(schedule.frame_peaks, step.frame), 1.0);
    const double to = std::min(share(schedule.frame_peaks, step.frame + 1), 1.0);
    const double change = step.rise == 0 ? 0 : std::min(from + to, share(schedule.frame_changes, step.frame));
    const double start = step.start, end = start + step.rise, s0 = (1 - start) * from + start * to;
    const double u = as.u,
                 least = peak > 0 ? (as.single ? 0x1p-150 : 0x1p-1074) / peak : 0; // where a number is no normal one
    const auto rounded = [&](double share, double share_off) {
        const double units = share == 1 ? 1 : as.single ? 3 : 2; // of the change, of the share and of their product
        return change * (units * u * share + share_off) + 2 * least;
    };
    return {.s0 = {s0, least + u * s0 + (start == 0 ? 0 : rounded(start, off.start) + u * s0)},
            .ds = {step.rise * change, 2 * least + u * step.rise * (from + to) + rounded(step.rise, off.rise)},
            .sj = {step.jump * from, step.jump * (least + u * from)},
            .end = std::abs(1 - end) * from + end * to};
}

} // namespace

CountedRun::CountedRun(const Schedule& schedule, const std::vector<CountedMaterial>& materials,
                       const plan::ResponseRule& rule, Method method, const plan::Chain& chain, bool product)
    : schedule_(schedule), materials_(materials), rule_(rule), chain_(chain), elements_(elements_of(materials)),
      timeline_(schedule, elements_, rule, method), references_(schedule, elements_, rule),
      envelope_peak_(envelope_peak(references_.load(), schedule.load.envelope)), kept_(materials.size()),
      now_(materials.size()) {
    for (size_t i = 0; product && i < elements_.size(); i += chain.length)
        products_.emplace_back(chain, &elements_[i], schedule.time.duration);
    if (!schedule.framed && method == Method::exact && references_.load().sine())
        angular_frequency_ = references_.load().angular_frequency();
}

bool CountedRun::next(bool impulses) {
    while (timeline_.next(step_)) {
        measured_ = references_.take(step_);
        for (size_t i = 0; i < materials_.size(); i += chain_.length) press(i, step_);
        if (step_.keep) {
            kept_ = now_;
            for (MeasuredCell& cell : products_) cell.keep();
        }
        if (step_.trace >= 0 || step_.field >= 0 || (impulses && at_impulse())) return true;
    }
    return false;
}

// The load of a step, per unit of the map. Pressures that are held are as exact as the scene; others come from a few
// operations on the envelope's values.
CountedLoad CountedRun::load_over(const plan::Step& step, const CountedMaterial& m) const {
    if (schedule_.framed) {
        OffShares off{0, 0};
        if (step.rise != 0) {
            const scene::Instant from = timeline_.frame_time(step.frame), to = timeline_.frame_time(step.frame + 1);
            const auto share_off = [&](double share, const scene::Instant& first, const scene::Instant& last) {
                const long double exact =
                    scene::difference<long double>(last, first) / scene::difference<long double>(to, from);
                return few * unit_of_reference * share + double(std::abs(share - exact));
            };
            off = {share_off(step.start, from, step.begin), share_off(step.rise, step.begin, step.end)};
        }
        return load_of_frames(schedule_, step, off, m.peak, m.arithmetic);
    }
    const bool held = step.rise == 0 || (step.forcing && step.forcing->holds());
    const bool computed = !held || schedule_.method != Method::exact;
    const double off = computed ? few * unit() * envelope_peak_ : 0;
    CountedLoad load{.s0 = {step.start, off}, .ds = {step.rise, 0}, .sj = {step.jump, step.jump != 0 ? 2 * off : 0}};
    if (!measured_ || !products_.empty()) return load;
    load.s0.shift = double(step.start - references_.start(step));
    load.sj.shift = double(step.jump - references_.jump(step));
    return load;
}

void CountedRun::press(size_t first, const plan::Step& step) {
    std::array<CountedStep, scene::most_in_series> steps;
    std::array<f64::Coefficients, scene::most_in_series> k, cancelled{};
    std::array<extended::Coefficients, scene::most_in_series> references;
    const CountedLoad load = load_over(step, materials_[first]);
    for (size_t e = 0; e < chain_.length; ++e) {
        const Element& m = materials_[first + e].element;
        k[e] = step.coefficients_of(first + e, m, rule_);
        references[e] = references_.coefficients(first + e);
        steps[e].load = load;
        steps[e].unit = unit();
        steps[e].z = is_elastic(m) ? 0 : z_of(m, schedule_.time.step);
        steps[e].spring = chain_.spring && e + 1 == chain_.length;
        if (angular_frequency_ && step.rise != 0)
            cancelled[e] =
                cancelled_under_sine(k[e], m, rule_, *angular_frequency_, schedule_.load.envelope.amplitude, unit());
    }
    for (size_t e = 0; e < chain_.length; ++e)
        add_of_elastic(cancelled[e], k[e], materials_[first + e].element, step.forcing.get(), unit());
    plan::join_loads<f64>(k.data(), chain_.length, chain_.spring, step.length);
    plan::join_loads<f64>(cancelled.data(), chain_.length, false, step.length);
    plan::join_loads<extended>(references.data(), chain_.length, chain_.spring, references_.length());
    for (size_t e = 0; e < chain_.length; ++e) {
        steps[e].k = k[e];
        steps[e].cancelled = cancelled[e];
        if (measured_ && products_.empty()) steps[e].shift = plan::difference(k[e], references[e]);
    }
    materials_[first].arithmetic.press(steps.data(), chain_.length, &kept_[first], &now_[first]);
    for (size_t e = 0; step.after_bend > 0 && e < chain_.length; ++e)
        if (const Element& m = materials_[first + e].element; !is_elastic(m)) add_bend(now_[first], m, step);
    if (!products_.empty()) measure(first, step, k.data(), references.data());
}

// Steps the cell of a product as the run does, and once more by references.
void CountedRun::measure(size_t first, const plan::Step& step, const f64::Coefficients* k,
                         extended::Coefficients* references) {
    MeasuredCell& cell = products_[first / chain_.length];
    extended::Load exact = extended::load(step.start, step.rise, step.jump);
    if (measured_) {
        exact.s0 = references_.start(step);
        exact.sj = references_.jump(step);
    } else {
        std::transform(k, k + chain_.length, references, plan::rounded<extended>);
    }
    cell.press(f64::load(step.start, step.rise, step.jump), k, exact, references);
    const auto elastic = [](const CountedMaterial& m) { return is_elastic(m.element); };
    if (!measured_ || !rule_.step_mean || std::any_of(materials_.begin(), materials_.end(), elastic)) return;
    // The mean acceleration is also the change of the rate over the step.
    const Counted &before = kept_[first].rate, &after = now_[first].rate;
    const double length = double(references_.length()), off = (before.off + after.off) / length;
    if (!(off < now_[first].acceleration.off)) return;
    now_[first].acceleration = {(after.value - before.value) / length, off};
    cell.take_change_of_rate(references_.length());
}

// Adds the error of a step within which the load bends: the rate at its end comes from a pressure and a stress that
// cancel.
void CountedRun::add_bend(CountedCell& cell, const Element& m, const plan::Step& step) const {
    const double z = z_of(m, step.after_bend);
    const double rate = strain_rate(m, (4 + 2 * z) * unit() * envelope_peak_ * std::exp(-z));
    cell.rate.off += rate;
    cell.acceleration.off += rate * (rule_.step_mean ? 1 / schedule_.time.step : z_of(m, 1));
}

} // namespace dermis::planner
