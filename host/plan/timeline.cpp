// SPDX-License-Identifier: MIT
#include "host/plan/plan.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace dermis::plan {
namespace {

// A straight piece of a load within a step: pressure u0 to u0 + du over and above what the step starts with.
struct Piece {
    double length, u0, du;
};

// From breakpoint to breakpoint.
std::vector<Piece> pieces_of(const scene::Waveform& load, double from, double to) {
    const auto later = [](double t, const scene::Knot& k) { return t < k.time; };
    auto knot = std::upper_bound(load.knots().begin(), load.knots().end(), from, later);
    std::vector<Piece> pieces;
    for (double begin = from; begin < to;) {
        const double end = knot == load.knots().end() ? to : std::min(to, (knot++)->time);
        const double u0 = load.after(begin) - load.after(from);
        pieces.push_back({end - begin, u0, load.before(end) - load.after(from) - u0});
        begin = end;
    }
    return pieces;
}

// What the load does on a step beyond staying at its start, worked out for unit pressure into the factors of ds.
void force_straight(f64::Coefficients& row, const Medium& medium, const std::vector<Piece>& pieces, double dt) {
    if (pieces.size() == 1) { // the row's own factors of a linear rise
        for (double* factor : {&row.f, &row.i2, &row.v1, &row.a1}) *factor *= pieces[0].du;
        return;
    }
    Medium density = medium;
    density.step_mean = false;
    double eps = 0, sum = 0, rate = 0, acceleration = 0;
    for (const Piece& p : pieces) {
        const f64::Coefficients k = exact_coefficients(density, p.length);
        const double r = p.u0 - k.E * eps;
        rate = k.v0 * r + k.v1 * p.du;
        acceleration = k.a0 * r + k.a1 * p.du;
        sum += k.i0 * eps + k.i1 * p.u0 + k.i2 * p.du - k.leak * sum;
        eps += k.b * r + k.f * p.du;
    }
    row.f = eps;
    row.i2 = sum;
    row.v1 = rate;
    row.a1 = medium.step_mean ? rate / dt : acceleration;
}

using Complex = std::complex<double>;

// wave(t) = imaginary part of `wave`*e^(i w t) from the step's start on.
struct Sine {
    double w;
    Complex wave, turn; // at the start; e^(i w dt)
};

// In closed form: what the skin would do under the sine for ever, less what is left of it from the step's beginning.
void force_sine(f64::Coefficients& k, const Medium& m, const Sine& s, double dt) {
    const Complex iw(0, s.w);
    const Complex eps0 = Complex(0, -1) * s.wave / (m.modulus + iw * m.viscosity);
    const Complex sum0 = eps0 / (1 / m.sa2_adaptation + iw);
    const double left = k.v0 * m.viscosity; // of a strain, after the step: e^-z
    const double wave = s.wave.imag();      // the row does what a pressure held at this would do: taken off
    k.f = (eps0 * (s.turn - left)).real() - k.b * wave;
    k.i2 = (sum0 * (s.turn - (1 - k.leak)) - eps0 * k.i0).real() - k.i1 * wave;
    k.v1 = (eps0 * (iw * s.turn + m.modulus * k.v0)).real() - k.v0 * wave;
    const double acceleration = (eps0 * (-s.w * s.w * s.turn + k.E * k.a0)).real() - k.a0 * wave;
    k.a1 = m.step_mean ? k.v1 / dt : acceleration;
}

} // namespace

Plan timing(const Plan& p, std::vector<Medium> media, Method method) {
    Plan t;
    t.scene.method = method;
    t.scene.time = p.scene.time;
    t.scene.load.envelope = p.scene.load.envelope;
    t.scene.load.interval = p.scene.load.interval;
    t.media = std::move(media);
    t.outputs = p.outputs;
    t.field_times = p.field_times;
    t.framed = p.framed;
    t.frames = p.frames;
    return t;
}

