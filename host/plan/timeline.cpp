// SPDX-License-Identifier: MIT
#include "host/plan/plan.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::plan {

Timeline::Timeline(const Plan& plan) : plan_(plan) {
    const Scene& s = plan.scene;
    medium_ = {s.material.modulus, s.material.viscosity, s.receptors.sa2_adaptation.value_or(INFINITY),
               *s.receptors.fa2 == Fa2::step_mean};
    switch (s.method) {
    case Method::exact: regular_ = exact_row(medium_, s.time.step); break;
    case Method::published: regular_ = published_row(medium_, s.time.step); break;
    default: regular_ = baseline_row(s.method, medium_, s.time.step); break;
    }
    knots_ = {{snapped(s.load.start), 0, 1}};
}

double Timeline::output_time(long long n) const { return double(n) * plan_.scene.time.step; }

// A time within 1e-6 of a step from an output is that output's.
double Timeline::snapped(double t) const {
    const double step = plan_.scene.time.step, n = std::round(t / step);
    return std::abs(t - n * step) <= 1e-6 * step ? n * step : t;
}

double Timeline::load_before(double t) const {
    double value = 0;
    for (size_t i = 0; i < knots_.size() && knots_[i].time < t; ++i) {
        value = knots_[i].right;
        if (i + 1 < knots_.size()) {
            const Knot &a = knots_[i], &b = knots_[i + 1];
            value += (b.left - a.right) * std::min(1.0, (t - a.time) / (b.time - a.time));
        }
    }
    return value;
}

double Timeline::load_after(double t) const {
    for (const Knot& k : knots_)
        if (k.time == t) return k.right;
    return load_before(t);
}

// The whole load on the step in one row: what it does beyond staying at its first value is composed here, for unit
// pressure and in double, into the factors of ds (whose Constants::rise is then 1).
Step Timeline::exact_step(double from, double to) const {
    const double whole = plan_.scene.time.step;
    Step s;
    s.time = to;
    s.start = load_after(from);
    s.jump = s.start - load_before(from);
    std::vector<double> ends;
    for (const Knot& k : knots_)
        if (k.time > from && k.time < to) ends.push_back(k.time);
    ends.push_back(to);
    const bool regular = std::abs(to - from - whole) <= 1e-6 * whole;
    s.row = regular ? regular_ : exact_row(medium_, to - from);
    if (to == from) return s;
    if (ends.size() == 1 && load_before(to) == s.start) return s;
    double eps = 0, sum = 0, rate = 0, acceleration = 0, begin = from;
    Medium density = medium_;
    density.step_mean = false;
    for (double end : ends) {
        const double u0 = load_after(begin) - s.start, du = load_before(end) - s.start - u0;
        const f64::Row k = exact_row(density, regular && ends.size() == 1 ? whole : end - begin);
        const double r = u0 - k.E * eps;
        rate = k.v0 * r + k.v1 * du;
        acceleration = k.a0 * r + k.a1 * du;
        sum += k.i0 * eps + k.i1 * u0 + k.i2 * du - k.leak * sum;
        eps += k.b * r + k.f * du;
        begin = end;
    }
    s.rise = 1;
    s.row.f = eps;
    s.row.i2 = sum;
    s.row.v1 = rate;
    s.row.a1 = medium_.step_mean ? rate / (to - from) : acceleration;
    return s;
}

// Baselines hold the load over the step at its value at the step's start.
Step Timeline::held_step(long long n) {
    Step s;
    s.row = regular_;
    s.time = output_time(n);
    s.start = load_after(output_time(n - 1));
    s.jump = s.start - (n > 1 ? load_after(output_time(n - 2)) : 0);
    if (plan_.scene.method != Method::published) return s;
    // FA2[n] = (d[n+1] - d[n-1])/(2 dt), 0 at both ends, with d[n] the rate at the start of step n
    const Material& m = plan_.scene.material;
    const double dt = plan_.scene.time.step;
    if (n == 1) rate_ = s.start / m.viscosity;
    strain_ += rate_ * dt;
    const double rate_after = (load_after(output_time(n)) - m.modulus * strain_) / m.viscosity;
    s.jump = n + 1 < plan_.outputs ? (rate_after - rate_before_) / (2 * dt) : 0;
    rate_before_ = rate_;
    rate_ = rate_after;
    return s;
}

// Queues a step that leaves the state alone: a field, or with its responses replaced the impulse of a jump.
void Timeline::look(Step step, int impulse, int field, double jump) {
    step.keep = false;
    step.impulse = impulse;
    step.field = field;
    if (impulse >= 0) {
        f64::Row& k = step.row;
        if (step.rise == 0) k.f = k.i2 = 0;
        step.rise = 1;
        k.v0 = k.a0 = k.a2 = 0;
        k.v1 = medium_.viscosity > 0 ? 0 : jump / medium_.modulus;
        k.a1 = medium_.viscosity > 0 ? jump / medium_.viscosity : 0;
    }
    pending_.push_back(step);
}

// Queues what happens after the last output up to the next one, and that one.
void Timeline::fill() {
    const bool exact = plan_.scene.method == Method::exact;
    const std::vector<double>& fields = plan_.field_times;
    const long long n = output_;
    const double from = n > 0 ? output_time(n - 1) : 0, to = n < plan_.outputs ? output_time(n) : INFINITY;
    const auto field_at = [&] { // infinity: no more
        return field_ < fields.size() ? snapped(fields[field_]) : INFINITY;
    };
    const double end = std::min(to, plan_.scene.time.duration);
    if (n > 0 && exact) {
        for (; knot_ < knots_.size() && knots_[knot_].time < end; ++knot_) {
            const Knot& k = knots_[knot_];
            if (k.right != k.left) look(exact_step(from, k.time), impulses_++, -1, k.right - k.left);
        }
        for (; field_at() < to; ++field_) look(exact_step(from, field_at()), -1, int(field_), 0);
    }
    if (n < plan_.outputs) {
        Step s;
        if (n > 0) s = exact ? exact_step(from, to) : held_step(n);
        s.trace = n;
        if (field_at() == to) s.field = int(field_++);
        pending_.push_back(s);
    }
    std::reverse(pending_.begin(), pending_.end());
    ++output_;
}

bool Timeline::next(Step& step) {
    if (pending_.empty() && output_ <= plan_.outputs) fill();
    if (pending_.empty()) return false;
    step = pending_.back();
    pending_.pop_back();
    return true;
}

} // namespace dermis::plan
