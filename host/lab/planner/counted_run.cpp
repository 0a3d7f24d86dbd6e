// SPDX-License-Identifier: MIT
#include "host/lab/planner/counted_run.hpp"

#include <algorithm>

namespace dermis::planner {
namespace {

using model::Element;
using model::Schedule;

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
double least_normal(double peak, const Rounding& by) {
    return peak > 0 ? (by.single ? 0x1p-150 : 0x1p-1074) / peak : 0;
}

// The same as load_of_frames() along a parabola. Its pressures are rounded where the feed has computed them; the kernel
// rounds their differences.
counted::Load load_of_parabola(const Schedule& schedule, const model::Step& step, double peak, const Rounding& by) {
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
        return least_normal(peak, by) + by.u * value(u) + 0x1p-49 * (value(u) + change + bow);
    };
    const double start = step.start, end = start + step.rise, led = start - step.before / h,
                 stored = by.single ? double(f32::least_stored()) : f64::least_stored(),
                 flushed = peak > 0 ? stored / peak : 0; // the earlier pressure, where the state holds it
    counted::Load load = counted::load({value(start), off(start), 0, &by}, {0, 0, 0, &by},
                                       {step.jump * from, step.jump * off(0), 0, &by});
    load.past.by = &by;
    if (change == 0 && bow == 0) return load; // equal frames are rounded alike, and differ by 0
    const auto run_off = [&](double u, double v) { return off(u) + off(v) + by.of(run(u, v)); };
    load.ds = {run(start, end), run_off(start, end), 0, &by};
    load.ds.value = std::min(load.ds.value, value(end) - value(start));
    load.past = {run(led, start), run_off(led, start) + flushed, 0, &by};
    return load;
}

// A number as the kernel gets it: rounded to float where the kernel is in float. known: its error before.
Counted stored(double x, double off, double known, const Rounding& by) {
    const double rounded = by.single ? double(float(x)) : x, shift = known + (rounded - x);
    if (!std::isfinite(rounded)) return {x, INFINITY, 0, &by};
    return by.bound ? Counted(x, off + std::abs(shift), 0, &by) : Counted(x, off, shift, &by);
}

// The load between frames of a cell with the greatest |pressure| `peak`, per unit of it. Only magnitudes of the frames
// and of their change are known.
counted::Load load_of_frames(const Schedule& schedule, const model::Step& step, double peak, const Rounding& by) {
    const Counted zero(0, 0, 0, &by);
    if (step.frame < 0) return counted::load(zero, zero, zero);
    const scene::Instant begin = frame_time(schedule, step.frame), next = frame_time(schedule, step.frame + 1);
    const auto share = [&](double of, const scene::Instant& first, const scene::Instant& last) { // made in double
        if (step.rise == 0) return stored(of, 0, 0, by);
        const long double exact =
            scene::difference<long double>(last, first) / scene::difference<long double>(next, begin);
        return stored(of, few * unit_of_reference * of + double(std::abs(of - exact)), 0, by);
    };
    const double from = std::min(of_frame(schedule.frame_peaks, step.frame, peak), 1.0);
    const double to = std::min(of_frame(schedule.frame_peaks, step.frame + 1, peak), 1.0);
    const double start = step.start, end = start + step.rise, least = least_normal(peak, by);
    const double change = step.rise == 0 ? 0 : std::min(from + to, of_frame(schedule.frame_changes, step.frame, peak));
    const auto whole = [](double x) { return x == std::floor(x); };
    const bool equal = change == 0 && whole(2 * start) && whole(2 * end); // from frame to frame: rounded alike
    const double off = 4 * least + by.u * (from + to) + by.of(change);
    const Counted changed = equal ? zero : Counted(change, off, 0, &by);
    const Known frame{.change = &changed};
    counted::Constants c;
    c.start = share(start, begin, step.begin);
    c.rise = share(step.rise, step.begin, step.end);
    c.jump = step.jump;
    counted::Load load = counted::load_between({from, least + by.u * from, 0, &by}, {0, 0, 0, &by, &frame}, c);
    load.s0.value = load.s0.size = (1 - start) * from + start * to;
    load.ds.value = std::min(load.ds.value, std::abs(1 - end) * from + end * to - load.s0.value);
    return load;
}

} // namespace