void FrameFeed::before(const Step& step, const std::function<void(const std::vector<double>&)>& give) {
    for (; step.frame >= 0 && given_ < step.frame + 2; ++given_) {
        plan_.frames->read(std::min(given_, plan_.frames->maps() - 1), frame_);
        for (double& p : frame_) p *= plan_.scene.load.intensity;
        give(frame_);
    }
}

Timeline::Timeline(const Plan& plan) : plan_(plan), load_(plan.scene.load.envelope, plan.scene.time) {
    const double dt = plan.scene.time.step;
    LaneCoefficients rows;
    for (const Medium& m : plan.media) switch (plan.scene.method) {
        case Method::exact: rows.push_back(exact_coefficients(m, dt)); break;
        case Method::published: rows.push_back(published_coefficients(m, dt)); break;
        default: rows.push_back(baseline_coefficients(plan.scene.method, m, dt)); break;
        }
    regular_ = std::make_shared<LaneCoefficients>(std::move(rows));
}

double Timeline::output_time(long long n) const { return double(n) * plan_.scene.time.step; }

bool Timeline::regular(double from, double to) const {
    const double whole = plan_.scene.time.step;
    return std::abs(to - from - whole) <= 1e-6 * whole;
}

Timeline::SharedRows Timeline::rows_over(double from, double to) const {
    if (regular(from, to)) return regular_;
    LaneCoefficients rows;
    for (const Medium& m : plan_.media) rows.push_back(exact_coefficients(m, to - from));
    return std::make_shared<LaneCoefficients>(std::move(rows));
}

// One step with all that the load does on it. `start` is its value after a jump at the beginning; what it does beyond
// staying there is in the factors of ds, whose Constants::rise is then 1.
Step Timeline::exact_step(double from, double to) const {
    if (plan_.frames) return framed_step(from, to);
    Step s;
    s.time = to;
    s.start = load_.after(from);
    s.jump = s.start - load_.before(from);
    s.rows = rows_over(from, to);
    if (to == from) return s;
    const double dt = regular(from, to) ? plan_.scene.time.step : to - from;
    const bool straight = !load_.sine() && !load_.breaks(from, to);
    const double du = straight ? load_.before(to) - s.start : 0;
    const bool held = straight && du == 0;
    // an elastic skin's rate is not in its state: the one before a step comes from the load
    const auto from_slope = [](const Medium& m) { return m.viscosity == 0 && m.step_mean; };
    if (held && std::none_of(plan_.media.begin(), plan_.media.end(), from_slope)) return s;
    std::vector<Piece> pieces;
    if (straight) pieces = {{dt, 0, du}};
    else if (!load_.sine()) pieces = pieces_of(load_, from, to);
    const double w = load_.angular_frequency(), amplitude = plan_.scene.load.envelope.amplitude;
    const Sine sine{w, amplitude * std::exp(Complex(0, w * from + plan_.scene.load.envelope.phase)),
                    std::exp(Complex(0, w * dt))};
    auto forced = std::make_shared<LaneCoefficients>(*s.rows);
    s.rise = 1;
    for (size_t i = 0; i < forced->size(); ++i) {
        const Medium& m = plan_.media[i];
        f64::Coefficients& k = (*forced)[i];
        if (load_.sine()) force_sine(k, m, sine, dt);
        else force_straight(k, m, pieces, dt);
        if (from_slope(m)) k.a1 = (k.v1 - load_.slope_before(from) / m.modulus) / (to - from);
    }
    s.rows = forced;
    return s;
}

double Timeline::frame_time(long long k) const {
    const Scene& s = plan_.scene;
    const long long whole = scene::steps_per_frame(s);
    return whole ? output_time(k * whole) : scene::Waveform::snapped(double(k) * *s.load.interval, s.time.step);
}

// The last frame at or before t.
long long Timeline::frame_at(double t) const {
    long long k = static_cast<long long>(t / *plan_.scene.load.interval);
    while (frame_time(k + 1) <= t) ++k;
    while (k > 0 && frame_time(k) > t) --k;
    return std::min(k, plan_.frames->maps() - 1);
}

