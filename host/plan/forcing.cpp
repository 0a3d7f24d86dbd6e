// SPDX-License-Identifier: MIT
#include "host/plan/forcing.hpp"

#include <algorithm>
#include <cmath>

namespace dermis::plan {

namespace {

// Splits a step at the envelope's breakpoints.
template <class T>
std::vector<Segment<T>> segments_of(const scene::Waveform& load, scene::Instant from, scene::Instant to) {
    const auto later = [](const scene::Instant& t, const scene::Knot& k) { return t < k.time; };
    auto knot = std::upper_bound(load.knots().begin(), load.knots().end(), from, later);
    std::vector<Segment<T>> segments;
    for (scene::Instant begin = from; begin < to;) {
        const scene::Instant end = knot == load.knots().end() ? to : std::min(to, (knot++)->time);
        const T u0 = load.after<T>(begin) - load.after<T>(from);
        segments.push_back({scene::difference<T>(end, begin), u0, load.rise<T>(begin, end)});
        begin = end;
    }
    return segments;
}

template <class K, class T = typename K::real>
void force_straight(typename K::Coefficients& whole, const Element& element, const ResponseRule& rule,
                    const std::vector<Segment<T>>& segments, T dt) {
    if (segments.size() == 1) return scale_change<K>(whole, segments[0].du);
    const ResponseRule density{.sa2_adaptation = rule.sa2_adaptation, .step_mean = false};
    T eps = 0, sum = 0, rate = 0, acceleration = 0;
    for (const Segment<T>& s : segments) {
        const auto k = K::lanes_of(exact_coefficients_in<K>(element, density, s.length));
        const auto load = K::load(s.u0, s.du, 0);
        rate = K::rate_after(eps, load, k);
        acceleration = K::acceleration_after(eps, load, k);
        sum += K::integral_step(K::integral_gained(eps, load, k), sum, k);
        eps += K::strain_step(eps, load, k);
    }
    whole.f = eps;
    whole.i2 = sum;
    whole.v1 = rate;
    whole.a1 = rule.step_mean ? rate / dt : acceleration;
}

// The product of complex numbers. That of std::complex looks for NaN, and calls a function.
template <class T> std::complex<T> product(std::complex<T> a, std::complex<T> b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}
template <class T> T real_product(std::complex<T> a, std::complex<T> b) {
    return a.real() * b.real() - a.imag() * b.imag();
}

// Returns 1/(real + i*imaginary) of numbers >= 0 of which one is not 0. None is squared, and so nothing overflows.
template <class T> std::complex<T> reciprocal(T real, T imaginary) {
    const bool wide = real >= imaginary;
    const T greater = wide ? real : imaginary, less = wide ? imaginary : real;
    const T ratio = less / greater, share = 1 / (greater + less * ratio), other = ratio * share;
    return {wide ? share : other, wide ? -other : -share};
}

// Makes of the coefficients of a load that is held those under a sine: its steady-state response, less the decayed rest
// of its value at the step's start.
template <class K> class SineForce {
  public:
    using T = typename K::real;
    SineForce(const Sine<T>& s, const ResponseRule& rule, T dt)
        : w_(s.w), dt_(dt), start_(s.start.imag(), -s.start.real()), turn_(s.turn),
          rate_of_turn_(-s.w * s.turn.imag(), s.w * s.turn.real()),
          sum_(reciprocal<T>(1 / T(rule.sa2_adaptation), s.w)), step_mean_(rule.step_mean) {}

    [[gnu::always_inline]] void force(typename K::Coefficients& k, const Element& m) const {
        const T modulus = m.modulus, viscosity = m.viscosity;
        const std::complex<T> compliance = reciprocal<T>(modulus, w_ * viscosity), eps0 = product(start_, compliance),
                              sum0 = product(eps0, sum_);
        const T left = k.v0 * viscosity; // e^-z, the factor by which a strain decays over the step
        const T wave = start_.real();    // the held pressure, whose effect the coefficients contain: subtracted
        k.f = real_product<T>(eps0, {turn_.real() - left, turn_.imag()}) - k.b * wave;
        k.i2 = (real_product<T>(sum0, {turn_.real() - (1 - k.leak), turn_.imag()}) - eps0.real() * k.i0) - k.i1 * wave;
        k.v1 = real_product<T>(eps0, {rate_of_turn_.real() + modulus * k.v0, rate_of_turn_.imag()}) - k.v0 * wave;
        const T acceleration =
            real_product<T>(eps0, {-w_ * w_ * turn_.real() + k.E * k.a0, -w_ * w_ * turn_.imag()}) - k.a0 * wave;
        k.a1 = step_mean_ ? k.v1 / dt_ : acceleration;
    }

  private:
    T w_, dt_;
    std::complex<T> start_, turn_, rate_of_turn_; // start_: over i; rate_of_turn_: i w turn
    std::complex<T> sum_;                         // by which the integral follows from a strain
    bool step_mean_;
};

// Writes the impulses of a jump. whole: the pressure of the step is the jump; held: the load does not change before it.
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
Forcing<T> forcing_over(const scene::Waveform& load, scene::Instant from, scene::Instant to, T dt, bool with_slope) {
    Forcing<T> forcing;
    forcing.dt = dt;
    if (load.sine()) {
        const scene::Instant length(double(dt), double(dt - double(dt)));
        forcing.sine = Sine<T>{load.angular_frequency<T>(), load.phasor<T>(from), load.turn<T>(length)};
    } else if (load.breaks(from, to)) {
        forcing.segments = segments_of<T>(load, from, to);
    } else {
        forcing.segments = {{dt, 0, load.rise<T>(from, to)}};
    }
    if (with_slope) {
        forcing.slope = load.slope_before<T>(from);
        forcing.slope_length = scene::difference<T>(to, from);
    }
    return forcing;
}

template <class K> void scale_change(typename K::Coefficients& k, typename K::real du) {
    for (auto* factor : {&k.f, &k.i2, &k.v1, &k.a1}) *factor *= du;
}

template <class K>
void force(typename K::Coefficients& k, const Element& m, const ResponseRule& rule,
           const Forcing<typename K::real>& forcing) {
    if (forcing.sine) SineForce<K>(*forcing.sine, rule, forcing.dt).force(k, m);
    else if (!forcing.segments.empty()) force_straight<K>(k, m, rule, forcing.segments, forcing.dt);
    if (forcing.slope && is_elastic(m)) k.a1 = (k.v1 - *forcing.slope / m.modulus) / forcing.slope_length;
    if (forcing.impulse) force_impulse<K>(k, m, *forcing.impulse, forcing.framed, forcing.held);
}

template <class K>
void fill_row_of_sine(const std::vector<f64::Coefficients>& held, const std::vector<Element>& materials,
                      const int* material, int cells, const ResponseRule& rule, const Forcing<double>& forcing,
                      typename K::Coefficients* row) {
    const SineForce<f64> sine(*forcing.sine, rule, forcing.dt);
    for (int i = 0; i < cells; ++i) {
        const size_t of = size_t(material[i]);
        f64::Coefficients k = held[held.size() == 1 ? 0 : of];
        sine.force(k, materials[of]);
        row[i] = rounded<K>(k);
    }
}
template void fill_row_of_sine<f32>(const std::vector<f64::Coefficients>&, const std::vector<Element>&, const int*, int,
                                    const ResponseRule&, const Forcing<double>&, f32::Coefficients*);
template void fill_row_of_sine<f64>(const std::vector<f64::Coefficients>&, const std::vector<Element>&, const int*, int,
                                    const ResponseRule&, const Forcing<double>&, f64::Coefficients*);

#define IN(K)                                                                                                          \
    template Forcing<K::real> forcing_over(const scene::Waveform&, scene::Instant, scene::Instant, K::real, bool);     \
    template void scale_change<K>(K::Coefficients&, K::real);                                                          \
    template void force<K>(K::Coefficients&, const Element&, const ResponseRule&, const Forcing<K::real>&);
IN(f64)
IN(extended)
#undef IN

} // namespace dermis::plan
