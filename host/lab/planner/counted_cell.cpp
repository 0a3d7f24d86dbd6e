// SPDX-License-Identifier: MIT
#include "host/lab/planner/counted_cell.hpp"

#include <optional>

namespace dermis::planner {
namespace {

using StateInDouble = std::array<f64::Sum, scene::most_in_series + 3>;

// What a step leads to from a state and a load, by the kernels in double. The step is linear.
f64::CellStep stepped(const plan::StateShape& shape, const f64::LaneCoefficients* k, const StateInDouble& before,
                      const f64::Load& load, StateInDouble* after = nullptr) {
    return f64::step_of(plan::SingleCell<f64>{shape, k, before.data(), after ? after->data() : nullptr}, load);
}

// What errors of a state become. A kernel's terms cancel in the share of a sum that a step leaves, so these errors are
// carried beside the kernel's text, which meets a state without them.
struct Carried {
    explicit Carried(const CountedStep& step) {
        static constexpr StateInDouble strain{f64::Sum{1, 0}}, integral{f64::Sum{0, 0}, f64::Sum{1, 0}};
        const auto of = [&](size_t e, const StateInDouble& state) {
            return stepped({}, &step.in_double[(1 + step.shape.previous) * e], state, f64::load(0, 0, 0));
        };
        for (size_t e = 0; e < step.shape.elements; ++e) strains[e] = of(e, strain), kept[e] = strains[e].motion.strain;
        kept[step.shape.elements] = of(0, integral).integral;
    }

    std::array<f64::CellStep, scene::most_in_series> strains; // of each
    std::array<double, scene::most_in_series + 1> kept;       // the share of each sum that the step leaves
};

// Between frames: the greatest magnitudes of what a step leads to, from those of what it starts from. In the kernel's
// text terms are magnitudes too, and would add up where they cancel in a sum of the state.
class Greatest {
  public:
    Greatest(const CountedStep& step, const Carried& carried, const CountedCell& before)
        : step_(step), carried_(carried), sums_(before.sums) {
        const auto of = [&](double s0, double ds, double earlier, StateInDouble& sums) {
            StateInDouble rest{};
            rest[step.shape.elements + 2].value = earlier;
            return stepped(step.shape, step.in_double.data(), rest, f64::load(s0, ds, 0), &sums).motion.strain;
        };
        strain_of_start_ = of(1, 0, 1, start_);
        strain_of_change_ = of(0, 1, 0, change_);
        if (step.shape.previous) strain_of_past_ = of(0, 0, -1, past_);
    }

    double strain() const {
        double most = of_load(strain_of_start_, strain_of_change_, strain_of_past_);
        for (size_t e = 0; e < step_.shape.elements; ++e) most += std::abs(carried_.kept[e]) * sums_[e].value;
        return most;
    }
    double sum(size_t s) const {
        double most =
            std::abs(carried_.kept[s]) * sums_[s].value + of_load(start_[s].value, change_[s].value, past_[s].value);
        for (size_t e = 0; s == step_.shape.elements && e < s; ++e)
            most += std::abs(carried_.strains[e].integral) * sums_[e].value;
        return most;
    }
    // The greatest |pressure less an element's stress| at the step's start, after a jump, and at its end.
    double excess(size_t e) const { return sums_[e].excess + step_.load.sj.value; }
    double excess_after(size_t e) const {
        const double E = step_.in_double[(1 + step_.shape.previous) * e].E, s0 = step_.load.s0.value;
        return (std::abs(carried_.kept[e]) + 0x1p-50) * std::min(excess(e), s0 + E * sums_[e].value) +
               (std::abs(1 - E * change_[e].value) + 0x1p-50) * step_.load.ds.value +
               E * std::abs(past_[e].value) * step_.load.past.value;
    }

  private:
    // Of the pressure at the start and its change, or of the pressures at start and end.
    double of_load(double start, double change, double past) const {
        const double s0 = step_.load.s0.value, ds = step_.load.ds.value;
        return std::min(std::abs(start) * s0 + std::abs(change) * ds,
                        std::abs(start - change) * s0 + std::abs(change) * step_.end) +
               std::abs(past) * step_.load.past.value;
    }

    const CountedStep& step_;
    const Carried& carried_;
    const std::array<CountedSum, scene::most_in_series + 2>& sums_;
    StateInDouble start_, change_, past_{}; // what loads of 1 lead to
    double strain_of_start_, strain_of_change_, strain_of_past_ = 0;
};

// The cell for kernels/cell.h.
struct Cell {
    const CountedStep& step;
    const Rounding& by;
    const Carried& carried;
    const Greatest* greatest; // null: values are known
    const CountedCell& before;
    CountedCell& after; // its sums are set, and to the errors of strain and integral those that the text does not know
    const Known* known; // of each sum
    Known earlier;

