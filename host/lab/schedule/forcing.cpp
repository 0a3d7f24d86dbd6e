// SPDX-License-Identifier: MIT
#include "host/lab/schedule/forcing.hpp"

#include "host/core/model/coefficients_in.hpp"
#include "host/lab/schedule/extended.hpp"

#include <algorithm>

namespace dermis::model {

namespace {

// The part of a step between two instants, without a knot in between, length seconds apart.
template <class T>
Segment<T> segment_of(const scene::Waveform& load, scene::Instant from, scene::Instant to, T u0, T length) {
    if (!load.wave()) return {length, u0, load.rise<T>(from, to), {}};
    const T weight = load.weight<T>(from), rise = load.weight_rise<T>(from, to);
    if (weight == 0 && rise == 0) return {length, u0, 0, {}};
    const scene::Instant time(double(length), double(length - double(length)));
    return {length, u0, load.mean() * rise,
            Sine<T>{.w = load.angular_frequency<T>(),
                    .start = load.phasor<T>(from),
                    .turn = load.turn<T>(time),
                    .weight = weight,
                    .slope = rise / length}};
}

// Splits a step at the envelope's breakpoints, from `first` on.
template <class T>
std::vector<Segment<T>> segments_of(const scene::Waveform& load, scene::Instant from, scene::Instant first,
                                    scene::Instant to) {
    auto knot = std::ranges::upper_bound(load.knots(), first, std::less<scene::Instant>(), &scene::Knot::time);
    std::vector<Segment<T>> segments;
    for (scene::Instant begin = first; begin < to;) {
        const scene::Instant end = knot == load.knots().end() ? to : std::min(to, (knot++)->time);
        const T u0 = load.after<T>(begin) - load.after<T>(from);
        segments.push_back(segment_of<T>(load, begin, end, u0, scene::difference<T>(end, begin)));
        begin = end;
    }
    return segments;
}

// The product of complex numbers. The operator of std::complex looks for NaN, and calls a function.
template <class T> std::complex<T> product(std::complex<T> a, std::complex<T> b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}
template <class T> T real_product(std::complex<T> a, std::complex<T> b) {
    return a.real() * b.real() - a.imag() * b.imag();
}

// Returns 1/(real + i*imaginary) of numbers >= 0 that are not both 0. Neither is squared, so that nothing overflows.
template <class T> std::complex<T> reciprocal(T real, T imaginary) {
    const bool wide = real >= imaginary;
    const T greater = wide ? real : imaginary, less = wide ? imaginary : real;
    const T ratio = less / greater, share = 1 / (greater + less * ratio), other = ratio * share;
    return {wide ? share : other, wide ? -other : -share};
}

// Writes the factors of ds under a sine. Each is the real part of its gain times the phasor at the start, over i.
template <class To, class T> void force_sine(To& k, const SineGains<T>& gains, std::complex<T> start) {
    using real = decltype(k.f);
    const std::complex<T> over_i(start.imag(), -start.real());
    k.f = real(real_product(gains.f, over_i));
    k.i2 = real(real_product(gains.i2, over_i));
    k.v1 = real(real_product(gains.v1, over_i));
    k.a1 = real(real_product(gains.a1, over_i));
}

// The gains of a sine that grows in proportion to the time within the step, whose factors at the step's start are 0.
// Each is the derivative of a gain of sine_gains() by i*w, of which the pressure at the start is independent.
template <class K, class T = typename K::real>
SineGains<T> gains_of_growth(const typename K::Coefficients& held, const Element& m, const ResponseRule& rule, T w,
                             std::complex<T> turn, T dt) {
    const T modulus = m.modulus, viscosity = m.viscosity;
    const std::complex<T> iw(0, w),
        grown = dt * turn, compliance = reciprocal<T>(modulus, w * viscosity),
        slope = -viscosity * product(compliance, compliance), leaky = reciprocal<T>(1 / T(rule.sa2_adaptation), w),
        sum = product(compliance, leaky), sum_slope = product(slope, leaky) - product(sum, leaky);
    const T left = held.v0 * viscosity;
    SineGains<T> gains;
    gains.f = product(slope, turn - left) + product(compliance, grown);
    gains.i2 = product(sum_slope, turn - (1 - held.leak)) + product(sum, grown) - slope * held.i0;
    gains.v1 = product(slope, product(iw, turn) + modulus * held.v0) + product(compliance, turn + product(iw, grown));
    gains.a1 = rule.step_mean ? gains.v1 / dt
                              : product(slope, held.E * held.a0 - w * w * turn) +
                                    product(compliance, T(2) * product(iw, turn) - w * w * grown);
    return gains;
}

// Turns the coefficients under a load that is held into the coefficients under a segment.
template <class K, class T = typename K::real>
void force_segment(typename K::Coefficients& k, const Element& m, const ResponseRule& rule, const Segment<T>& s) {
    const typename K::Coefficients held = k;
    scale_change<K>(k, s.du);
    if (!s.wave) return;
    typename K::Coefficients wave{};
    const auto add = [&](const SineGains<T>& gains, T factor) {
        force_sine<typename K::Coefficients, T>(wave, gains, s.wave->start);
        for (auto of : {&K::Coefficients::f, &K::Coefficients::i2, &K::Coefficients::v1, &K::Coefficients::a1})
            k.*of += factor * (wave.*of);
    };
    add(sine_gains<K, T>(held, m, rule, s.wave->w, s.wave->turn, s.length), s.wave->weight);
    if (s.wave->slope != 0) add(gains_of_growth<K, T>(held, m, rule, s.wave->w, s.wave->turn, s.length), s.wave->slope);
}

// What segments lead an element to.
template <class T> struct Composed { T eps, sum, rate, acceleration; };

template <class K, class T = typename K::real>
Composed<T> composed(const Element& element, const ResponseRule& rule, std::span<const Segment<T>> segments,
                     const Begun& begun) {
    const ResponseRule density{.sa2_adaptation = rule.sa2_adaptation, .step_mean = false};
    T eps = begun.strain, sum = begun.integral, rate = 0, acceleration = 0;
    for (const Segment<T>& s : segments) {
        auto of = exact_coefficients_in<K>(element, density, s.length);
        if (s.wave) force_segment<K>(of, element, density, s);
        const auto k = K::lanes_of(of);
        const auto load = K::load(s.u0, s.wave ? 1 : s.du, 0);
        rate = K::rate_after(eps, load, k);
        acceleration = K::acceleration_after(eps, load, k);
        sum += K::integral_step(K::integral_gained(eps, load, k), sum, k);
        eps += K::strain_step(eps, load, k);
    }
    return {eps, sum, rate, acceleration};
}

// Composes a step of its segments.
template <class K, class T = typename K::real>
void force_segments(typename K::Coefficients& whole, const Element& element, const ResponseRule& rule,
                    const Forcing<T>& forcing, const Begun& begun) {
    if (forcing.segments.size() == 1 && !forcing.begun)
        return force_segment<K>(whole, element, rule, forcing.segments[0]);
    const Composed<T> all = composed<K>(element, rule, std::span<const Segment<T>>(forcing.segments), begun);
    whole.f = all.eps;
    whole.i2 = all.sum;
    whole.v1 = all.rate;
    whole.a1 = rule.step_mean ? all.rate / forcing.dt : all.acceleration;
}

// Turns the coefficients of a step into those of a jump at its end: the responses become the jump's impulses. whole:
// the pressure of the step is the jump; held: the load does not change before it.
template <class K>
void force_impulse(typename K::Coefficients& k, const Element& m, double jump, bool whole, bool held) {
    const double fa1 = is_elastic(m) ? final_strain(m, jump) : 0, fa2 = is_elastic(m) ? 0 : strain_rate(m, jump);
    if (held) k.f = k.i2 = 0;
    k.v0 = whole ? fa1 : 0; // r = sj = the pressure
    k.v1 = whole ? 0 : fa1;
    k.a0 = 0;
    k.a1 = whole ? 0 : fa2;
    k.a2 = whole ? fa2 : 0;
}

} // namespace

template <class T>
Forcing<T> forcing_over(const scene::Waveform& load, scene::Instant from, scene::Instant to, T dt, bool with_slope,
                        scene::Instant first) {
    Forcing<T> forcing;
    forcing.dt = dt;
    if (load.sine()) {
        const scene::Instant length(double(dt), double(dt - double(dt)));
        forcing.sine = Sine<T>{load.angular_frequency<T>(), load.phasor<T>(from), load.turn<T>(length)};
    } else if (load.breaks(from, to)) {
        forcing.segments = segments_of<T>(load, from, first, to);
    } else {
        forcing.segments = {segment_of<T>(load, from, to, 0, dt)};
    }
    if (with_slope) {
        forcing.slope = load.slope_before<T>(from);
        forcing.slope_length = scene::difference<T>(to, from);
    }
    return forcing;
}

Begun after_segments(const Element& element, const ResponseRule& rule, std::span<const Segment<double>> segments,
                     const Begun& begun) {
    const Composed<double> all = composed<f64>(element, rule, segments, begun);
    return {all.eps, all.sum};
}

template <class K> void scale_change(typename K::Coefficients& k, typename K::real du) {
    for (auto* factor : {&k.f, &k.i2, &k.v1, &k.a1}) *factor *= du;
}

// A sine's effect is its steady-state response, less what has not decayed of the steady state at the step's start, less
// the effect of the pressure at the step's start, which the coefficients contain already.
template <class K, class T>
SineGains<T> sine_gains(const typename K::Coefficients& held, const Element& m, const ResponseRule& rule, T w,
                        std::complex<T> turn, T dt) {
    const T modulus = m.modulus, viscosity = m.viscosity;
    const std::complex<T> compliance = reciprocal<T>(modulus, w * viscosity),
                          rate_of_turn(-w * turn.imag(), w * turn.real());
    const T left = held.v0 * viscosity; // e^-z, the factor by which a strain decays over the step
    SineGains<T> gains;
    gains.f = product(compliance, turn - left) - held.b;
    const std::complex<T> sum = product(compliance, reciprocal<T>(1 / T(rule.sa2_adaptation), w));
    gains.i2 = (product(sum, turn - (1 - held.leak)) - compliance * held.i0) - held.i1;
    gains.v1 = product(compliance, rate_of_turn + modulus * held.v0) - held.v0;
    gains.a1 = rule.step_mean ? gains.v1 / dt : product(compliance, held.E * held.a0 - w * w * turn) - held.a0;
    return gains;
}
template SineGains<double> sine_gains<f64>(const f64::Coefficients&, const Element&, const ResponseRule&, double,
                                           std::complex<double>, double);

template <class K>
void force(typename K::Coefficients& k, const Element& m, const ResponseRule& rule,
           const Forcing<typename K::real>& forcing, const SineGains<typename K::real>* known, const Begun& begun) {
    using T = typename K::real;
    if (const auto& sine = forcing.sine)
        force_sine<typename K::Coefficients, T>(
            k, known ? *known : sine_gains<K, T>(k, m, rule, sine->w, sine->turn, forcing.dt), sine->start);
    else if (!forcing.segments.empty()) force_segments<K>(k, m, rule, forcing, begun);
    if (forcing.slope && is_elastic(m)) k.a1 = (k.v1 - *forcing.slope / m.modulus) / forcing.slope_length;
    if (forcing.impulse) force_impulse<K>(k, m, *forcing.impulse, forcing.framed, forcing.held);
}

template <class K>
void fill_row_of_sine(const std::vector<f64::Coefficients>& held, const std::vector<SineGains<double>>& gains,
                      const int* material, int cells, const Forcing<double>& forcing, typename K::Coefficients* row) {
    const bool shared = held.size() == 1;
    for (int i = 0; i < cells; ++i) {
        const size_t of = size_t(material[i]);
        row[i] = rounded<K>(held[shared ? 0 : of]);
        force_sine(row[i], gains[of], forcing.sine->start);
    }
}
template void fill_row_of_sine<f32>(const std::vector<f64::Coefficients>&, const std::vector<SineGains<double>>&,
                                    const int*, int, const Forcing<double>&, f32::Coefficients*);
template void fill_row_of_sine<f64>(const std::vector<f64::Coefficients>&, const std::vector<SineGains<double>>&,
                                    const int*, int, const Forcing<double>&, f64::Coefficients*);

#define IN(K)                                                                                                          \
    template Forcing<K::real> forcing_over(const scene::Waveform&, scene::Instant, scene::Instant, K::real, bool,      \
                                           scene::Instant);                                                            \
    template void scale_change<K>(K::Coefficients&, K::real);                                                          \
    template void force<K>(K::Coefficients&, const Element&, const ResponseRule&, const Forcing<K::real>&,             \
                           const SineGains<K::real>*, const Begun&);
IN(f64)
IN(extended)
#undef IN

} // namespace dermis::model
