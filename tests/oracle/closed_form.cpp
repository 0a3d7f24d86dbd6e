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

PreparedPressure::PreparedPressure(Pressure pressure, const std::vector<Instant>& instants)
    : instants_(instants), wave_(std::move(pressure.wave)) {
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
        if (wave_) {
            auto [sine, cosine] = sine_and_cosine(wave_->angular * instant.time + wave_->phase);
            s.sine = std::move(sine);
            s.cosine = std::move(cosine);
        }
        states_.push_back(s);
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
    if (wave_) add_wave(all, m, adaptation);
    for (size_t i = 0; i < all.size(); ++i)
        if (instants_[i].time == Real(0)) all[i] = {};
    for (size_t i = 0; i < all.size(); ++i)
        if (const long since = instants_[i].since; since >= 0)
            all[i].acceleration =
                (all[i].rate - all[size_t(since)].rate) / (instants_[i].time - instants_[size_t(since)].time);
    return all;
}

// Adds the steady oscillation, and what decays of its beginning.
void PreparedPressure::add_wave(std::vector<Responses>& all, const Element& m,
                                const std::optional<Real>& adaptation) const {
    const bool elastic = m.viscosity == 0, creeping = m.modulus == 0;
    const Real &a = wave_->amplitude, &w = wave_->angular;
    const Real tau = elastic || creeping ? Real(0) : Real(m.viscosity) / Real(m.modulus);
    const Phasor turn{0, w}; // a derivative
    const Phasor strain = Phasor{m.modulus, w * m.viscosity}.inverse(), integral = strain * turn.inverse(),
                 rate = strain * turn, acceleration = rate * turn;
    const auto [sine, cosine] = sine_and_cosine(wave_->phase);
    const Real first = strain.at(sine, cosine), first_integral = integral.at(sine, cosine);
    const std::vector<Real> left =
        elastic ? std::vector<Real>(all.size()) : (creeping ? std::vector<Real>(all.size(), Real(1)) : decays(tau));
    const std::vector<Real> left_adapting = adaptation ? decays(*adaptation) : std::vector<Real>();
    for (size_t i = 0; i < all.size(); ++i) {
        const State& s = states_[i];
        const auto at = [&](const Phasor& p) { return p.at(s.sine, s.cosine); };
        Responses& r = all[i];
        const bool decays_itself = !elastic && !creeping;
        r.strain += a * (at(strain) - first * left[i]);
        r.rate += a * (decays_itself ? at(rate) + first * left[i] / tau : at(rate));
        r.acceleration += a * (decays_itself ? at(acceleration) - first * left[i] / (tau * tau) : at(acceleration));
        if (adaptation) {
            const Real& T = *adaptation;
            const Phasor adapted = strain * Phasor{T, 0} * Phasor{1, w * T}.inverse();
            const Real beside =
                creeping ? T * (Real(1) - left_adapting[i]) : tau * T * (left_adapting[i] - left[i]) / (T - tau);
            r.integral += a * (at(adapted) - adapted.at(sine, cosine) * left_adapting[i] - first * beside);
        } else {
            const Real beside = creeping ? instants_[i].time : tau * (Real(1) - left[i]);
            r.integral += a * (at(integral) - first_integral - first * beside);
        }
    }
}

} // namespace oracle