CountedRun::CountedRun(const Schedule& schedule, const std::vector<CountedMaterial>& materials,
                       const model::ResponseRule& rule, Method method, const model::Chain& chain, bool product)
    : schedule_(schedule), materials_(materials), rule_(rule), chain_(chain), elements_(elements_of(materials)),
      timeline_(schedule, elements_, rule, method), references_(schedule, elements_, rule),
      envelope_peak_(envelope_peak(references_.load(), schedule.load.envelope)),
      is_wave_(!schedule.framed && method == Method::exact && references_.load().wave()),
      kept_(materials.size() / chain.length), now_(kept_) {
    for (size_t i = 0; product && i < elements_.size(); i += chain.length)
        products_.emplace_back(chain, &elements_[i], schedule.time.duration);
    pressed_.shape = {.elements = chain.elements(), .spring = chain.spring, .rate = chain.spring && schedule.framed};
}

bool CountedRun::next() {
    while (timeline_.next(step_)) {
        if (step_.leads() || step_.impulse >= 0) continue; // they change neither strain nor integral
        measured_ = references_.take(step_);
        start_off_ = measured_ ? double(step_.start - references_.start(step_)) : 0;
        jump_off_ = measured_ ? double(step_.jump - references_.jump(step_)) : 0;
        pressed_.shape.previous = step_.parabolic;
        for (size_t i = 0; i < now_.size(); ++i) press(i, step_);
        if (step_.keep) {
            kept_.swap(now_);
            for (MeasuredCell& cell : products_) cell.keep();
        }
        if (step_.trace >= 0 || step_.field >= 0) return true;
    }
    return false;
}

// The load of a step, per unit of the map. Pressures that are held are as exact as the scene; others come from a few
// operations on the envelope's values.
counted::Load CountedRun::load_over(const model::Step& step, const CountedMaterial& m) {
    const Rounding& by = m.rounding;
    if (step.parabolic && step.rise != 0) return load_of_parabola(schedule_, step, m.peak, by);
    if (schedule_.framed) return load_of_frames(schedule_, step, m.peak, by);
    const bool held = step.rise == 0 || (step.forcing && step.forcing->holds());
    const bool computed = !held || schedule_.method != Method::exact, references = products_.empty();
    const double off = computed ? few * unit() * envelope_peak_ : 0;
    counted::Constants c;
    c.start = stored(step.start, off, references ? start_off_ : 0, by);
    c.rise = stored(step.rise, 0, 0, by);
    c.jump = stored(step.jump, step.jump != 0 ? 2 * off : 0, references ? jump_off_ : 0, by);
    return counted::load_of(Counted(1), c); // the rounding of the map is the same in all responses
}

MadeBy CountedRun::made_by(const model::Step& step) const {
    const double amplitude = is_wave_ && step.forcing ? std::abs(schedule_.load.envelope.amplitude) : 0;
    return {rule_, step.forcing.get(), schedule_.time.step, step.length, amplitude, unit()};
}

