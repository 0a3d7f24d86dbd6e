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

#define IN(K)                                                                                                          \
    template Forcing<K::real> forcing_over(const scene::Waveform&, scene::Instant, scene::Instant, K::real, bool);     \
    template void scale_change<K>(K::Coefficients&, K::real);                                                          \
    template void force<K>(K::Coefficients&, const Element&, const ResponseRule&, const Forcing<K::real>&);
IN(f64)
IN(extended)
#undef IN

} // namespace dermis::plan
