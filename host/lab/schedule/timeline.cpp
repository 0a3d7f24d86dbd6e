// SPDX-License-Identifier: MIT
#include "host/lab/schedule/timeline.hpp"

#include "host/core/base/pool.hpp"
#include "host/core/base/watch.hpp"
#include "host/lab/schedule/baselines.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dermis::model {

void FrameFeed::before(const Step& step, const std::function<void(const std::vector<double>&)>& give) {
    if (step.frame < 0 || (given_[0] == step.from && given_[1] == step.to)) return;
    const auto next = [&](const FramePlace& place) {
        give(pressure(place));
        given_[0] = std::exchange(given_[1], place);
    };
    if (given_[1] != step.from) next(step.from);
    next(step.to);
}

const std::vector<double>& FrameFeed::frame(long long k) {
    const size_t place = size_t(k % 3);
    if (std::exchange(number_[place], k) == k) return frames_[place];
    schedule_.sequence->read(std::min(k, schedule_.sequence->maps() - 1), frames_[place]);
    if (!schedule_.crests.empty())
        scene::press_crests(schedule_.load, schedule_.crests, width_, schedule_.load.intensity, frames_[place]);
    for (double& p : frames_[place]) p *= schedule_.load.intensity;
    return frames_[place];
}

// The formula is p + u*(q - p) + c*(u*u - u): kernels/NUMERICS.md.
const std::vector<double>& FrameFeed::pressure(const FramePlace& place) {
    const auto [k, u] = place;
    if (u == 0) return frame(k);
    const std::vector<double>&o = frame(std::max(k - 1, 0LL)), &p = frame(k), &q = frame(k + 1);
    const scene::Instant now = frame_time(schedule_, k);
    const double rho = k == 0 ? 1 : (now - frame_time(schedule_, k - 1)) / (frame_time(schedule_, k + 1) - now),
                 bow = k == 0 ? 0 : (u * u - u) / (rho * (1 + rho));
    between_.resize(p.size());
    for (size_t i = 0; i < p.size(); ++i) {
        const double change = q[i] - p[i];
        between_[i] = p[i] + (u * change + bow * (rho * change - (p[i] - o[i])));
    }
    return between_;
}

scene::Instant frame_time(const Schedule& schedule, long long k) {
    const double interval = *schedule.load.interval, step = schedule.time.step;
    const long long whole = scene::steps_per_frame(interval, step);
    return whole ? scene::Instant::multiple(double(k * whole), schedule.between_outputs())
                 : scene::snapped(scene::Instant::multiple(double(k), interval), step);
}

// A table of make(index) for each material.
template <class Make> auto Timeline::table_of(Make make) const {
    using Table = std::vector<decltype(make(0))>;
    auto table = std::make_shared<Table>(simd::map_of(materials_.size(), typename Table::value_type{}));
    simd::Pool pool(simd::useful_threads(materials_.size(), threads_));
    pool.share(int(materials_.size()), [&](int first, int last) {
        for (int i = first; i < last; ++i) (*table)[size_t(i)] = make(size_t(i));
    });
    return std::shared_ptr<const Table>(std::move(table));
}

Timeline::Timeline(const Schedule& schedule, const std::vector<Element>& materials, const ResponseRule& rule,
                   Method method, int threads)
    : schedule_(schedule), materials_(materials), rule_(rule), method_(method), threads_(threads),
      rate_from_slope_(rule.step_mean && std::ranges::any_of(materials, scene::is_elastic)),
      load_(schedule.load.envelope, schedule.time) {
    for (const Instant& t : schedule.jumps) jumps_.push_back({t, load_.before(t), load_.after(t)});
    if (jumps_.empty())
        std::ranges::copy_if(load_.knots(), std::back_inserter(jumps_), [](auto& k) { return k.right != k.left; });
    const double dt = schedule.between_outputs();
    regular_ = table_of([&](size_t i) {
        const Element& m = materials[i];
        switch (method) {
        case Method::exact: return exact_coefficients(m, rule, dt);
        case Method::published: return published_coefficients(m, dt);
        default: return baseline_coefficients(method, m, rule, dt);
        }
    });
    if (method == Method::exact && !schedule.sequence && load_.sine())
        gains_ = table_of([&](size_t i) {
            return sine_gains<f64>((*regular_)[i], materials[i], rule, load_.angular_frequency(),
                                   load_.turn<double>(dt), dt);
        });
}

scene::Instant Timeline::output_time(long long n) const {
    return Instant::multiple(double(n), schedule_.between_outputs());
}

// Whether a step is as long as a whole one, up to rounding.
bool Timeline::regular(Instant from, Instant to) const {
    const double whole = schedule_.between_outputs();
    return std::abs(to - from - whole) <= 4 * 0x1p-52 * whole;
}

