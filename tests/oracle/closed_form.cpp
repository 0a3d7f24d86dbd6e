// SPDX-License-Identifier: MIT
#include "tests/oracle/closed_form.hpp"

namespace oracle {
namespace {

// Factors of sine and cosine: of an oscillation, and of what a skin makes of it.
struct Phasor {
    Real sine, cosine;

    Real at(const Real& s, const Real& c) const { return sine * s + cosine * c; }
    friend Phasor operator*(const Phasor& a, const Phasor& b) {
        return {a.sine * b.sine - a.cosine * b.cosine, a.sine * b.cosine + a.cosine * b.sine};
    }
    friend Phasor operator+(const Phasor& a, const Phasor& b) { return {a.sine + b.sine, a.cosine + b.cosine}; }
    friend Phasor times(const Real& x, const Phasor& p) { return {x * p.sine, x * p.cosine}; }
    Phasor inverse() const {
        const Real square = sine * sine + cosine * cosine;
        return {sine / square, -cosine / square};
    }
};

// The adaptation time; moved by 2^-100 of itself where it is the retardation time, at which the formulas have a limit.
std::optional<Real> apart(const std::optional<double>& adaptation, const Element& m) {
    if (!adaptation) return {};
    Real time = *adaptation;
    if (time * m.modulus == Real(m.viscosity)) time = time * (Real(1) + Real::power_of_two(-100));
    return time;
}

} // namespace

PreparedPressure::PreparedPressure(Pressure pressure, const std::vector<Instant>& instants) : instants_(instants) {
    mpfr_set_emin(mpfr_get_emin_min()); // e^(t/tau) of any time is a number
    mpfr_set_emax(mpfr_get_emax_max());
    const std::vector<Knot>& knots = pressure.knots;
    size_t passed = 0;
    State s; // at `time`, beyond the jumps there
    Real time;
    const auto move = [&](const Real& to) {
        const Real d = to - time;
        s.second_integral +=
            s.integral * d + s.value * d * d / 2 + s.slope * d * d * d / 6 + s.bow * d * d * d * d / 24;
        s.integral += s.value * d + s.slope * d * d / 2 + s.bow * d * d * d / 6;
        s.value += s.slope * d + s.bow * d * d / 2;
        s.slope += s.bow * d;
        time = to;
    };
    for (const Instant& instant : instants) {
        for (; passed < knots.size() && knots[passed].time < instant.time; ++passed) {
            const Knot& k = knots[passed];
            move(k.time);
            Real slope;
            if (passed + 1 < knots.size()) {
                const Real length = knots[passed + 1].time - k.time;
                slope = (knots[passed + 1].left - k.right) / length - k.bow * length / 2;
            }
            jumps_.push_back({k.time, k.right - k.left, slope - s.slope, k.bow - s.bow});
            s.value = k.right;
            s.slope = slope;
            s.bow = k.bow;
        }
        move(instant.time);
        s.jumps = passed;
        states_.push_back(s);
    }
    for (const Wave& w : pressure.waves) {
        PreparedWave& of = waves_.emplace_back(PreparedWave{w, {}});
        for (const Instant& i : instants)
            of.at.push_back(w.start < i.time ? sine_and_cosine(w.angular * (i.time - w.start) + w.phase)
                                             : std::pair<Real, Real>());
    }
}

// e^(-t/T) at each instant t.
std::vector<Real> PreparedPressure::decays(const Real& T) const {
    std::vector<Real> all;
    Real power = 1, factor; // of the rows, which are whole multiples of the first one
    for (const Instant& i : instants_) {
        if (i.row == 1) factor = exp(-(i.time / T));
        if (i.row > 0) power *= factor;
        all.push_back(i.row >= 0 ? power : exp(-(i.time / T)));
    }
    return all;
}

// The same of the time since a start; 1 before it.
std::vector<Real> PreparedPressure::decays_from(const Real& start, const Real& T) const {
    if (start == Real(0)) return decays(T);
    std::vector<Real> all;
    for (const Instant& i : instants_) all.push_back(start < i.time ? exp(-((i.time - start) / T)) : Real(1));
    return all;
}

// The sum of (J - T*K + T*T*L)*e^(-(t - t_k)/T) over the jumps and bends before each instant t. Every exponent is
// negative: what is too small to be a number is 0.
std::vector<Real> PreparedPressure::sums(const Real& T) const {
    std::vector<Real> all;
    Real sum, of_row; // of_row: e^(-t/T) of the time from row to row
    size_t k = 0;
    for (size_t i = 0; i < instants_.size(); ++i) {
        const Instant& now = instants_[i];
        if (now.row == 1) of_row = exp(-(now.time / T));
        if (i > 0) {
            const Instant& before = instants_[i - 1];
            const bool next_row = now.row > 0 && before.row == now.row - 1;
            sum *= next_row ? of_row : exp(-((now.time - before.time) / T));
        }
        for (; k < states_[i].jumps; ++k)
            sum +=
                (jumps_[k].jump - T * (jumps_[k].bend - T * jumps_[k].bow)) * exp(-((now.time - jumps_[k].time) / T));
        all.push_back(sum);
    }
    return all;
}

std::vector<Responses> PreparedPressure::responses(const Element& m, const std::optional<double>& given) const {
    const bool elastic = m.viscosity == 0, creeping = m.modulus == 0;
    const Real E = m.modulus, eta = m.viscosity, tau = elastic || creeping ? Real(0) : eta / E;
    const std::optional<Real> adaptation = apart(given, m);
    const std::vector<Real> decaying = elastic || creeping ? std::vector<Real>(states_.size()) : sums(tau);
    const std::vector<Real> adapting = adaptation ? sums(*adaptation) : std::vector<Real>();
    std::vector<Responses> all(states_.size());
    for (size_t i = 0; i < states_.size(); ++i) {
        const State& s = states_[i];
        Responses& r = all[i];
        if (creeping) {
            r.strain = s.integral / eta;
            r.integral = s.second_integral / eta;
            r.rate = s.value / eta;
            r.acceleration = s.slope / eta;
        } else {
            r.strain = (s.value - tau * (s.slope - tau * s.bow) - decaying[i]) / E;
            r.integral = (s.integral - eta * r.strain) / E;
            r.rate = elastic ? s.slope / E : (s.slope - tau * s.bow) / E + decaying[i] / eta;
            if (!elastic) r.acceleration = s.bow / E - decaying[i] / (eta * tau);
        }
        if (!adaptation) continue;
        const Real& a = *adaptation;
        if (creeping) r.integral = a * (s.integral - a * (s.value - a * (s.slope - a * s.bow) - adapting[i])) / eta;
        else
            r.integral = a / E *
                         (s.value - (a + tau) * s.slope + (a * a + a * tau + tau * tau) * s.bow +
                          (tau * decaying[i] - a * adapting[i]) / (a - tau));
    }
    for (const PreparedWave& wave : waves_) add_wave(all, wave, m, adaptation);
    for (size_t i = 0; i < all.size(); ++i)
        if (instants_[i].time == Real(0)) all[i] = {};
    for (size_t i = 0; i < all.size(); ++i)
        if (const long since = instants_[i].since; since >= 0)
            all[i].acceleration =
                (all[i].rate - all[size_t(since)].rate) / (instants_[i].time - instants_[size_t(since)].time);
    return all;
}

// Adds the steady oscillation, and what decays of its beginning. What grows in proportion to the time is the derivative
// of an oscillation e^(x d) by x at x = i*angular, of H and of the decaying part too.
void PreparedPressure::add_wave(std::vector<Responses>& all, const PreparedWave& of, const Element& m,
                                const std::optional<Real>& adaptation) const {
    const bool elastic = m.viscosity == 0, creeping = m.modulus == 0, decays_itself = !elastic && !creeping;
    const Real &a = of.wave.amplitude, &w = of.wave.angular, &g = of.wave.growth, &start = of.wave.start;
    const Real tau = elastic || creeping ? Real(0) : Real(m.viscosity) / Real(m.modulus);
    const Phasor turn{0, w}, per_turn = turn.inverse(); // a derivative, an integral
    const Phasor H = Phasor{m.modulus, w * m.viscosity}.inverse(), slope = Phasor{-Real(m.viscosity), 0} * H * H;
    const auto [sine, cosine] = sine_and_cosine(of.wave.phase);
    const auto begin = [&, sine = sine, cosine = cosine](const Phasor& p) { return p.at(sine, cosine); };
    const Phasor steady = times(a, H) + times(g, slope); // beside what grows, g*H*d
    const Real first = begin(steady);
    const std::vector<Real> left = elastic    ? std::vector<Real>(all.size())
                                   : creeping ? std::vector<Real>(all.size(), Real(1))
                                              : decays_from(start, tau);
    const std::vector<Real> left_adapting = adaptation ? decays_from(start, *adaptation) : std::vector<Real>();
    for (size_t i = 0; i < all.size(); ++i) {
        const Real d = instants_[i].time - start;
        if (!(Real(0) < d)) continue;
        const auto at = [&](const Phasor& p) { return p.at(of.at[i].first, of.at[i].second); };
        const Phasor now = steady + times(g * d, H), grows = times(g, H);
        Responses& r = all[i];
        r.strain += at(now) - first * left[i];
        r.rate += at(turn * now + grows);
        r.acceleration += at(turn * (turn * now + times(Real(2), grows)));
        if (decays_itself) r.rate += first * left[i] / tau;
        if (decays_itself) r.acceleration += -(first * left[i] / (tau * tau));
        if (adaptation) {
            const Real& T = *adaptation;
            const Phasor G = Phasor{T, 0} * Phasor{1, w * T}.inverse(), after = G * steady + times(-g, G * G * H);
            const Real beside =
                creeping ? T * (Real(1) - left_adapting[i]) : tau * T * (left_adapting[i] - left[i]) / (T - tau);
            r.integral += at(after + times(g * d, G * H)) - begin(after) * left_adapting[i] - first * beside;
        } else {
            const Phasor after = steady * per_turn + times(-g, H * per_turn * per_turn);
            const Real beside = creeping ? d : tau * (Real(1) - left[i]);
            r.integral += at(after + times(g * d, H * per_turn)) - begin(after) - first * beside;
        }
    }
}

} // namespace oracle
