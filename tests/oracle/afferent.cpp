// SPDX-License-Identifier: MIT
#include "tests/oracle/afferent.hpp"

#include "tests/oracle/draw.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>

namespace oracle {

using dermis::AfferentModel;

namespace {

using Series = std::vector<Real>; // the factor of u^k for each k; u runs from 0 to 1 over a cell

Real at(const Series& p, const Real& u) {
    Real sum;
    for (size_t k = p.size(); k-- > 0;) {
        sum *= u;
        sum += p[k];
    }
    return sum;
}

// Whether the first factor, not 0, outweighs all others of the other sign: then the series has no root in [0, 1].
bool keeps_sign(const Series& p) {
    const Real zero;
    const bool positive = zero < p[0];
    Real least = p[0];
    for (size_t k = 1; k < p.size(); ++k)
        if (positive ? p[k] < zero : zero < p[k]) least += p[k];
    return positive ? zero < least : least < zero;
}

// The same polynomial by its Bernstein coefficients over [0, 1].
Series bernstein(const Series& p) {
    Series b = p;
    const size_t n = p.size() - 1;
    Real choose = 1; // n over k
    for (size_t k = 1; k <= n; ++k) {
        choose = choose * double(n + 1 - k) / double(k);
        b[k] = b[k] / choose;
    }
    for (size_t r = 1; r <= n; ++r)
        for (size_t k = n; k >= r; --k) b[k] += b[k - 1];
    return b;
}

// Cuts [0, 1] in the middle (de Casteljau): returns the coefficients of the first half and leaves those of the second.
Series first_half(Series& b) {
    const Real half = 0.5;
    Series first;
    for (size_t left = b.size(); left > 0; --left) {
        first.push_back(b[0]);
        for (size_t k = 0; k + 1 < left; ++k) {
            b[k] += b[k + 1];
            b[k] *= half;
        }
    }
    return first;
}

int sign_changes(const Series& b) {
    const Real zero;
    int changes = 0, last = 0;
    for (const Real& x : b) {
        const int sign = x < zero ? -1 : zero < x ? 1 : 0;
        if (sign != 0 && last != 0 && sign != last) ++changes;
        if (sign != 0) last = sign;
    }
    return changes;
}

// The one root between low and high. `positive`: of the polynomial next to low.
Real refined(const Series& p, bool positive, Real low, Real high) {
    const Real zero, close = Real::power_of_two(20 - Real::bits);
    Real u = (low + high) * 0.5;
    for (long i = 0; i < 4 * Real::bits; ++i) {
        Real value, slope;
        for (size_t k = p.size(); k-- > 0;) {
            slope *= u;
            slope += value;
            value *= u;
            value += p[k];
        }
        if (value == zero) return u;
        (positive == (zero < value) ? low : high) = u;
        Real next = u - value / slope;
        if (!(low <= next && next <= high)) next = (low + high) * 0.5;
        const bool arrived = abs(next - u) <= close;
        u = next;
        if (arrived) break;
    }
    return u;
}

// The least root in (0, 1), where parts narrower than half the digits with two roots count as a root.
std::optional<Real> first_root(Series p) {
    struct Part {
        Series b;
        Real start, end;
    };
    const Real zero;
    p.erase(p.begin(), std::ranges::find_if(p, [&](const Real& x) { return !(x == zero); })); // roots at 0
    if (p.empty() || keeps_sign(p)) return {};
    std::vector<Part> parts = {{bernstein(p), 0, 1}}; // those that are left, the first one last
    const Real narrow = Real::power_of_two(-Real::bits / 2);
    while (!parts.empty()) {
        Part part = std::move(parts.back());
        parts.pop_back();
        const int changes = sign_changes(part.b);
        if (changes == 1) return refined(p, zero < part.b[0], part.start, part.end);
        if (changes == 0) {
            if (part.b.back() == zero && !parts.empty()) return part.end; // a root where two parts meet
            continue;
        }
        if (part.end - part.start < narrow) return part.end;
        const Real middle = (part.start + part.end) * 0.5;
        Series first = first_half(part.b);
        parts.push_back({std::move(part.b), middle, part.end});
        parts.push_back({std::move(first), part.start, middle});
    }
    return {};
}

// y and those of its derivatives that do not jump, from time to time.
class Filter {
  public:
    Filter(const AfferentModel&, const AfferentInput&, double cell);

