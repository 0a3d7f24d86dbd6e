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
    if (load.wave()) return std::abs(envelope.mean) + std::abs(envelope.amplitude);
    double peak = 0;
    for (const scene::Knot& k : load.knots()) peak = std::max({peak, std::abs(k.left), std::abs(k.right)});
    return peak;
}

// The rounding of a few operations, in units.
constexpr double few = 8;

// A magnitude of frame k, or the last one, per unit of pressure.
double of_frame(const std::vector<double>& magnitudes, long long k, double peak) {
    return peak == 0 ? 0.0 : magnitudes[std::min(size_t(k), magnitudes.size() - 1)] / peak;
}

// Where a number is no normal one, per unit of pressure.
double least_normal(double peak, const CountedArithmetic& as) {
    return peak > 0 ? (as.single ? 0x1p-150 : 0x1p-1074) / peak : 0;
}

// The same as load_of_frames() along a parabola. Its pressures are rounded where the feed has computed them; the kernel
// rounds their differences.
CountedLoad load_of_parabola(const Schedule& schedule, const plan::Step& step, double peak,
                             const CountedArithmetic& as) {
    const auto share = [&](const std::vector<double>& of, long long k) { // of a change up to 2
        return std::min(of_frame(of, k, peak), &of == &schedule.frame_peaks ? 1.0 : 2.0);
    };
    const long long k = step.frame;
    const scene::Instant begin = frame_time(schedule, k);
    const double h = frame_time(schedule, k + 1) - begin, rho = k > 0 ? (begin - frame_time(schedule, k - 1)) / h : 1;
    const double from = share(schedule.frame_peaks, k), to = share(schedule.frame_peaks, k + 1),
                 change = share(schedule.frame_changes, k),
                 bow = k > 0 ? (rho * change + share(schedule.frame_changes, k - 1)) / (rho * (1 + rho)) : 0;
    const auto value = [&](double u) { return std::abs(1 - u) * from + std::abs(u) * to + std::abs(u * u - u) * bow; };
    const auto run = [&](double u, double v) { return std::abs(v - u) * (change + std::abs(u + v - 1) * bow); };
    const auto off = [&](double u) {
        return least_normal(peak, as) + as.u * value(u) + 0x1p-49 * (value(u) + change + bow);
    };
    const double start = step.start, end = start + step.rise, led = start - step.before / h,
                 stored = as.single ? double(f32::least_stored()) : f64::least_stored(),
                 flushed = peak > 0 ? stored / peak : 0; // the earlier pressure, where the state holds it
    CountedLoad load{.s0 = {value(start), off(start)}, .sj = {step.jump * from, step.jump * off(0)}, .end = value(end)};
    if (change == 0 && bow == 0) return load; // equal frames are rounded alike, and differ by 0
    load.ds = {run(start, end), off(start) + off(end) + as.u * run(start, end)};
    load.past = {run(led, start), off(led) + off(start) + as.u * run(led, start) + flushed};
    return load;
}

// The load between frames of a cell with the greatest |pressure| `peak`, per unit of it. Only magnitudes of the frames
// and of their change are known. The change, its share (in float) and their product are each rounded.
CountedLoad load_of_frames(const Schedule& schedule, const plan::Step& step, double peak, const CountedArithmetic& as) {
    if (step.frame < 0) return {};
    const scene::Instant begin = frame_time(schedule, step.frame), next = frame_time(schedule, step.frame + 1);
    const auto share_off = [&](double share, const scene::Instant& first, const scene::Instant& last) { // in double
        if (step.rise == 0) return 0.0;
        const long double exact =
            scene::difference<long double>(last, first) / scene::difference<long double>(next, begin);
        return few * unit_of_reference * share + double(std::abs(share - exact));
    };
    const double from = std::min(of_frame(schedule.frame_peaks, step.frame, peak), 1.0);
    const double to = std::min(of_frame(schedule.frame_peaks, step.frame + 1, peak), 1.0);
    const double change = step.rise == 0 ? 0 : std::min(from + to, of_frame(schedule.frame_changes, step.frame, peak));
    const double start = step.start, end = start + step.rise, s0 = (1 - start) * from + start * to;
    const double u = as.u, least = least_normal(peak, as);
    const auto rounded = [&](double share, double share_off) {
        const double units = share == 1 ? 1 : as.single ? 3 : 2; // of the change, of the share and of their product
        return change * (units * u * share + share_off) + 2 * least;
    };
    const auto whole = [](double x) { return x == std::floor(x); };
    return {
        .s0 = {s0, least + u * s0 + (start == 0 ? 0 : rounded(start, share_off(start, begin, step.begin)) + u * s0)},
        .ds = change == 0 && whole(2 * start) && whole(2 * end)
                  ? Counted{} // from frame to frame: equal ones are rounded alike
                  : Counted{step.rise * change, 2 * least + u * step.rise * (from + to) +
                                                    rounded(step.rise, share_off(step.rise, step.begin, step.end))},
        .sj = {step.jump * from, step.jump * (least + u * from)},
        .end = std::abs(1 - end) * from + end * to};
}

} // namespace

