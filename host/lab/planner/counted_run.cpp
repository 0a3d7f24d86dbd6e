// SPDX-License-Identifier: MIT
#include "host/lab/planner/counted_run.hpp"

#include "host/lab/planner/coefficient_errors.hpp"

#include <algorithm>

namespace dermis::planner {
namespace {

using model::Element;
using model::Schedule;

// What errors of a state become in a step, which is linear. A kernel's terms cancel in the share of a sum that the step
// leaves, so these errors are carried beside the kernel's text, which meets a state without them.
struct Carried {
    explicit Carried(const CountedStep& step) {
        using State = std::array<f64::Sum, 4>;
        static constexpr State strain{f64::Sum{1, 0}}, integral{f64::Sum{0, 0}, f64::Sum{1, 0}};
        static const model::StateShape one;
        const auto of = [&](size_t e, const State& state) {
            return f64::step_of(model::SingleCell<f64>{one, step.in_double(e), state.data(), nullptr},
                                f64::load(0, 0, 0));
        };
        for (size_t e = 0; e < step.shape.elements; ++e) strains[e] = of(e, strain), kept[e] = strains[e].motion.strain;
        kept[step.shape.elements] = of(0, integral).integral;
    }

    std::array<f64::CellStep, scene::most_in_series> strains; // what a strain of 1 leads to
    std::array<double, scene::most_in_series + 1> kept;       // the share of each sum that the step leaves
};

// The cell for kernels/cell.h.
struct CellOfText {
    const CountedStep& step;
    const Rounding& by;
    const Carried& carried;
    const CountedCell& before;
    CountedCell& after; // its sums are set, and to the errors of strain and integral those that the text does not know
    const Known* known; // of each sum
    Known earlier;

    using Sum = counted::Sum;
    friend int elements_of(const CellOfText& c) { return int(c.step.shape.elements); }
    friend bool has_spring(const CellOfText& c) { return c.step.shape.spring; }
    friend bool has_rate(const CellOfText& c) { return c.step.shape.rate; }
    friend bool has_integral(const CellOfText&) { return true; }
    friend int is_compensated(const CellOfText& c) { return c.by.compensated; }
    friend bool has_past(const CellOfText& c) { return c.step.shape.previous; }
    friend const counted::LaneCoefficients& element_of(const CellOfText& c, int e) {
        return c.step.k[size_t((1 + c.step.shape.previous) * e)];
    }
    friend const counted::LaneCoefficients& past_of(const CellOfText& c, int e) { return c.step.k[size_t(2 * e + 1)]; }
    friend Sum sum_from(const CellOfText& c, int s) {
        const CountedSum& sum = c.before.sums[size_t(s)];
        return {Counted(sum.value, 0, sum.shift, &c.by, c.known + s), Counted(0, 0, 0, &c.by)};
    }
    friend Counted rate_from(const CellOfText& c) {
        const CountedSum& rate = c.before.sums[c.step.shape.elements + 1];
        return {rate.value, rate.off, rate.shift, &c.by};
    }
    friend Counted previous_from(const CellOfText& c) { return {0, 0, 0, &c.by, &c.earlier}; }
    friend void store_previous(const CellOfText&, const Counted&) {}
    friend void store_rate(const CellOfText& c, const Counted& rate) {
        c.after.sums[c.step.shape.elements + 1] = {c.by.bound ? rate.size : rate.value, rate.off, rate.shift};
    }
    friend void store(const CellOfText& c, int s, const Sum&, const Sum& sum) { c.take(size_t(s), sum.value); }

  private:
    // The rounding that stays in a sum x after a step. In a compensated sum: a small part of it, what is too small to
    // be carried, the step's rounding of what was lost before, and of what is lost now if the step exceeds the sum.
    double left(double size, const CountedSum& sum, double moved, double most_moved) const {
        const double most = std::abs(sum.value) + sum.off + std::abs(sum.shift), rounded = std::min(by.of(size), most);
        if (!by.compensated) return rounded;
        const double of_step = std::min(by.of(moved), most);
        return 2 * by.u * rounded + std::min(rounded, by.flush) + std::min(of_step, by.lost(std::abs(sum.value))) +
               (most_moved > std::abs(sum.value) ? of_step : 0);
    }