    using Sum = counted::Sum;
    friend int elements_of(const Cell& c) { return int(c.step.shape.elements); }
    friend bool has_spring(const Cell& c) { return c.step.shape.spring; }
    friend bool has_rate(const Cell& c) { return c.step.shape.rate; }
    friend bool has_integral(const Cell&) { return true; }
    friend int is_compensated(const Cell& c) { return c.by.compensated; }
    friend bool has_past(const Cell& c) { return c.step.shape.previous; }
    friend const counted::LaneCoefficients& element_of(const Cell& c, int e) {
        return c.step.k[size_t((1 + c.step.shape.previous) * e)];
    }
    friend const counted::LaneCoefficients& past_of(const Cell& c, int e) { return c.step.k[size_t(2 * e + 1)]; }
    friend Sum sum_from(const Cell& c, int s) {
        const CountedSum& sum = c.before.sums[size_t(s)];
        return {Counted(sum.value, 0, sum.shift, &c.by, c.known + s), Counted(0, 0, 0, &c.by)};
    }
    friend Counted rate_from(const Cell& c) {
        const CountedSum& rate = c.before.sums[c.step.shape.elements + 1];
        return {rate.value, rate.off, rate.shift, &c.by};
    }
    friend Counted previous_from(const Cell& c) { return {0, 0, 0, &c.by, &c.earlier}; }
    friend void store_previous(const Cell&, const Counted&) {}
    friend void store_rate(const Cell& c, const Counted& rate) {
        c.after.sums[c.step.shape.elements + 1] = {rate.value, rate.off, rate.shift};
    }
    friend void store(const Cell& c, int s, const Sum&, const Sum& sum) { c.take(size_t(s), sum.value); }

  private:
    // The rounding that stays in a sum x after a step. In a compensated sum: a small part of it, what is too small to
    // be carried, the step's rounding of what was lost before, and of what is lost now if the step exceeds the sum.
    double left(double x, const CountedSum& sum, double moved, double most_moved) const {
        const double most = std::abs(sum.value) + sum.off + std::abs(sum.shift), rounded = std::min(by.of(x), most);
        if (!by.compensated) return rounded;
        const double of_step = std::min(by.of(moved), most);
        return 2 * by.u * rounded + std::min(rounded, by.flush) + std::min(of_step, by.lost(sum.value)) +
               (most_moved > std::abs(sum.value) ? of_step : 0);
    }

    void take(size_t s, const Counted& x) const {
        const CountedSum& sum = before.sums[s];
        const bool strain = s < step.shape.elements;
        const double moved = x.value - sum.value, value = greatest ? greatest->sum(s) : x.value, kept = carried.kept[s],
                     taken = std::abs(1 - kept);
        double off = (std::abs(kept) + 4 * by.u * taken) * sum.off + taken * by.lost(sum.value) +
                     left(value, sum, moved, std::abs(moved) + x.off + std::abs(x.shift - sum.shift));
        for (size_t e = 0; !strain && e < step.shape.elements; ++e)
            off += std::abs(carried.strains[e].integral) * error_of(e);
        const double flush = by.flushed(value, before.flushed ? x.off + off : 0);
        off += flush - by.flushed(x.value);
        after.flushed = after.flushed || flush > 0;
        after.sums[s] = {value, x.off + off, x.shift, strain && greatest ? greatest->excess_after(s) : 0};
        (strain ? after.step.motion.strain : after.step.integral).off += off;
    }

  public:
    // The error of a strain at the step's start, as integral and rates take it.
    double error_of(size_t e) const { return (1 + 4 * by.u) * (before.sums[e].off + by.lost(before.sums[e].value)); }
};

} // namespace

void press(const CountedStep& step, const Rounding& by, const CountedCell& before, CountedCell& after) {
    const Carried carried(step);
    std::optional<Greatest> greatest;
    if (by.bound) greatest.emplace(step, carried, before);
    after.step = {};
    after.strains = 0;
    after.flushed = false;
    std::array<Known, scene::most_in_series + 1> known, stresses;
    for (size_t i = 0; i <= step.shape.elements; ++i) {
        known[i].sum = true;
        if (greatest && i < step.shape.elements)
            stresses[i].excess = greatest->excess(i), known[i].product = &stresses[i];
    }
    const Cell cell{step,   by,    carried,      greatest ? &*greatest : nullptr,
                    before, after, known.data(), {.change = &step.load.past}};
    counted::CellStep of = counted::step_of(cell, step.load);
    of.motion.strain.off += after.step.motion.strain.off;
    of.integral.off += after.step.integral.off;
    for (size_t e = 0; e < step.shape.elements; ++e) {
        of.motion.rate.off += std::abs(carried.strains[e].motion.rate) * cell.error_of(e);
        of.motion.acceleration.off += std::abs(carried.strains[e].motion.acceleration) * cell.error_of(e);
        after.strains += std::abs(after.sums[e].value);
    }
    if (greatest) {
        of.motion.strain.value = greatest->strain();
        of.integral.value = after.sums[step.shape.elements].value;
    }
    after.step = of;
}

} // namespace dermis::planner
