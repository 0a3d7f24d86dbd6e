// SPDX-License-Identifier: MIT
#include "host/lab/scenes/waveform.hpp"

#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"
#include "host/lab/scenes/keys.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dermis::scene {
namespace {

std::vector<Knot> knots_of(const Envelope::Window& w) {
    std::vector<Knot> knots;
    if (w.rise > 0) knots = {{w.start, 0, 0}, {Instant(w.start) + w.rise, 1, 1}};
    else knots = {{w.start, 0, 1}};
    if (w.until) knots.push_back({*w.until, 1, w.fall > 0 ? 1.0 : 0.0});
    if (w.fall > 0) knots.push_back({Instant(*w.until) + w.fall, 0, 0});
    return knots;
}

// Of a sine with a window, these are the window's.
std::vector<Knot> knots_of(const Envelope& e, const Time& time) {
    if (e.window) return knots_of(*e.window);
    std::vector<Knot> knots;
    switch (e.kind) {
    case Envelope::Kind::step: knots = {{e.start, 0, 1}}; break;
    case Envelope::Kind::ramp: knots = {{e.start, 0, 0}, {Instant(e.start) + e.rise, 1, 1}}; break;
    case Envelope::Kind::sine: knots = {{0, 0, e.mean + e.amplitude * std::sin(e.phase)}}; break;
    case Envelope::Kind::pulse:
        for (double k = 0; e.start + k * e.period <= time.duration; ++k) {
            const Instant begin = Instant::multiple(k, e.period) + e.start;
            knots.push_back({begin, 0, 1});
            knots.push_back({begin + e.length, 1, 0});
        }
        break;
    case Envelope::Kind::table:
        for (size_t i = 0; i < e.times.size(); ++i) {
            if (i > 0 && e.times[i] == e.times[i - 1])
                knots.back().right = e.values[i]; // A time given twice is a jump.
            else knots.push_back({e.times[i], i > 0 ? e.values[i] : 0, e.values[i]});
        }
        break;
    }
    return knots;
}

// Returns the first knot at or after t.
std::vector<Knot>::const_iterator knot_from(const std::vector<Knot>& knots, const Instant& t) {
    return std::ranges::lower_bound(knots, t, std::less<Instant>(), &Knot::time);
}

// Returns the first knot after t.
std::vector<Knot>::const_iterator knot_after(const std::vector<Knot>& knots, const Instant& t) {
    return std::ranges::upper_bound(knots, t, std::less<Instant>(), &Knot::time);
}

// Functions of the straight lines between knots, as the members of Waveform.

bool rests(const std::vector<Knot>& knots, Instant t) { return knots.empty() || t <= knots.front().time; }

template <class T> T value_before(const std::vector<Knot>& knots, Instant t) {
    if (rests(knots, t)) return 0;
    const auto next = knot_from(knots, t);
    const Knot& last = *(next - 1);
    if (next == knots.end()) return last.right;
    if (next->time == t) return next->left;
    const T share = difference<T>(t, last.time) / difference<T>(next->time, last.time);
    return last.right + (T(next->left) - last.right) * share;
}

template <class T> T value_after(const std::vector<Knot>& knots, Instant t) {
    const auto at = knot_from(knots, t);
    return at != knots.end() && at->time == t ? T(at->right) : value_before<T>(knots, t);
}

template <class T> T slope_of(const std::vector<Knot>& knots, Instant t) {
    if (rests(knots, t)) return 0;
    const auto next = knot_from(knots, t);
    if (next == knots.end()) return 0;
    return (T(next->left) - (next - 1)->right) / difference<T>(next->time, (next - 1)->time);
}

template <class T> T rise_of(const std::vector<Knot>& knots, Instant from, Instant to) {
    const auto next = knot_after(knots, from);
    if (next == knots.begin() || next == knots.end()) return 0;
    const Knot& last = *(next - 1);
    // The difference of two values would lose the digits that they share.
    return (T(next->left) - last.right) * (difference<T>(to, from) / difference<T>(next->time, last.time));
}

} // namespace

Waveform::Waveform(const Envelope& envelope, const Time& time) : envelope_(envelope), knots_(knots_of(envelope, time)) {
    for (Knot& k : knots_) k.time = snapped(k.time, time.step);
    if (!wave() || !envelope.window) return;
    weights_ = knots_;
    for (Knot& k : knots_) {
        const double now = carrier<double>(k.time);
        k.left *= now;
        k.right *= now;
    }
}

template <class T> T Waveform::angular_frequency() const { return 2 * std::numbers::pi_v<T> * T(envelope_.frequency); }

template <class T> std::complex<T> Waveform::turn(Instant time) const {
    const double f = envelope_.frequency, cycles = f * time.t;
    const T part = std::fma(f, time.t, -cycles) + T(f) * time.rest; // what rounding has left out
    return std::polar(T(1), 2 * std::numbers::pi_v<T> * ((cycles - std::nearbyint(cycles)) + part));
}

