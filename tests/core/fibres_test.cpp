// SPDX-License-Identifier: MIT
// labels: long
// Nerve fibres against closed forms, and against a search for their events in 48 digits.
#include "host/core/cpu/fibres.hpp"
#include "tests/oracle/afferent.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

namespace {

using namespace dermis;

AfferentModel held_model() {
    AfferentModel m;
    m.time_constants = {1e-3};
    m.membrane_time = 0.02;
    m.refractory_time = 0.002;
    return m;
}

// The times, s, at which a fibre fires, with an ending for each list of inputs at the ends of steps of dt seconds.
template <class K>
std::vector<double> times_of(const AfferentModel& m, const std::vector<std::vector<double>>& q, double dt) {
    cpu::Fibres<K> fibres({{.model = m, .count = 1, .endings = q.size()}}, 1, 1, simd::best());
    REQUIRE(fibres.prepare(dt));
    std::vector<double> times;
    for (size_t i = 0; i < q[0].size(); ++i) {
        std::vector<typename K::real> inputs;
        for (const std::vector<double>& of_ending : q) inputs.push_back(typename K::real(of_ending[i]));
        fibres.set_input(0, inputs.data());
        fibres.forget_spikes();
        fibres.press(0, 1);
        for (const auto& s : fibres.spikes()) times.push_back((double(i) + double(s.share)) * dt);
    }
    return times;
}

template <class K> std::vector<double> times_of(const AfferentModel& m, const std::vector<double>& q, double dt) {
    return times_of<K>(m, std::vector<std::vector<double>>{q}, dt);
}

// The input of a case at the ends of steps of dt seconds, and the case with straight lines between them.
std::vector<double> sampled(oracle::AfferentCase& c, double dt) {
    const oracle::AfferentInput in = c.input;
    std::vector<double> q;
    c.input = {};
    for (size_t i = 1; double(i) * dt <= c.seconds; ++i) {
        const double t = double(i) * dt;
        double value = in.amplitude * (std::sin(6.283185307179586 * in.frequency * t + in.phase) - std::sin(in.phase));
        double t0 = 0, q0 = 0;
        for (size_t k = 0; k < in.times.size(); ++k) {
            if (t <= in.times[k]) {
                value += q0 + (in.values[k] - q0) * (t - t0) / (in.times[k] - t0);
                break;
            }
            t0 = in.times[k];
            q0 = in.values[k];
            if (k + 1 == in.times.size()) value += q0;
        }
        value = double(float(value)); // the same in float and in double
        q.push_back(value);
        c.input.times.push_back(t);
        c.input.values.push_back(value);
    }
    c.seconds = double(q.size()) * dt;
    return q;
}

// Compares two lists of times. A spike that stands in only one of them counts as lost or invented, unless the membrane
// only grazed its threshold there: then both lists part, and the rest is not compared.
struct Difference {
    double greatest = 0;
    size_t compared = 0, parted = 0;
};
Difference difference(const std::vector<double>& a, const std::vector<double>& b, double most) {
    Difference d;
    for (size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
        if (i >= a.size() || i >= b.size() || std::abs(a[i] - b[i]) > most) {
            d.parted = std::max(a.size(), b.size()) - i;
            break;
        }
        d.greatest = std::max(d.greatest, std::abs(a[i] - b[i]));
        ++d.compared;
    }
    return d;
}

std::vector<double> exact_times(const oracle::AfferentCase& c) {
    std::vector<double> times;
    for (const oracle::Real& t : oracle::spikes(c.model, c.input, c.seconds)) times.push_back(double(t.rounded()));
    return times;
}

TEST_CASE("under a held input a fibre fires at intervals of t_ref + tau ln(I/(I - 1))") {
    const AfferentModel m = held_model();
    for (const double I : {1.0001, 1.1, 2.0, 10.0, 200.0})
        for (const double dt : {1e-4, 1e-3, 0.01}) {
            const double T = m.refractory_time + m.membrane_time * std::log(I / (I - 1));
            const std::vector<double> q(size_t(12 * T / dt) + 200, I);
            const std::vector<double> exact = times_of<f64>(m, q, dt), single = times_of<f32>(m, q, dt);
            CAPTURE(I);
            CAPTURE(dt);
            REQUIRE(exact.size() > 8);
            CHECK(exact.size() == single.size());
            for (size_t i = 0; i + 1 < exact.size(); ++i)
                if (exact[i] > 0.06) // the filter has come to rest
                    CHECK(std::abs((exact[i + 1] - exact[i]) / T - 1) < 1e-9);
        }
}

// Whether float may miss times by as much: the roundings of some thousand steps do no more than gains that are changed
// by 5e-5.
bool as_sensitive(const oracle::AfferentCase& c, const std::vector<double>& q, double dt, const Difference& missed) {
    const std::vector<double> exact = times_of<f64>(c.model, q, dt);
    for (const double change : {5e-5, -5e-5}) {
        AfferentModel m = c.model;
        for (auto& pair : m.gains)
            for (double& gain : pair) gain *= 1 + change;
        const Difference d = difference(times_of<f64>(m, q, dt), exact, 1e-4);
        if (d.parted > 0 || (missed.parted == 0 && d.greatest > missed.greatest)) return true;
    }
    return false;
}

TEST_CASE("every spike of random fibres under random inputs is there, within the tolerance") {
    const unsigned fibres = test::night() ? 1000 : 100;
    size_t spikes = 0, late = 0;
    double greatest64 = 0, greatest32 = 0;
    for (unsigned seed = 0; seed < fibres; ++seed) {
        oracle::AfferentCase c = oracle::afferent_case(seed);
        const double dt = seed % 3 == 0 ? 1e-3 : seed % 3 == 1 ? 2.5e-4 : 5e-3;
        const std::vector<double> q = sampled(c, dt);
        const std::vector<double> exact = exact_times(c);
        const Difference in64 = difference(times_of<f64>(c.model, q, dt), exact, 1e-5);
        const Difference in32 = difference(times_of<f32>(c.model, q, dt), exact, 1e-4);
        CAPTURE(seed);
        CHECK(in64.parted == 0);
        CHECK(in64.greatest < 1e-9);
        if (in32.parted > 0 || in32.greatest > 1e-6) {
            ++late;
            CHECK(
                as_sensitive(c, q, dt, in32)); // the membrane hardly rises where it reaches its threshold, or grazes it
        }
        spikes += exact.size();
        greatest64 = std::max(greatest64, in64.greatest);
        greatest32 = std::max(greatest32, in32.greatest);
    }
    MESSAGE(spikes << " spikes, greatest error " << greatest64 << " s in double, " << greatest32 << " s in float, "
                   << late << " fibres with a spike beyond 1 us in float");
    CHECK(spikes > 5 * fibres);
    CHECK(late * 50 < fibres);
}

TEST_CASE("a fibre with several endings fires where the first of them reaches its threshold, which sets all back") {
    const unsigned fibres = test::night() ? 200 : 20;
    size_t spikes = 0, of_one = 0, late = 0;
    double greatest = 0;
    for (unsigned seed = 0; seed < fibres; ++seed) {
        oracle::AfferentCase c = oracle::afferent_case(seed);
        const double dt = seed % 2 ? 1e-3 : 2.5e-4;
        std::vector<std::vector<double>> q = {sampled(c, dt)};
        std::vector<oracle::AfferentInput> inputs = {c.input};
        for (unsigned ending = 1; ending < 2 + seed % 3; ++ending) { // feels it weaker or stronger, and later
            const size_t later = (seed / 3 + 7 * ending) % (q[0].size() / 2);
            std::vector<double>& own = q.emplace_back(q[0].size());
            for (size_t i = later; i < own.size(); ++i)
                own[i] = double(float((0.7 + 0.1 * ((seed + 3 * ending) % 7)) * q[0][i - later]));
            inputs.push_back(c.input);
            inputs.back().values = own;
        }
        std::vector<double> exact;
        for (const oracle::Real& t : oracle::spikes(c.model, inputs, c.seconds)) exact.push_back(double(t.rounded()));
        const Difference in64 = difference(times_of<f64>(c.model, q, dt), exact, 1e-5);
        const Difference in32 = difference(times_of<f32>(c.model, q, dt), exact, 1e-4);
        CAPTURE(seed);
        CHECK(in64.parted == 0);
        CHECK(in64.greatest < 1e-9);
        late += in32.parted > 0 || in32.greatest > 1e-6;
        spikes += exact.size();
        of_one += oracle::spikes(c.model, inputs[0], c.seconds).size();
        greatest = std::max(greatest, in64.greatest);
    }
    MESSAGE(spikes << " spikes, " << of_one << " of the first endings alone, greatest error " << greatest << " s, "
                   << late << " fibres with a spike beyond 1 us in float");
    CHECK(spikes > of_one);
    CHECK(late * 20 < fibres);
}

TEST_CASE("a fibre fires as one with a single ending, to the last bit, where one of its endings is driven most, or all "
          "alike") {
    const AfferentModel m = held_model();
    const std::vector<double> driven(300, 3.0), still(300, 0.0), weaker(300, 2.5);
    const std::vector<double> alone = times_of<f32>(m, driven, 1e-3);
    CHECK(alone.size() > 10);
    CHECK(times_of<f32>(m, std::vector{driven, still, weaker}, 1e-3) == alone);
    CHECK(times_of<f32>(m, std::vector{weaker, driven, driven}, 1e-3) == alone);
}

TEST_CASE("fibres of a large population, shared by threads, fire as each of them alone") {
    const AfferentModel m = held_model();
    constexpr size_t count = 3001;
    for (const size_t endings : {1, 5, 64}) {
        cpu::Fibres<f32> all({{.model = m, .count = 7}, {.model = m, .count = count, .endings = endings}}, 1, 2,
                             simd::best());
        const auto input = [&](size_t fibre, size_t ending, int step) {
            return float((fibre * 31 + ending * 17 + size_t(step) * 5) % 97) * 0.05f;
        };
        REQUIRE(all.prepare(1e-3));
        std::vector<std::vector<double>> times(count);
        for (int step = 0; step < 50; ++step) {
            std::vector<float> inputs(7, 0);
            for (size_t f = 0; f < count; ++f)
                for (size_t e = 0; e < endings; ++e) inputs.push_back(input(f, e, step));
            all.set_input(0, inputs.data());
            all.forget_spikes();
            all.press(0, 1);
            for (const auto& s : all.spikes())
                times[size_t(s.fibre) - 7].push_back((double(step) + double(s.share)) * 1e-3);
        }
        for (size_t f = 0; f < count; f += 100) {
            std::vector<std::vector<double>> q(endings);
            for (size_t e = 0; e < endings; ++e)
                for (int step = 0; step < 50; ++step) q[e].push_back(input(f, e, step));
            CHECK(times_of<f32>(m, q, 1e-3) == times[f]);
            CHECK(!times[f].empty());
        }
    }
}

TEST_CASE("substeps are as many as the fastest of filter, membrane, current and refractory time needs, and no more") {
    const auto substeps = [](const AfferentModel& m, double dt) {
        f32::FibreConstants single{};
        f64::FibreConstants twice{};
        const bool both =
            model::fill_fibre_constants<f32>(m, dt, single) && model::fill_fibre_constants<f64>(m, dt, twice);
        return both ? std::pair{int(single.substeps), int(twice.substeps)} : std::pair{0, 0};
    };
    AfferentModel slow;
    slow.time_constants = {1};
    slow.membrane_time = 1;
    slow.refractory_time = 10;
    CHECK(substeps(slow, 0.2) == std::pair{1, 1});
    CHECK(substeps(slow, 0.3) == std::pair{1, 2}); // a quarter of 1 s in double
    CHECK(substeps(slow, 1.7) == std::pair{2, 8}); // 1.6 s in float
    for (int n = 1; n <= 4096; n *= 2) {
        CHECK(substeps(slow, 0.2499 * n).second == n);
        CHECK(substeps(slow, 1.599 * n).first == n);
    }
    const auto with = [&](auto change) {
        AfferentModel m = slow;
        change(m);
        return substeps(m, 0.1);
    };
    // A hundredth of it: 0.1 s is 6.25 times 16 ms, and 40 times 2.5 ms.
    CHECK(with([](AfferentModel& m) { m.membrane_time = 0.01; }) == std::pair{8, 64});
    CHECK(with([](AfferentModel& m) { m.time_constants = {1, 0.01}; }) == std::pair{8, 64});
    CHECK(with([](AfferentModel& m) { m.after = {{{-1, 1}, {-1, 0.01}}}; }) == std::pair{8, 64});
    CHECK(with([](AfferentModel& m) { m.after[0] = {0, 0.01}; }) == std::pair{1, 1}); // no current
    CHECK(with([](AfferentModel& m) { m.refractory_time = 0.01; }) == std::pair{16, 16});
    CHECK(with([](AfferentModel& m) { m.refractory_time = 0.1 / 16; }) == std::pair{16, 16}); // just as long
    CHECK(with([](AfferentModel& m) { m.refractory_time = 1e-9; }) == std::pair{0, 0});       // too many
}

TEST_CASE("a membrane that grazes its threshold fires just where its peak exceeds it") {
    // One pole and a pulse of the input: the peak of V is proportional to the gain.
    AfferentModel m = held_model();
    std::vector<double> q(40, 0.0);
    q[3] = q[4] = 1;
    m.gains[0][0] = 1;
    double low = 0, high = 1000; // gains without a spike, and with one
    for (int i = 0; i < 200; ++i) {
        m.gains[0][0] = (low + high) / 2;
        (times_of<f64>(m, q, 1e-3).empty() ? low : high) = m.gains[0][0];
    }
    oracle::AfferentCase c{.model = m, .input = {}, .seconds = 0.04};
    for (size_t i = 0; i < q.size(); ++i) {
        c.input.times.push_back(1e-3 * double(i + 1));
        c.input.values.push_back(q[i]);
    }
    for (const double change : {-1e-12, 1e-12}) {
        c.model.gains[0][0] = high * (1 + change);
        CHECK(oracle::spikes(c.model, c.input, c.seconds).size() == (change > 0));
        CHECK(times_of<f64>(c.model, q, 1e-3).size() == (change > 0));
    }
}

} // namespace