// Makes the coefficients of the cell whose first element is `first`, and its load.
void CountedRun::make_step(const model::Step& step, size_t first) {
    std::array<f64::Coefficients, scene::most_in_series> off, past{};
    std::array<extended::Coefficients, scene::most_in_series> past_references{};
    const size_t n = chain_.length;
    const MadeBy by = made_by(step);
    for (size_t e = 0; e < n; ++e) {
        const Element& m = elements_[first + e];
        k_[e] = step.coefficients_of(first + e, m, rule_);
        if (step.parabolic) past[e] = bend(k_[e], m, rule_, step.length, step.before);
        references_of_[e] = {};
        if (measured_ || step.parabolic) references_of_[e] = references_.coefficients(first + e, past_references[e]);
        off[e] = coefficient_errors(k_[e], m, by);
    }
    model::join_loads<f64>(k_.data(), n, chain_.spring, step.length);
    model::join_loads<f64>(off.data(), n, false, step.length);
    model::join_loads<extended>(references_of_.data(), n, chain_.spring, references_.length());
    model::join_loads<f64>(past.data(), n, chain_.spring, step.length);
    model::join_loads<extended>(past_references.data(), n, chain_.spring, references_.length());
    const Rounding& rounding = materials_[first].rounding;
    const auto put = [&](size_t at, const f64::Coefficients& k, const f64::Coefficients& beside,
                         const f64::Coefficients& known) {
        // Of n elements, whose shares of the load are added up; tests/kernels/coefficients_test.cpp measures fewer.
        const double units = (3.5 + double(n)) * by.unit;
#define COUNT(name) pressed_.k[at].name = stored(k.name, units * std::abs(k.name) + beside.name, known.name, rounding);
        COEFFICIENTS(COUNT)
#undef COUNT
        pressed_.k[at].E = stored(k.E, 0, known.E, rounding); // it is the element's
        pressed_.rounded_in_double[at] = f64::lanes_of(k);
    };
    for (size_t e = 0; e < n; ++e) {
        const size_t at = step.entries() * e;
        const bool compared = measured_ && products_.empty();
        put(at, k_[e], off[e], compared ? model::difference(k_[e], references_of_[e]) : f64::Coefficients{});
        if (step.parabolic) put(at + 1, past[e], {}, model::difference(past[e], past_references[e]));
    }
    pressed_.load = load_over(step, materials_[first]);
}

void CountedRun::press(size_t cell, const model::Step& step) {
    const size_t first = cell * chain_.length;
    make_step(step, first);
    planner::press(pressed_, materials_[first].rounding, kept_[cell], now_[cell]);
    for (size_t e = 0; step.after_bend > 0 && e < chain_.length; ++e)
        if (const Element& m = elements_[first + e]; !is_elastic(m)) add_bend(now_[cell], m, step);
    if (!products_.empty()) measure(cell, step);
}

// Steps the cell of a product as the run does, and once more by references.
void CountedRun::measure(size_t cell, const model::Step& step) {
    MeasuredCell& product = products_[cell];
    extended::Load exact = extended::load(step.start, step.rise, step.jump);
    if (measured_) {
        exact.s0 = references_.start(step);
        exact.sj = references_.jump(step);
    } else {
        std::transform(k_.begin(), k_.begin() + long(chain_.length), references_of_.begin(), model::rounded<extended>);
    }
    product.press(f64::load(step.start, step.rise, step.jump), k_.data(), exact, references_of_.data());
    if (!measured_ || !rule_.step_mean || std::ranges::any_of(elements_, scene::is_elastic)) return;
    // The mean acceleration is also the change of the rate over the step.
    const Counted &before = kept_[cell].step.motion.rate, &after = now_[cell].step.motion.rate;
    Counted& acceleration = now_[cell].step.motion.acceleration;
    const double length = double(references_.length()), off = (before.off + after.off) / length;
    if (!(off < acceleration.off)) return;
    acceleration = {(after.value - before.value) / length, off, 0, after.by};
    product.take_change_of_rate(references_.length());
}

// Adds the error of a step within which the load bends: the rate at its end comes from a pressure and a stress that
// cancel.
void CountedRun::add_bend(CountedCell& cell, const Element& m, const model::Step& step) const {
    const double z = z_of(m, step.after_bend);
    const double rate = strain_rate(m, (4 + 2 * z) * unit() * envelope_peak_ * std::exp(-z));
    cell.step.motion.rate.off += rate;
    cell.step.motion.acceleration.off += rate * (rule_.step_mean ? 1 / schedule_.time.step : z_of(m, 1));
}

} // namespace dermis::planner
