// SPDX-License-Identifier: MIT
#include "host/lab/planner/counted_cell.hpp"

namespace dermis::planner {
namespace {

// What a step leads to, per unit of one number of the state or of the load. The step is linear.
struct Effect {
    std::array<double, scene::most_in_series + 3> sums{};
    double strain = 0, rate = 0, acceleration = 0;
};

Effect effect_of(const plan::StateShape& shape, const f64::LaneCoefficients* k, size_t sum, double number,
                 const f64::Load& load = f64::load(0, 0, 0)) {
    std::array<f64::Sum, scene::most_in_series + 3> before{}, after{};
    before[sum].value = number;
    const f64::CellStep step = f64::step_of(plan::SingleCell<f64>{shape, k, before.data(), after.data()}, load);
    Effect effect{.strain = step.motion.strain, .rate = step.motion.rate, .acceleration = step.motion.acceleration};
    for (size_t i = 0; i < after.size(); ++i) effect.sums[i] = after[i].value;
    return effect;
}

// What the errors of a state become. A kernel's terms cancel in the part of a strain that a step leaves, so these errors
// are carried beside the kernel's text, which meets a state without them.
class Carried {
  public:
    Carried(const CountedStep& step, const Rounding& by) : elements_(step.shape.elements), u_(by.u) {
        const plan::StateShape one;
        for (size_t e = 0; e < elements_; ++e) of_strain_[e] = effect_of(one, element(step, e), 0, 1);
        kept_ = effect_of(one, element(step, 0), 1, 1).sums[1];
    }

    // The share of a sum that the step leaves.
    double kept(size_t s) const { return s < elements_ ? of_strain_[s].sums[0] : kept_; }
    double integral(size_t e) const { return std::abs(of_strain_[e].sums[1]); }
    double rate(size_t e) const { return std::abs(of_strain_[e].rate); }
    double acceleration(size_t e) const { return std::abs(of_strain_[e].acceleration); }
    // The factor of a sum's error. The roundings of the step itself are counted in the text.
    double factor(size_t s) const { return std::abs(kept(s)) + 4 * u_ * std::abs(1 - kept(s)); }

  private:
    static const f64::LaneCoefficients* element(const CountedStep& step, size_t e) {
        return &step.in_double[(1 + step.shape.previous) * e];
    }

    size_t elements_;
    double u_;
    std::array<Effect, scene::most_in_series> of_strain_;
    double kept_; // of the integral
};

// Between frames: the greatest magnitudes of what a step leads to, from those of what it starts from.
class Greatest {
  public:
    Greatest(const CountedStep& step, const Carried& carried, const CountedSum* sums)
        : step_(step), carried_(carried), sums_(sums), n_(step.shape.elements) {
        const auto of = [&](const f64::Load& load) { return effect_of(step.shape, step.in_double.data(), 0, 0, load); };
        start_ = of(f64::load(1, 0, 0));
        change_ = of(f64::load(0, 1, 0));
        jump_ = of(f64::load(0, 0, 1));
        if (step.shape.previous) past_ = effect_of(step.shape, step.in_double.data(), n_ + 2, -1);
        if (step.shape.rate) of_rate_ = effect_of(step.shape, step.in_double.data(), n_ + 1, 1);
    }

    double sum(size_t s) const {
        double most = std::abs(carried_.kept(s)) * sums_[s].value + of_load([s](auto& x) { return x.sums[s]; });
        for (size_t e = 0; s == n_ && e < n_; ++e) most += carried_.integral(e) * sums_[e].value;
        return most;
    }
    double strain() const {
        double most = of_load([](auto& x) { return x.strain; });
        for (size_t e = 0; e < n_; ++e) most += std::abs(carried_.kept(e)) * sums_[e].value;
        return most;
    }
    double rate() const {
        double most = of_load([](auto& x) { return x.rate; });
        for (size_t e = 0; e < n_; ++e) most += carried_.rate(e) * sums_[e].value;
        return most;
    }
    double acceleration() const {
        double most = of_load([](auto& x) { return x.acceleration; }) +
                      std::abs(of_rate_.acceleration) * std::abs(sums_[n_ + 1].value);
        for (size_t e = 0; e < n_; ++e) most += carried_.acceleration(e) * sums_[e].value;
        return most;
    }