    void take(size_t s, const Counted& x) const {
        const CountedSum& sum = before.sums[s];
        const bool strain = s < step.shape.elements;
        const double size = std::abs(x.value), kept = carried.kept[s], taken = std::abs(1 - kept),
                     moved = by.bound ? x.size - std::abs(sum.value) : std::abs(x.value - sum.value);
        double off = (std::abs(kept) + 4 * by.u * taken) * sum.off + taken * by.lost(std::abs(sum.value)) +
                     left(size, sum, moved, moved + x.off + std::abs(x.shift - sum.shift));
        for (size_t e = 0; !strain && e < step.shape.elements; ++e)
            off += std::abs(carried.strains[e].integral) * error_of(e);
        const double flush = by.flushed(size, before.flushed ? x.off + off : 0);
        off += flush - by.flushed(x.size);
        after.flushed = after.flushed || flush > 0;
        after.sums[s] = {x.value, x.off + off, x.shift, strain && by.bound ? excess_after(s) : 0};
        (strain ? after.step.motion.strain : after.step.integral).off += off;
    }

    // Between frames: the greatest |pressure less an element's stress| at the step's end.
    double excess_after(size_t e) const {
        const f64::LaneCoefficients& k = *step.in_double(e);
        const double most = std::min(known[e].product->excess, step.load.s0.size + k.E * before.sums[e].value);
        return (std::abs(carried.kept[e]) + 0x1p-50) * most + (std::abs(1 - k.E * k.f) + 0x1p-50) * step.load.ds.size +
               (step.shape.previous ? k.E * std::abs((&k + 1)->f) * step.load.past.size : 0);
    }

  public:
    // The error of a strain at the step's start, as integral and rates take it.
    double error_of(size_t e) const {
        return (1 + 4 * by.u) * (before.sums[e].off + by.lost(std::abs(before.sums[e].value)));
    }
};

// Presses a cell for one step.
void press(const CountedStep& step, const Rounding& by, const CountedCell& before, CountedCell& after) {
    const Carried carried(step);
    after.step = {};
    after.strains = 0;
    after.flushed = false;
    std::array<Known, scene::most_in_series + 1> known, stresses;
    for (size_t i = 0; i <= step.shape.elements; ++i) {
        known[i] = {.sum = true, .product = &stresses[i]};
        if (by.bound) stresses[i].excess = before.sums[i].excess + step.load.sj.size;
    }
    const CellOfText cell{step, by, carried, before, after, known.data(), {.change = &step.load.past}};
    counted::CellStep of = counted::step_of(cell, step.load);
    of.motion.strain.off += after.step.motion.strain.off;
    of.integral.off += after.step.integral.off;
    for (size_t e = 0; e < step.shape.elements; ++e) {
        of.motion.rate.off += std::abs(carried.strains[e].motion.rate) * cell.error_of(e);
        of.motion.acceleration.off += std::abs(carried.strains[e].motion.acceleration) * cell.error_of(e);
        after.strains += std::abs(after.sums[e].value);
    }
    for (Counted* sum : {&of.motion.strain, &of.integral})
        sum->size = std::abs(sum->value); // their terms are not below 0
    after.step = of;
}

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

// Makes the coefficients of the cell whose first element is `first`, and its load.
void CountedRun::make_step(const model::Step& step, size_t first) {
    std::array<f64::Coefficients, scene::most_in_series> off, past{};
    std::array<extended::Coefficients, scene::most_in_series> past_references{};
    const size_t n = chain_.length;
    const double amplitude = is_wave_ && step.forcing ? std::abs(schedule_.load.envelope.amplitude) : 0;
    const MadeBy by{rule_, step.forcing.get(), schedule_.time.step, step.length, amplitude, unit()};
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