    const Real& time() const { return time_; }
    // Over k + 1: the factor of the integral of u^k over the cell, in s.
    const Real& step(size_t k) const { return steps_[k]; }
    size_t terms() const { return terms_; }
    const std::vector<Series>& y() const { return y_; }   // over the cell, for each order below the number of poles
    const std::vector<Real>& now() const { return now_; } // the same at time()

    // Begins a cell at time(), up to `until` at most and to the next corner of the polygon.
    void expand(const Real& until);
    // Moves on to u of the cell.
    void advance(const Real& u);
    void set_zero(size_t order) { now_[order] = Real(); }

  private:
    Series input() const;

    const AfferentModel& model_;
    const AfferentInput& input_;
    Real angular_ = Real::pi() * 2 * input_.frequency;
    Real sine_at_0_ = sine_and_cosine(Real(input_.phase)).first;
    std::vector<Real> denominator_; // of F, by powers of s
    std::vector<Real> now_;         // y and its derivatives
    double cell_;                   // s
    size_t terms_ = 1, corner_ = 0; // corner_: the next one
    Real time_, end_;
    Series inverses_, steps_;
    std::vector<Series> y_;
};

Filter::Filter(const AfferentModel& model, const AfferentInput& input, double cell)
    : model_(model), input_(input), denominator_{Real(1)} {
    const auto multiply = [&](const std::vector<Real>& factor) {
        std::vector<Real> product(denominator_.size() + factor.size() - 1);
        for (size_t i = 0; i < denominator_.size(); ++i)
            for (size_t k = 0; k < factor.size(); ++k) product[i + k] += denominator_[i] * factor[k];
        denominator_ = product;
    };
    double fastest = 1 / model.membrane_time; // 1/s
    if (input.amplitude != 0) fastest = std::max(fastest, 2 * std::numbers::pi * input.frequency);
    for (const auto& a : model.after) fastest = std::max(fastest, a.amplitude == 0 ? 0 : 1 / a.time);
    for (double T : model.time_constants) {
        multiply({1, T});
        fastest = std::max(fastest, 1 / T);
    }
    if (model.frequency) {
        const Real w = Real::pi() * 2 * *model.frequency;
        multiply({1, Real(1) / (w * *model.quality), Real(1) / (w * w)});
        fastest = std::max(fastest, 2 * std::numbers::pi * *model.frequency * std::max(1.0, 1 / *model.quality));
    }
    now_.resize(denominator_.size() - 1);
    cell_ = cell / fastest;
    // The k-th term is at most of the order 1/k!; 40 bits more are for what several equal poles add.
    for (double bits = 0; bits < double(Real::bits) + 40; ++terms_) bits += std::log2(double(terms_));
    for (size_t k = 0; k < terms_; ++k) inverses_.push_back(Real(1) / double(k + 1));
    steps_.resize(terms_);
}

// w over the cell.
Series Filter::input() const {
    const double from = corner_ > 0 ? input_.times[corner_ - 1] : 0,
                 level = corner_ > 0 ? input_.values[corner_ - 1] : 0;
    Real slope;
    if (corner_ < input_.times.size())
        slope = (Real(input_.values[corner_]) - level) / (Real(input_.times[corner_]) - from);
    const Real value = model_.value, rate = model_.rate;
    Series w(terms_);
    w[0] = value * (Real(level) + slope * (time_ - from)) + rate * slope;
    w[1] = value * slope * steps_[0];
    if (input_.amplitude == 0) return w;
    const auto [sine, cosine] = sine_and_cosine(angular_ * time_ + input_.phase);
    const Real by_sine = value * input_.amplitude, by_cosine = rate * angular_ * input_.amplitude;
    const Real wave = by_sine * sine + by_cosine * cosine, slope_of_wave = by_sine * cosine - by_cosine * sine;
    const Real cycle[] = {wave, slope_of_wave, -wave, -slope_of_wave};
    w[0] += -(by_sine * sine_at_0_);
    Real factor = 1; // of the k-th derivative of the wave by angle
    for (size_t k = 0; k < terms_; ++k) {
        w[k] += factor * cycle[k % 4];
        factor *= angular_ * steps_[k];
    }
    return w;
}

void Filter::expand(const Real& until) {
    while (corner_ < input_.times.size() && Real(input_.times[corner_]) <= time_) ++corner_;
    end_ = time_ + cell_;
    if (until < end_) end_ = until;
    if (corner_ < input_.times.size() && Real(input_.times[corner_]) < end_) end_ = input_.times[corner_];
    const Real length = end_ - time_;
    for (size_t k = 0; k < terms_; ++k) steps_[k] = length * inverses_[k];
    const size_t poles = now_.size();
    y_.assign(poles, {});
    for (size_t j = 0; j < poles; ++j) y_[j].push_back(now_[j]);
    Series left = input(); // of w when all but the highest derivative are taken
    for (size_t k = 0; k + 1 < terms_; ++k) {
        for (size_t j = 0; j + 1 < poles; ++j) y_[j].push_back(y_[j + 1][k] * steps_[k]);
        for (size_t j = 0; j < poles; ++j) left[k] += -(denominator_[j] * y_[j][k]);
        left[k] *= steps_[k];
        y_[poles - 1].push_back(left[k] / denominator_[poles]);
    }
}

void Filter::advance(const Real& u) {
    for (size_t j = 0; j < now_.size(); ++j) now_[j] = at(y_[j], u);
    if (u == Real(1)) time_ = end_;
    else time_ += u * steps_[0];
}

// An ending of a fibre, from event to event.
class Ending {
  public:
    Ending(const AfferentModel& model, const AfferentInput& input, double cell)
        : model_(model), filter_(model, input, cell) {}
    // Moves on to the next time at which V reaches 1 and returns true, or to `until` and returns false.
    bool reaches_threshold(const Real& until);
    const Real& time() const { return filter_.time(); }
    void fire();

