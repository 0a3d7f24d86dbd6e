// SPDX-License-Identifier: MIT
#include "host/plan/plan.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace dermis::plan {

Timeline::Timeline(const Plan& plan) : plan_(plan), load_(plan.scene.load.envelope, plan.scene.time) {
    const Scene& s = plan.scene;
    medium_ = {s.material.modulus, s.material.viscosity, s.receptors.sa2_adaptation.value_or(INFINITY),
               *s.receptors.fa2 == Fa2::step_mean};
    switch (s.method) {
    case Method::exact: regular_ = exact_row(medium_, s.time.step); break;
    case Method::published: regular_ = published_row(medium_, s.time.step); break;
    default: regular_ = baseline_row(s.method, medium_, s.time.step); break;
    }
}

double Timeline::output_time(long long n) const { return double(n) * plan_.scene.time.step; }

// One step with all that the load does on it. `start` is its value after a jump at the beginning; what it does beyond
// staying there is worked out for unit pressure, in double, into the factors of ds (whose Constants::rise is then 1).
Step Timeline::exact_step(double from, double to) const {
    const double whole = plan_.scene.time.step;
    const bool regular = std::abs(to - from - whole) <= 1e-6 * whole;
    Step s;
    s.time = to;
    s.start = load_.after(from);
    s.jump = s.start - load_.before(from);
    s.row = regular ? regular_ : exact_row(medium_, to - from);
    if (to == from) return s;
    if (load_.sine()) force_sine(s, from, regular ? from + whole : to);
    else force_straight(s, from, to);
    if (medium_.viscosity == 0 && medium_.step_mean) {
        // an elastic skin's rate is not in its state: the one before comes from the load
        f64::Row& k = s.row;
        if (s.rise == 0) k.f = k.i2 = k.v1 = 0;
        s.rise = 1;
        k.a1 = (k.v1 - load_.slope_before(from) / medium_.modulus) / (to - from);
    }
    return s;
}

// Piece by piece from breakpoint to breakpoint.
void Timeline::force_straight(Step& s, double from, double to) const {
    const auto later = [](double t, const scene::Knot& k) { return t < k.time; };
    auto knot = std::upper_bound(load_.knots().begin(), load_.knots().end(), from, later);
    const bool whole = knot == load_.knots().end() || knot->time >= to;
    if (whole && load_.before(to) == s.start) return; // held
    s.rise = 1;
    if (whole) { // straight: the row's own factors of a linear rise
        const double du = load_.before(to) - s.start;
        for (double* factor : {&s.row.f, &s.row.i2, &s.row.v1, &s.row.a1}) *factor *= du;
        return;
    }
    Medium density = medium_;
    density.step_mean = false;
    double eps = 0, sum = 0, rate = 0, acceleration = 0;
    for (double begin = from; begin < to;) {
        const double end = knot == load_.knots().end() ? to : std::min(to, (knot++)->time);
        const double u0 = load_.after(begin) - s.start, du = load_.before(end) - s.start - u0;
        const f64::Row k = exact_row(density, end - begin);
        const double r = u0 - k.E * eps;
        rate = k.v0 * r + k.v1 * du;
        acceleration = k.a0 * r + k.a1 * du;
        sum += k.i0 * eps + k.i1 * u0 + k.i2 * du - k.leak * sum;
        eps += k.b * r + k.f * du;
        begin = end;
    }
    s.row.f = eps;
    s.row.i2 = sum;
    s.row.v1 = rate;
    s.row.a1 = medium_.step_mean ? rate / (to - from) : acceleration;
}

// In closed form: what the skin would do under the sine for ever, less what is left of it from the step's beginning.
void Timeline::force_sine(Step& s, double from, double to) const {
    using Complex = std::complex<double>;
    const Envelope& e = plan_.scene.load.envelope;
    const double w = load_.angular_frequency(), dt = to - from, E = medium_.modulus, eta = medium_.viscosity;
    Medium density = medium_;
    density.step_mean = false;
    const f64::Row k = exact_row(density, dt);
    const Complex iw(0, w), turn = std::exp(iw * dt);
    const Complex eps0 = Complex(0, -e.amplitude) * std::exp(Complex(0, w * from + e.phase)) / (E + iw * eta);
    const Complex sum0 = eps0 / (1 / medium_.sa2_adaptation + iw);
    const double left = k.v0 * eta;       // of a strain, after the step: e^-z
    const double wave = s.start - e.mean; // the mean is held
    s.rise = 1;
    s.row.f = (eps0 * (turn - left)).real() - k.b * wave;
    s.row.i2 = (sum0 * (turn - (1 - k.leak)) - eps0 * k.i0).real() - k.i1 * wave;
    s.row.v1 = (eps0 * (iw * turn + E * k.v0)).real() - k.v0 * wave;
    const double acceleration = (eps0 * (-w * w * turn + k.E * k.a0)).real() - k.a0 * wave;
    s.row.a1 = medium_.step_mean ? s.row.v1 / dt : acceleration;
}

// Baselines hold the load over the step at its value at the step's start.
Step Timeline::held_step(long long n) {
    Step s;
    s.row = regular_;
    s.time = output_time(n);
    s.start = load_.after(output_time(n - 1));
    s.jump = s.start - (n > 1 ? load_.after(output_time(n - 2)) : 0);
    if (plan_.scene.method != Method::published) return s;
    // FA2[n] = (d[n+1] - d[n-1])/(2 dt), 0 at both ends, with d[n] the rate at the start of step n
    const Material& m = plan_.scene.material;
    const double dt = plan_.scene.time.step;
    if (n == 1) rate_ = s.start / m.viscosity;
    strain_ += rate_ * dt;
    const double rate_after = (load_.after(output_time(n)) - m.modulus * strain_) / m.viscosity;
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
        return field_ < fields.size() ? fields[field_] : INFINITY;
    };
    const double end = std::min(to, plan_.scene.time.duration);
    if (n > 0 && exact) {
        const std::vector<scene::Knot>& knots = load_.knots();
        for (; knot_ < knots.size() && knots[knot_].time < end; ++knot_) {
            const scene::Knot& k = knots[knot_];
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