double Timeline::length_of(Instant from, Instant to) const {
    return regular(from, to) ? schedule_.between_outputs() : to - from;
}

// The load's change over a step. Of many segments the first ones are composed once for all steps from the same output.
Forcing<double> Timeline::forcing_of(Instant from, Instant to, double dt) {
    constexpr size_t few = 16;
    if (!(begun_from_ == from)) begun_.clear(), begun_from_ = from;
    const auto later = std::ranges::lower_bound(begun_, to, std::less<Instant>(), &BegunUntil::end);
    const BegunUntil first = later == begun_.begin() ? BegunUntil{from, nullptr} : *(later - 1);
    Forcing<double> forcing = forcing_over(load_, from, to, dt, rate_from_slope_, first.end);
    forcing.begun = first.states;
    std::vector<Segment<double>>& segments = forcing.segments;
    auto knot = std::ranges::upper_bound(load_.knots(), first.end, std::less<Instant>(), &scene::Knot::time);
    size_t done = 0;
    for (; segments.size() > done + 2 * few; done += few) {
        const std::span<const Segment<double>> next(segments.data() + done, few);
        forcing.begun = table_of([&](size_t i) {
            return after_segments(materials_[i], rule_, next, forcing.begun ? (*forcing.begun)[i] : Begun());
        });
        knot += few;
        begun_.push_back({(knot - 1)->time, forcing.begun});
    }
    segments.erase(segments.begin(), segments.begin() + std::ptrdiff_t(done));
    return forcing;
}

// One step under the load. Step::start is the load after a jump at the step's start; its change within the step is in
// the factors of ds, and Step::rise is then 1.
Step Timeline::exact_step(Instant from, Instant to) {
    if (schedule_.sequence) return framed_step(from, to);
    Step s;
    s.time = to.t;
    s.begin = from;
    s.end = to;
    s.exact = true;
    s.start = load_.after(from);
    s.jump = s.start - load_.before(from);
    if (regular(from, to)) s.coefficients = regular_;
    const double dt = s.length = length_of(from, to);
    if (to == from) return s;
    Forcing<double> forcing = forcing_of(from, to, dt);
    if (forcing.holds() && !rate_from_slope_) return s;
    if (forcing.segments.size() > 1 || forcing.begun) s.after_bend = forcing.segments.back().length;
    s.rise = 1;
    s.forcing = std::make_shared<Forcing<double>>(std::move(forcing));
    if (s.coefficients == regular_) s.gains = gains_;
    return s;
}

// The last frame at or before t.
long long Timeline::frame_at(Instant t) const {
    long long k = static_cast<long long>(t.t / *schedule_.load.interval);
    while (frame_time(k + 1) <= t) ++k;
    while (k > 0 && t < frame_time(k)) --k;
    return std::min(k, schedule_.sequence->maps() - 1);
}

// One step within the interval between two frames; under parabolic hold it may queue another one before it.
Step Timeline::framed_step(Instant from, Instant to) {
    Step s;
    if (from < to) lead(from, to);
    s.time = to.t;
    s.begin = from;
    s.end = to;
    s.exact = true;
    s.length = length_of(from, to);
    if (regular(from, to)) s.coefficients = regular_;
    s.frame = frame_at(from);
    s.from = {s.frame, 0};
    s.to = {s.frame + 1, 0};
    s.jump = from == Instant(); // frame 0 meets a skin at rest
    if (s.frame + 1 == schedule_.sequence->maps()) return s;
    const Instant begin = frame_time(s.frame);
    const double length = frame_time(s.frame + 1) - begin;
    s.start = (from - begin) / length;
    s.rise = (to - from) / length;
    if (!schedule_.parabolic()) return s;
    s.from.second = s.start;
    if (to < frame_time(s.frame + 1)) s.to = {s.frame, (to - begin) / length};
    if (s.frame > 0) {
        s.led = led_;
        s.before = from - led_;
    }
    return s;
}

// Under parabolic hold, makes the state hold a pressure on the parabola of the step from `from` to `to`: any earlier
// one will do, but from one that is much closer than the step is long, roundings would grow.
void Timeline::lead(Instant from, Instant to) {
    const long long k = frame_at(from);
    if (!schedule_.parabolic() || k == 0 || k + 1 == schedule_.sequence->maps()) return;
    const bool on_it = led_ == frame_time(k - 1) || frame_time(k) <= led_;
    if (on_it && to - from <= 1.01 * (from - led_)) return;
    Step s = framed_step(from, from);
    s.from = {k - 1, 0};
    led_ = frame_time(k - 1);
    pending_.push_back(s);
}