// A step within one interval between frames.
Step Timeline::framed_step(double from, double to) const {
    Step s;
    s.time = to;
    s.rows = rows_over(from, to);
    s.frame = frame_at(from);
    s.jump = from == 0; // frame 0 meets a skin at rest
    if (s.frame + 1 == plan_.frames->maps()) return s;
    const double begin = frame_time(s.frame), length = frame_time(s.frame + 1) - begin;
    s.start = (from - begin) / length;
    s.rise = (to - from) / length;
    return s;
}

// Baselines hold the load over the step at its value at the step's start.
Step Timeline::held_step(long long n) {
    Step s;
    s.rows = regular_;
    s.time = output_time(n);
    s.start = load_.after(output_time(n - 1));
    s.jump = s.start - (n > 1 ? load_.after(output_time(n - 2)) : 0);
    if (plan_.scene.method != Method::published) return s;
    // FA2[n] = (d[n+1] - d[n-1])/(2 dt), 0 at both ends, with d[n] the rate at the start of step n
    const Medium& m = plan_.media.front();
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
        auto rows = std::make_shared<LaneCoefficients>(*step.rows);
        for (size_t i = 0; i < rows->size(); ++i) {
            const Medium& m = plan_.media[i];
            f64::Coefficients& k = (*rows)[i];
            // between frames only at t = 0, where the whole pressure is the jump and r and sj are it
            const double fa1 = m.viscosity > 0 ? 0 : jump / m.modulus, fa2 = m.viscosity > 0 ? jump / m.viscosity : 0;
            if (step.rise == 0) k.f = k.i2 = 0;
            k.v0 = plan_.frames ? fa1 : 0;
            k.v1 = plan_.frames ? 0 : fa1;
            k.a0 = 0;
            k.a1 = plan_.frames ? 0 : fa2;
            k.a2 = plan_.frames ? fa2 : 0;
        }
        if (!plan_.frames) step.rise = 1;
        step.rows = rows;
    }
    pending_.push_back(step);
}

// Queues the steps from frame to frame between two outputs, and the fields on the way.
void Timeline::fill_frames(double from, double to) {
    const std::vector<double>& fields = plan_.field_times;
    if (from == 0) look(framed_step(0, 0), impulses_++, -1, 1);
    const double last = std::isfinite(to) ? to : field_ < fields.size() ? fields.back() : from;
    while (from < last) {
        const long long k = frame_at(from);
        const double end = k + 1 < plan_.frames->maps() ? std::min(to, frame_time(k + 1)) : to;
        for (; field_ < fields.size() && fields[field_] <= end && fields[field_] < to; ++field_)
            look(framed_step(from, fields[field_]), -1, int(field_), 0);
        if (end == to || end >= last) break;
        pending_.push_back(framed_step(from, end));
        from = end;
    }
}

// Queues what happens after the last output up to the next one, and that one.
void Timeline::fill() {
    const bool exact = plan_.scene.method == Method::exact;
    const std::vector<double>& fields = plan_.field_times;
    const long long n = output_;
    double from = n > 0 ? output_time(n - 1) : 0;
    const double to = n < plan_.outputs ? output_time(n) : INFINITY;
    const auto field_at = [&] { // infinity: no more
        return field_ < fields.size() ? fields[field_] : INFINITY;
    };
    const double end = std::min(to, plan_.scene.time.duration);
    if (n > 0 && plan_.frames) {
        fill_frames(from, to);
        for (const Step& s : pending_)
            if (s.keep) from = s.time;
    } else if (n > 0 && exact) {
        const std::vector<scene::Knot>& knots = load_.knots();
        for (; knot_ < knots.size() && knots[knot_].time < end; ++knot_) {
            const scene::Knot& k = knots[knot_];
            if (k.right != k.left) look(exact_step(from, k.time), impulses_++, -1, k.right - k.left);
        }
        for (; field_at() < to; ++field_) look(exact_step(from, field_at()), -1, int(field_), 0);
    }
    if (n < plan_.outputs) {
        Step s;
        if (n == 0) s.rows = std::make_shared<LaneCoefficients>(plan_.media.size()); // at rest
        else s = exact ? exact_step(from, to) : held_step(n);
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
