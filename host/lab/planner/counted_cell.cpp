// SPDX-License-Identifier: MIT
#include "host/lab/planner/counted_cell.hpp"

namespace dermis::planner {
namespace {

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

} // namespace

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

} // namespace dermis::planner