template <class T> std::complex<T> Waveform::phasor(Instant time) const {
    return T(envelope_.amplitude) * std::polar(T(1), T(envelope_.phase)) * turn<T>(time);
}

template <class T> T Waveform::carrier(Instant t) const { return envelope_.mean + phasor<T>(t).imag(); }

template <class T> T Waveform::weight(Instant t) const { return value_after<T>(weights_, t); }

template <class T> T Waveform::weight_rise(Instant from, Instant to) const { return rise_of<T>(weights_, from, to); }

template <class T> T Waveform::before(Instant t) const {
    if (!wave()) return value_before<T>(knots_, t);
    if (rests(knots_, t)) return 0;
    return weights_.empty() ? carrier<T>(t) : value_before<T>(weights_, t) * carrier<T>(t);
}

template <class T> T Waveform::after(Instant t) const {
    if (!wave()) return value_after<T>(knots_, t);
    if (t < knots_.front().time) return 0;
    return weights_.empty() ? carrier<T>(t) : weight<T>(t) * carrier<T>(t);
}

template <class T> T Waveform::slope_before(Instant t) const {
    if (!wave()) return slope_of<T>(knots_, t);
    if (rests(knots_, t)) return 0;
    const T slope = angular_frequency<T>() * phasor<T>(t).real();
    return weights_.empty() ? slope : value_before<T>(weights_, t) * slope + slope_of<T>(weights_, t) * carrier<T>(t);
}

template <class T> T Waveform::rise(Instant from, Instant to) const {
    return wave() ? before<T>(to) - after<T>(from) : rise_of<T>(knots_, from, to);
}

#define IN(T)                                                                                                          \
    template T Waveform::before(Instant) const;                                                                        \
    template T Waveform::after(Instant) const;                                                                         \
    template T Waveform::slope_before(Instant) const;                                                                  \
    template T Waveform::rise(Instant, Instant) const;                                                                 \
    template T Waveform::weight(Instant) const;                                                                        \
    template T Waveform::weight_rise(Instant, Instant) const;                                                          \
    template T Waveform::angular_frequency() const;                                                                    \
    template std::complex<T> Waveform::turn(Instant) const;                                                            \
    template std::complex<T> Waveform::phasor(Instant) const;
IN(double)
IN(long double)
#undef IN

bool Waveform::breaks(Instant from, Instant to) const {
    const auto next = knot_after(knots_, from);
    return next != knots_.end() && next->time < to;
}

namespace {

void check_window(const Envelope& e) {
    const Envelope::Window& w = *e.window;
    if (e.kind != Envelope::Kind::sine && (e.kind != Envelope::Kind::step || e.start != 0))
        refuse("load.window", "(given)", "only with load.envelope = \"sine\" or a step from t = 0 on");
    check_rows("load.window.", w);
    const double risen = w.start + w.rise;
    need(!w.until || (finite(*w.until) && *w.until > risen), "load.window.until", w.until.value_or(0),
         "a finite number > load.window.start + load.window.rise = " + shortest(risen));
    need(w.until || w.fall == 0, "load.window.fall", w.fall, "only with load.window.until");
}

} // namespace

void check_envelope(const Envelope& e, const Time& time) {
    check_rows("load.", e);
    if (e.window) check_window(e);
    if (e.kind == Envelope::Kind::pulse) {
        need(e.period > e.length, "load.period", e.period, "a finite number > load.length");
        need(time.duration / e.period <= 1e6, "load.period", e.period, "at most 1e6 pulses within time.duration");
    }
    if (e.kind == Envelope::Kind::table) {
        need(!e.times.empty(), "load.times", 0, "at least one time");
        need(e.values.size() == e.times.size(), "load.values", double(e.values.size()), "as many values as load.times");
        for (size_t i = 0; i < e.times.size(); ++i) {
            need(i == 0 || e.times[i] >= e.times[i - 1], "load.times", e.times[i],
                 "ascending times; twice the same for a jump");
            need(i < 2 || e.times[i] != e.times[i - 2], "load.times", e.times[i], "each time at most twice");
        }
    }
    const std::vector<Knot> knots = knots_of(e, time);
    for (size_t i = 1; i < knots.size(); ++i) {
        const char* parameter = e.window                          ? "load.window"
                                : e.kind == Envelope::Kind::ramp  ? "load.rise"
                                : e.kind == Envelope::Kind::pulse ? "load.length"
                                                                  : "load.times";
        need(knots[i].time - knots[i - 1].time > 1e-5 * time.step, parameter, knots[i].time - knots[i - 1].time,
             "breakpoints of the load more than 1e-5 of time.step apart");
    }
}

} // namespace dermis::scene