// Baselines hold the load over the step at its value at the step's start.
Step Timeline::held_step(long long n) {
    Step s;
    s.coefficients = regular_;
    s.begin = output_time(n - 1);
    s.end = output_time(n);
    s.time = s.end.t;
    s.length = schedule_.time.step;
    s.start = load_.after(output_time(n - 1));
    s.jump = s.start - (n > 1 ? load_.after(output_time(n - 2)) : 0);
    if (method_ != Method::published) return s;
    // FA2[n] = (d[n+1] - d[n-1])/(2 dt), 0 at both ends, where d[n] is the rate at the start of step n.
    const Element& m = materials_.front();
    const double dt = schedule_.time.step;
    if (n == 1) rate_ = strain_rate(m, s.start);
    strain_ += rate_ * dt;
    const double rate_after = strain_rate(m, load_.after(output_time(n)), strain_);
    s.jump = n + 1 < schedule_.outputs ? (rate_after - rate_before_) / (2 * dt) : 0;
    rate_before_ = rate_;
    rate_ = rate_after;
    return s;
}

// Queues a step that does not change the state, for a field.
void Timeline::peek_field(Step step) {
    step.keep = false;
    step.field = int(field_++);
    pending_.push_back(step);
}

// Queues a step that does not change the state, and whose responses are the impulses of a jump.
void Timeline::peek_impulse(Step step, double before, double jump) {
    step.keep = false;
    step.impulse = impulses_++;
    auto forcing =
        step.forcing ? std::make_shared<Forcing<double>>(*step.forcing) : std::make_shared<Forcing<double>>();
    forcing->impulse = jump;
    forcing->before = before;
    forcing->framed = schedule_.sequence != nullptr;
    forcing->held = step.rise == 0;
    if (!schedule_.sequence) step.rise = 1;
    step.forcing = forcing;
    pending_.push_back(step);
}

// The time of the next field; infinity if there is none.
scene::Instant Timeline::next_field() const {
    return field_ < schedule_.field_times.size() ? schedule_.field_times[field_] : INFINITY;
}

// Queues the steps from frame to frame between two outputs, and the fields in between. Returns where the last one
// ends.
scene::Instant Timeline::fill_frames(Instant from, Instant to) {
    const std::vector<Instant>& fields = schedule_.field_times;
    if (from == Instant()) peek_impulse(framed_step(0, 0), 0, 1);
    const Instant last = std::isfinite(to.t) ? to : field_ < fields.size() ? fields.back() : from;
    while (from < last) {
        const long long k = frame_at(from);
        const Instant end = k + 1 < schedule_.sequence->maps() ? std::min(to, frame_time(k + 1)) : to;
        while (next_field() <= end && next_field() < to) peek_field(framed_step(from, next_field()));
        if (end == to || last <= end) break;
        pending_.push_back(framed_step(from, end));
        led_ = std::exchange(from, end);
    }
    return from;
}

// Queues the impulses of the envelope's jumps and the fields between two outputs.
void Timeline::fill_envelope(Instant from, Instant to) {
    const Instant end = std::min(to, Instant(schedule_.time.duration));
    for (; jump_ < jumps_.size() && jumps_[jump_].time < end; ++jump_) {
        const scene::Knot& k = jumps_[jump_];
        peek_impulse(exact_step(from, k.time), k.left, k.right - k.left);
    }
    while (next_field() < to) peek_field(exact_step(from, next_field()));
}

// Queues all steps after the previous output up to and including the next one.
void Timeline::fill() {
    const bool exact = method_ == Method::exact;
    const long long n = output_;
    Instant from = n > 0 ? output_time(n - 1) : Instant();
    const Instant to = n < schedule_.outputs ? output_time(n) : Instant(INFINITY);
    if (n > 0 && schedule_.sequence) {
        from = fill_frames(from, to);
    } else if (n > 0 && exact) {
        fill_envelope(from, to);
    }
    if (n < schedule_.outputs) {
        Step s;
        if (n == 0) s.coefficients = std::make_shared<CoefficientTable>(1); // zeros: at rest
        else s = exact ? exact_step(from, to) : held_step(n);
        s.trace = n;
        if (next_field() == to) s.field = int(field_++);
        pending_.push_back(s);
        led_ = from;
    }
    std::reverse(pending_.begin(), pending_.end());
    ++output_;
}

bool Timeline::next(Step& step) {
    scene::look();
    if (pending_.empty() && output_ <= schedule_.outputs) fill();
    if (pending_.empty()) return false;
    step = pending_.back();
    step.parabolic = schedule_.parabolic();
    pending_.pop_back();
    return true;
}

} // namespace dermis::model