CountedRun::CountedRun(const Schedule& schedule, const std::vector<CountedMaterial>& materials,
                       const plan::ResponseRule& rule, Method method, const plan::Chain& chain, bool product)
    : schedule_(schedule), materials_(materials), rule_(rule), chain_(chain), elements_(elements_of(materials)),
      timeline_(schedule, elements_, rule, method), references_(schedule, elements_, rule),
      envelope_peak_(envelope_peak(references_.load(), schedule.load.envelope)),
      is_wave_(!schedule.framed && method == Method::exact && references_.load().wave()), kept_(materials.size()),
      now_(materials.size()) {
    for (size_t i = 0; product && i < elements_.size(); i += chain.length)
        products_.emplace_back(chain, &elements_[i], schedule.time.duration);
}

bool CountedRun::next() {
    while (timeline_.next(step_)) {
        if (step_.leads() || step_.impulse >= 0) continue; // they change neither strain nor integral
        measured_ = references_.take(step_);
        for (size_t i = 0; i < materials_.size(); i += chain_.length) press(i, step_);
        if (step_.keep) {
            kept_ = now_;
            for (MeasuredCell& cell : products_) cell.keep();
        }
        if (step_.trace >= 0 || step_.field >= 0) return true;
    }
    return false;
}

// The load of a step, per unit of the map. Pressures that are held are as exact as the scene; others come from a few
// operations on the envelope's values.
CountedLoad CountedRun::load_over(const plan::Step& step, const CountedMaterial& m) const {
    if (step.bent && step.rise != 0) return load_of_parabola(schedule_, step, m.peak, m.arithmetic);
    if (schedule_.framed) return load_of_frames(schedule_, step, m.peak, m.arithmetic);
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
    std::array<CountedStep, scene::most_in_series> steps, pasts;
    std::array<f64::Coefficients, scene::most_in_series> k, cancelled{}, past{};
    std::array<extended::Coefficients, scene::most_in_series> references{}, past_references{};
    const CountedLoad load = load_over(step, materials_[first]);
    for (size_t e = 0; e < chain_.length; ++e) {
        const Element& m = materials_[first + e].element;
        k[e] = step.coefficients_of(first + e, m, rule_);
        if (step.bent) past[e] = bend(k[e], m, rule_, step.length, step.before);
        if (measured_ || step.bent) references[e] = references_.coefficients(first + e, past_references[e]);
        steps[e].load = load;
        steps[e].unit = unit();
        steps[e].z = is_elastic(m) ? 0 : z_of(m, schedule_.time.step);
        steps[e].spring = chain_.spring && e + 1 == chain_.length;
        if (!is_wave_ || !step.forcing) continue;
        const double amplitude = schedule_.load.envelope.amplitude;
        if (const auto& sine = step.forcing->sine)
            cancelled[e] = cancelled_under_sine(k[e], m, rule_, sine->w, amplitude, unit());
        else cancelled[e] = cancelled_under_window(m, rule_, step.forcing->segments, amplitude, step.length, unit());
    }
    for (size_t e = 0; e < chain_.length; ++e)
        add_of_elastic(cancelled[e], k[e], materials_[first + e].element, step.forcing.get(), unit());
    plan::join_loads<f64>(k.data(), chain_.length, chain_.spring, step.length);
    plan::join_loads<f64>(cancelled.data(), chain_.length, false, step.length);
    plan::join_loads<extended>(references.data(), chain_.length, chain_.spring, references_.length());
    plan::join_loads<f64>(past.data(), chain_.length, chain_.spring, step.length);
    plan::join_loads<extended>(past_references.data(), chain_.length, chain_.spring, references_.length());
    for (size_t e = 0; e < chain_.length; ++e) {
        steps[e].k = k[e];
        steps[e].cancelled = cancelled[e];
        if (measured_ && products_.empty()) steps[e].shift = plan::difference(k[e], references[e]);
        if (!step.bent) continue;
        pasts[e] = {.k = past[e], .shift = plan::difference(past[e], past_references[e]), .unit = unit(), .load = {}};
        steps[e].past = &pasts[e];
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
    if (!measured_ || !rule_.step_mean || std::ranges::any_of(materials_, elastic)) return;
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