  private:
    // The pressure at the start and its change, or the pressures at start and end.
    template <class Of> double of_load(Of of) const {
        const double s0 = std::abs(step_.load.s0.value), start = of(start_), change = of(change_);
        return std::min(std::abs(start) * s0 + std::abs(change) * std::abs(step_.load.ds.value),
                        std::abs(start - change) * s0 + std::abs(change) * step_.end) +
               std::abs(of(jump_)) * std::abs(step_.load.sj.value) +
               std::abs(of(past_)) * std::abs(step_.load.past.value);
    }

    const CountedStep& step_;
    const Carried& carried_;
    const CountedSum* sums_;
    const size_t n_;
    Effect start_, change_, jump_, past_, of_rate_;
};

// The cell for kernels/cell.h.
struct Cell {
    const CountedStep& step;
    const Rounding& by;
    const Carried& carried;
    const Greatest* greatest; // null: values are known
    const CountedSum* before;
    CountedSum* after;
    Counted earlier;
    bool was_flushed;
    // Set by a step: errors of the strains' sum and of the integral beside those in the text; whether something is
    // stored as 0.
    double& strain_off;
    double& integral_off;
    bool& flushed;

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
        Counted value(c.before[s].value, 0, c.before[s].shift, &c.by);
        value.sum = true;
        return {value, Counted(0, 0, 0, &c.by)};
    }
    friend Counted rate_from(const Cell& c) {
        const CountedSum& rate = c.before[c.step.shape.elements + 1];
        return {rate.value, rate.off, rate.shift, &c.by};
    }
    friend Counted previous_from(const Cell& c) { return c.earlier; }
    friend void store_previous(const Cell&, const Counted&) {}
    friend void store_rate(const Cell& c, const Counted& rate) {
        c.after[c.step.shape.elements + 1] = {rate.value, rate.off, rate.shift};
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
        const CountedSum& sum = before[s];
        const double moved = x.value - sum.value, value = greatest ? greatest->sum(s) : x.value;
        double off = carried.factor(s) * sum.off + std::abs(1 - carried.kept(s)) * by.lost(sum.value) +
                     left(value, sum, moved, std::abs(moved) + x.off + std::abs(x.shift - sum.shift));
        const bool strain = s < step.shape.elements;
        for (size_t e = 0; !strain && e < step.shape.elements; ++e) off += carried.integral(e) * error_of(e);
        const double least = by.flushed(x.value), below = by.flushed(value, was_flushed ? x.off + off : 0);
        off += below - least;
        flushed = flushed || below > 0;
        (strain ? strain_off : integral_off) += off;
        after[s] = {value, x.off + off, x.shift};
    }

  public:
    // The error of a strain at the step's start, as integral and rates take it.
    double error_of(size_t e) const { return (1 + 4 * by.u) * (before[e].off + by.lost(before[e].value)); }
};

} // namespace

CountedCell pressed(const CountedStep& step, const Rounding& by, const CountedCell& before, const CountedSum* sums,
                    CountedSum* after) {
    const Carried carried(step, by);
    std::optional<Greatest> greatest;
    if (by.bound) greatest.emplace(step, carried, sums);
    CountedCell now;
    double strain_off = 0, integral_off = 0;
    Counted earlier;
    earlier.change = &step.load.past;
    const Cell cell{step, by, carried, greatest ? &*greatest : nullptr, sums, after, earlier, before.flushed, strain_off, integral_off, now.flushed};
    now.step = counted::step_of(cell, step.load);
    counted::Motion& m = now.step.motion;
    m.strain.off += strain_off;
    now.step.integral.off += integral_off;
    for (size_t e = 0; e < step.shape.elements; ++e) {
        m.rate.off += carried.rate(e) * cell.error_of(e);
        m.acceleration.off += carried.acceleration(e) * cell.error_of(e);
        now.strains += std::abs(after[e].value);
    }
    if (!greatest) {
        return now;
    }
    m.strain.value = greatest->strain();
    now.step.integral.value = after[step.shape.elements].value;
    m.rate.value = greatest->rate();
    m.acceleration.value = greatest->acceleration();
    return now;
}

} // namespace dermis::planner