  private:
    bool is_fed_by(size_t order) const;
    Series membrane() const;
    void move(const Real& until);

    const AfferentModel& model_;
    Filter filter_;
    Real ready_, V_;              // ready_: when the refractory time ends
    std::array<Real, 2> after_;   // the currents after a spike
    std::array<Series, 2> decay_; // the same over the cell
};

bool Ending::reaches_threshold(const Real& until) {
    while (V_ < Real(1) && filter_.time() < until) move(until);
    return !(V_ < Real(1));
}

void Ending::fire() {
    V_ = model_.reset;
    ready_ = filter_.time() + model_.refractory_time;
    for (size_t i = 0; i < 2; ++i) after_[i] = model_.after[i].amplitude;
}

// Whether a sign of y_j matters: it has a gain, and does not vanish among the rounding errors of V.
bool Ending::is_fed_by(size_t order) const {
    const double gain = std::max(std::abs(model_.gains[order][0]), std::abs(model_.gains[order][1]));
    if (gain == 0) return false;
    long double most = 0;
    for (const Real& x : filter_.y()[order]) most += std::abs(x.rounded());
    return most * gain > std::ldexp(1.0L, int(30 - Real::bits));
}

// V over the cell, as long as no y_j changes its sign.
Series Ending::membrane() const {
    const Real zero;
    const size_t terms = filter_.terms(), orders = std::min(filter_.y().size(), model_.gains.size());
    std::vector<Real> gains;
    for (size_t j = 0; j < orders; ++j) {
        const Series& y = filter_.y()[j];
        const auto first = std::ranges::find_if(y, [&](const Real& x) { return !(x == zero); });
        gains.push_back(first != y.end() && *first < zero ? -model_.gains[j][1] : model_.gains[j][0]);
    }
    Series V = {V_};
    const Real per_time = Real(1) / model_.membrane_time;
    for (size_t k = 0; k + 1 < terms; ++k) {
        Real sum = -V[k];
        for (const Series& a : decay_)
            if (k < a.size()) sum += a[k];
        for (size_t j = 0; j < orders; ++j)
            if (!(gains[j] == zero)) sum += gains[j] * filter_.y()[j][k];
        sum *= per_time;
        sum *= filter_.step(k);
        V.push_back(std::move(sum));
    }
    return V;
}

// Moves on to the next event, to the end of a cell or to `until`.
void Ending::move(const Real& until) {
    const bool resting = filter_.time() < ready_;
    filter_.expand(resting && ready_ < until ? ready_ : until);
    for (size_t i = 0; i < 2; ++i) {
        decay_[i] = {after_[i]};
        const Real per_time = Real(-1) / model_.after[i].time;
        for (size_t k = 0; k + 1 < filter_.terms() && model_.after[i].amplitude != 0; ++k)
            decay_[i].push_back(decay_[i][k] * per_time * filter_.step(k));
    }
    Real u = 1;
    std::optional<size_t> turned; // the y_j that changes its sign
    bool reaches = false;
    if (!resting) {
        for (size_t j = 0; j < std::min(filter_.y().size(), model_.gains.size()); ++j)
            if (is_fed_by(j))
                if (const auto root = first_root(filter_.y()[j]); root && *root < u) {
                    u = *root;
                    turned = j;
                }
        Series V = membrane();
        V[0] += Real(-1);
        if (const auto root = first_root(V); root && *root <= u) {
            u = *root;
            reaches = true;
        }
        V_ = at(V, u) + 1;
        if (reaches) V_ = 1;
    }
    for (size_t i = 0; i < 2; ++i) after_[i] = at(decay_[i], u);
    filter_.advance(u);
    if (!reaches && turned) filter_.set_zero(*turned);
}

void check(const AfferentModel& model, const AfferentInput& input) {
    const size_t poles = model.time_constants.size() + (model.frequency ? 2 : 0);
    if (poles < 1 || poles > 3) throw std::invalid_argument(std::to_string(poles) + " poles; allowed: 1 to 3");
    for (size_t j = poles; j < model.gains.size(); ++j)
        if (model.gains[j] != std::array<double, 2>{})
            throw std::invalid_argument("a gain of derivative " + std::to_string(j) + " of a filter with " +
                                        std::to_string(poles) + " poles; allowed: derivatives of a lower order");
    if (input.times.size() != input.values.size())
        throw std::invalid_argument(std::to_string(input.times.size()) + " times of " +
                                    std::to_string(input.values.size()) + " values; allowed: as many of each");
    for (size_t i = 0; i < input.times.size(); ++i)
        if (const double least = i > 0 ? input.times[i - 1] : 0; !(input.times[i] > least))
            throw std::invalid_argument("times[" + std::to_string(i) + "] is " + std::to_string(input.times[i]) +
                                        "; allowed: above " + std::to_string(least));
}

} // namespace

std::vector<Real> spikes(const AfferentModel& model, const AfferentInput& input, double seconds, long bits,
                         double cell) {
    return spikes(model, std::vector<AfferentInput>{input}, seconds, bits, cell);
}

// Each ending goes on alone to find out which one fires first; then all go on to this time and are set back.
std::vector<Real> spikes(const AfferentModel& model, const std::vector<AfferentInput>& inputs, double seconds,
                         long bits, double cell) {
    for (const AfferentInput& input : inputs) check(model, input);
    if (!(cell > 0 && cell <= 1))
        throw std::invalid_argument("a cell of " + std::to_string(cell) + "; allowed: above 0, up to 1");
    Real::bits = bits;
    std::vector<std::unique_ptr<Ending>> endings;
    for (const AfferentInput& input : inputs) endings.push_back(std::make_unique<Ending>(model, input, cell));
    std::vector<Real> times;
    for (Real until = seconds;; until = seconds) {
        std::unique_ptr<Ending> fires;
        size_t number = 0;
        for (size_t e = 0; e < endings.size(); ++e) {
            auto ahead = std::make_unique<Ending>(*endings[e]);
            if (!ahead->reaches_threshold(until)) continue;
            until = ahead->time();
            fires = std::move(ahead);
            number = e;
        }
        if (!fires) return times;
        times.push_back(until);
        endings[number] = std::move(fires);
        for (const auto& e : endings) {
            (void)e->reaches_threshold(until);
            e->fire();
        }
    }
}

namespace {

class AfferentDraw : private Draw {
  public:
    explicit AfferentDraw(unsigned seed) : Draw(seed) {}
    AfferentCase next();

  private:
    void take_filter(AfferentModel&);
    void take_gains(AfferentModel&);
    void take_membrane(AfferentModel&);
    AfferentInput input(double seconds);
    bool scale(AfferentCase&);
};

AfferentCase AfferentDraw::next() {
    for (;;) {
        AfferentCase c = {.seconds = real(0.1, 0.3)};
        take_filter(c.model);
        take_gains(c.model);
        take_membrane(c.model);
        c.input = input(c.seconds);
        if (scale(c)) return c;
    }
}

void AfferentDraw::take_filter(AfferentModel& m) {
    const bool resonates = one_in(3);
    if (resonates) {
        m.frequency = decades(1.301, 2.477);
        m.quality = real(0.5, 1.5);
    }
    for (int i = resonates ? below(2) : 1 + below(3); i > 0; --i) m.time_constants.push_back(decades(-3.522, -2.301));
    if (m.time_constants.size() > 1 && one_in(4)) m.time_constants[1] = m.time_constants[0];
    const int kind = below(3);
    m.value = kind == 0 ? 0 : 1;
    m.rate = kind == 1 ? 0 : decades(-3.5, -2);
}

// Each for values of 1, until it is known how great they become.
void AfferentDraw::take_gains(AfferentModel& m) {
    const int poles = int(m.time_constants.size()) + (m.frequency ? 2 : 0), always = below(poles);
    m.gains = {};
    for (int j = 0; j < poles; ++j) {
        if (j != always && one_in(2)) continue;
        const int kind = below(4);
        if (kind != 0) m.gains[size_t(j)][0] = real(0.2, 1);
        if (kind != 1) m.gains[size_t(j)][1] = real(0.2, 1);
        if (kind != 1 && one_in(6)) m.gains[size_t(j)][1] *= -1;
    }
}

void AfferentDraw::take_membrane(AfferentModel& m) {
    m.membrane_time = decades(-2.699, -1.222);
    m.refractory_time = decades(-3.046, -2.301);
    m.reset = one_in(2) ? 0 : -real(0, 1);
    if (!one_in(3)) return;
    const int currents = 1 + below(2);
    for (int i = 0; i < currents; ++i) m.after[size_t(i)] = {real(-3, 1), decades(-3, -1.301)};
}

AfferentInput AfferentDraw::input(double seconds) {
    AfferentInput q;
    const int kind = below(9); // both of them in one of 9
    if (kind < 5) {
        q.amplitude = decades(-2, 2);
        q.frequency = decades(0.699, 2.477);
        q.phase = one_in(2) ? 0 : real(-3, 3);
    }
    if (kind < 4) return q;
    const double unit = decades(-2, 2);
    double value = 0, step = 0;
    for (int i = 1, left = 0; i * 1e-3 < seconds; ++i, --left) {
        if (left == 0) {
            left = 1 + below(one_in(2) ? 5 : 40);
            step = one_in(3) ? 0 : unit * real(-1, 1) / left;
        }
        value += step;
        q.times.push_back(i * 1e-3);
        q.values.push_back(value);
    }
    return q;
}

// Sets the gains so that the derivatives have a share each in a drive of a random greatest value; false if there is no
// drive, or, in 15 of 16 such cases, no spike.
bool AfferentDraw::scale(AfferentCase& c) {
    Real::bits = 64;
    std::vector<std::array<double, 3>> all;
    std::array<double, 3> most{};
    std::vector<double> times;
    Filter filter(c.model, c.input, 1);
    while (filter.time() < Real(c.seconds)) {
        filter.expand(c.seconds);
        filter.advance(1);
        times.push_back(double(filter.time().rounded()));
        std::array<double, 3>& y = all.emplace_back();
        for (size_t j = 0; j < filter.now().size(); ++j) {
            y[j] = double(filter.now()[j].rounded());
            most[j] = std::max(most[j], std::abs(y[j]));
        }
    }
    double drive = 0, V = 0, greatest_V = 0, before = 0; // V: without spikes
    for (size_t i = 0; i < all.size(); ++i) {
        double sum = 0;
        for (size_t j = 0; j < 3; ++j)
            if (all[i][j] != 0) sum += c.model.gains[j][all[i][j] < 0] * std::abs(all[i][j]) / most[j];
        drive = std::max(drive, sum);
        V += (sum - V) * -std::expm1((before - times[i]) / c.model.membrane_time);
        greatest_V = std::max(greatest_V, V);
        before = times[i];
    }
    if (drive < 1e-3) return false;
    const double greatest = decades(-0.301, 0.778);
    if (greatest_V * greatest / drive < 1 && !one_in(16)) return false;
    for (size_t j = 0; j < 3; ++j)
        for (double& gain : c.model.gains[j])
            if (gain != 0) gain *= greatest / drive / most[j];
    return true;
}

} // namespace

AfferentCase afferent_case(unsigned seed) { return AfferentDraw(seed).next(); }

} // namespace oracle
