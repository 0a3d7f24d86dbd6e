// SPDX-License-Identifier: MIT
// labels: device threads
// What an output means: left limits, impulses, breakpoints, SA2 and FA2.
#include "host/core/press/device.hpp"
#include "host/lab/schedule/timeline.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <numeric>

using namespace test;

namespace {

// One cell under pressure 1: responses are the model itself.
Scene one_cell() {
    Scene s;
    s.grid = {1, 1, {}};
    s.load.kind = Load::Kind::map;
    s.load.map = {1};
    return s;
}

// Marched; and where closed forms can serve the scene, they say the same.
Result in_double(Scene s) {
    RunOptions f64;
    f64.precision = Precision::f64;
    s.model = Model::march;
    const Result marched = run(s, Device::cpu(), f64);
    s.model.reset();
    const Result free = run(s, Device::cpu(), f64);
    for (const Trace& t : marched.traces) CHECK(difference(free.trace(t.quantity).mean, t.mean) < 1e-12);
    REQUIRE(free.impulses.size() == marched.impulses.size());
    for (size_t i = 0; i < free.impulses.size(); ++i)
        CHECK(free.impulses[i].max == relative(marched.impulses[i].max, 1e-12));
    return marched;
}

const std::vector<double>& mean(const Result& r, Quantity q) { return r.trace(q).mean; }

} // namespace

TEST_CASE("outputs are left limits, and 0 at t = 0") {
    const Result r = in_double(one_cell());
    REQUIRE(r.time.size() == 1000);
    CHECK(r.time[999] == 999 * 0.01);
    CHECK(mean(r, Quantity::fa1)[0] == 0);
    CHECK(mean(r, Quantity::fa1)[1] == relative(std::exp(-0.0154), 1e-12));
    CHECK(mean(r, Quantity::fa2)[0] == 0);
    CHECK(mean(r, Quantity::fa2)[1] == relative(-1.54 * std::exp(-0.0154), 1e-12));
    REQUIRE(r.impulses.size() == 1);
    CHECK(r.impulses[0].time == 0);
    CHECK(r.impulses[0].quantity == Quantity::fa2);
    CHECK(r.impulses[0].mean == relative(1, 1e-12));
}

TEST_CASE("the step mean of FA2 holds the jump, and sums to the rate at the end") {
    Scene s = one_cell();
    s.receptors.fa2 = Fa2::step_mean;
    const Result r = in_double(s);
    CHECK(mean(r, Quantity::fa2)[0] == 0);
    CHECK(mean(r, Quantity::fa2)[1] == relative(std::exp(-0.0154) / 0.01, 1e-12));
    const auto& fa2 = mean(r, Quantity::fa2);
    // The rate has decayed to 2e-7, the sum keeps the rounding of its first term, 0.98.
    CHECK(std::accumulate(fa2.begin(), fa2.end(), 0.0) * 0.01 == absolute(mean(r, Quantity::fa1).back(), 1e-14));
}

TEST_CASE("a load that starts between outputs acts from its own instant") {
    for (Fa2 fa2 : {Fa2::point, Fa2::step_mean})
        for (double start : {0.5, 0.5037, 0.50999999999, 0.51 * (1 - 0x1p-51)}) {
            CAPTURE(start);
            Scene s = one_cell();
            s.time.duration = 1;
            s.load.envelope.start = start;
            s.receptors.fa2 = fa2;
            s.output.fields = {{0.5071, {Quantity::sa1, Quantity::fa1}}};
            const Result r = in_double(s);
            const double begin = start > 0.509999999995 ? 0.51 : start; // within 4 ulp of an output it is the output's
            double before = 0;
            for (size_t n = 0; n < r.time.size(); ++n) {
                const double t = r.time[n] - begin, rate = t > 1e-12 ? std::exp(-1.54 * t) : 0;
                // A start is known to the rounding of a step, which is much of the 1e-11 s that one load has acted for.
                CHECK(mean(r, Quantity::strain)[n] == absolute(t > 0 ? -std::expm1(-1.54 * t) / 1.54 : 0, 1e-15));
                CHECK(mean(r, Quantity::sa2)[n] ==
                      absolute(t > 0 ? (t + std::expm1(-1.54 * t) / 1.54) / 1.54 : 0, 1e-15));
                CHECK(mean(r, Quantity::fa1)[n] == relative(rate, 1e-12));
                CHECK(mean(r, Quantity::fa2)[n] ==
                      relative(fa2 == Fa2::point ? -1.54 * rate : (rate - before) / 0.01, 1e-9));
                before = rate;
            }
            const double t = std::max(0.0, 0.5071 - begin);
            CHECK(r.fields[0].values[0] == relative(-std::expm1(-1.54 * t) / 1.54, 1e-12));
            CHECK(r.fields[1].values[0] == relative(t > 0 ? std::exp(-1.54 * t) : 0, 1e-12));
            REQUIRE(r.impulses.size() == 1);
            CHECK(r.impulses[0].time == relative(begin, 1e-12));
            CHECK(r.impulses[0].mean == relative(1, 1e-12));
        }
}

TEST_CASE("a pulse that starts after the end presses nothing, in every model and on every backend") {
    const Validated vulkan;
    Scene s = small_scene(4, 4);
    s.load.envelope.kind = Envelope::Kind::pulse;
    s.load.envelope.length = 0.1;
    s.load.envelope.period = 0.2;
    s.load.envelope.start = 1;
    s.time = {0.05, 0.5};
    for (Model model : {Model::moments, Model::maps, Model::sites, Model::march})
        for (const Device& device : {Device::cpu(), vulkan.device()}) {
            CAPTURE(name(model));
            s.model = model;
            s.output.traces = {Quantity::strain, Quantity::fa2};
            s.output.probes = {{1, 2}};
            s.sites.clear();
            if (model == Model::sites) {
                s.output = {.traces = {}, .probes = {}, .fields = {}};
                s.sites = {{Quantity::fa2, {1, 2}}};
            }
            const Result r = run(s, device);
            REQUIRE(r.time.size() == 10);
            CHECK(r.impulses.empty());
            const std::vector<double> zeros(10, 0.0);
            for (const Trace& t : r.traces)
                for (const auto* column : {&t.mean, &t.min, &t.max, &t.probes[0]}) CHECK(*column == zeros);
            if (model == Model::sites) CHECK(r.responses == zeros);
        }
}

TEST_CASE("SA2 with an adaptation time is bounded and known in closed form; without end it is the plain integral") {
    Scene s = one_cell();
    const double tau = 1 / 1.54;
    for (double adaptation : {0.2, tau, 3.0}) {
        CAPTURE(adaptation);
        s.receptors.sa2_adaptation = adaptation;
        const Result r = in_double(s);
        for (size_t n = 1; n < r.time.size(); ++n) {
            const double t = r.time[n], a = adaptation;
            const double y = a == tau ? tau * a * (1 - (1 + t / tau) * std::exp(-t / tau))
                                      : tau * a * (1 - (a * std::exp(-t / a) - tau * std::exp(-t / tau)) / (a - tau));
            CHECK(mean(r, Quantity::sa2)[n] == relative(y, 1e-9));
            CHECK(mean(r, Quantity::sa2)[n] <= adaptation / 1.54);
        }
    }
    s.receptors.sa2_adaptation = {};
    const Result plain = in_double(s);
    CHECK(mean(plain, Quantity::sa2)[999] - mean(plain, Quantity::sa2)[899] == relative(1 / 1.54, 1e-5));
    s.receptors.sa2_adaptation = 1e9;
    CHECK(difference(mean(in_double(s), Quantity::sa2), mean(plain, Quantity::sa2)) < 1e-7);
}

TEST_CASE("FA2 gains act on the two signs apart: (1, -1) signed, (1, 0) half-wave, (1, 1) full-wave") {
    Scene s = small_scene(31, 31);
    s.model = Model::march;
    s.surface.noise = 0;
    s.receptors.fa2 = Fa2::step_mean;
    s.output.fields = {{0.35, {Quantity::fa2}}};
    const std::vector<double> raw = run(s, Device::cpu()).fields[0].values;
    REQUIRE(*std::min_element(raw.begin(), raw.end()) < 0);
    for (auto [plus, minus] : {std::pair{1.0, 0.0}, {1.0, 1.0}, {0.5, 0.25}, {0.0, -1.0}}) {
        s.receptors.fa2_gains = {plus, minus};
        const std::vector<double> out = run(s, Device::cpu()).fields[0].values;
        for (size_t i = 0; i < raw.size(); ++i) REQUIRE(out[i] == (raw[i] >= 0 ? plus * raw[i] : minus * -raw[i]));
    }
}

TEST_CASE("no FA2 peak depends on the step: the density and the impulses do not, the published spike does") {
    double published_before = 0;
    for (double step : {0.02, 0.01, 0.005}) {
        Scene s = one_cell();
        s.time = {step, 1};
        const Result r = in_double(s);
        const auto& density = mean(r, Quantity::fa2);
        for (size_t n = 1; n < density.size(); ++n) REQUIRE(std::abs(density[n]) <= 1.54);
        CHECK(r.impulses[0].mean == relative(1, 1e-12));
        s.grid = {2, 2, {}};
        s.load.map = {1, 1, 1, 1};
        s.method = Method::published;
        const double spike = mean(in_double(s), Quantity::fa2)[1];
        CHECK(spike == relative((1 - 1.54 * step) / (2 * step), 1e-12));
        CHECK(spike > 1.9 * published_before);
        published_before = spike;
    }
}

TEST_CASE("two requests for one output, written differently, are both answered, and later ones too") {
    for (Method method : {Method::exact, Method::euler}) {
        Scene s = one_cell();
        s.method = method;
        s.time = {0.1, 1};
        s.load.envelope.start = 0.3;
        s.output.fields = {{0.3, {Quantity::fa1}}, {3 * 0.1, {Quantity::fa1}}, {0.5, {Quantity::fa1}}};
        const Result r = in_double(s);
        REQUIRE(r.fields.size() == 3);
        CHECK(r.fields[0].values[0] == 0);
        CHECK(r.fields[1].values[0] == 0);
        CHECK(r.fields[2].values[0] > 0.5);
    }
}

TEST_CASE("every envelope: the identity holds, FA1 is the rate, FA2 its slope or its step mean, jumps are impulses") {
    struct Case {
        Envelope envelope;
        double jumps; // their sum
    };
    Envelope ramp, sine, pulse, table;
    ramp.kind = Envelope::Kind::ramp;
    ramp.start = 0.113;
    ramp.rise = 0.5;
    sine.kind = Envelope::Kind::sine;
    sine.frequency = 3;
    sine.phase = 0.4;
    sine.mean = 0.25;
    sine.amplitude = 0.75;
    pulse.kind = Envelope::Kind::pulse;
    pulse.start = 0.1234;
    pulse.length = 0.0321;
    pulse.period = 0.2;
    table.kind = Envelope::Kind::table;
    table.times = {0.05, 0.3, 0.3, 0.7001};
    table.values = {0.5, 1.5, -1, 2};
    const auto g = [](const Envelope& e, double t) { // left limits
        switch (e.kind) {
        case Envelope::Kind::ramp: return std::clamp((t - e.start) / e.rise, 0.0, 1.0);
        case Envelope::Kind::sine:
            return t > 0 ? e.mean + e.amplitude * std::sin(2 * M_PI * e.frequency * t + e.phase) : 0;
        case Envelope::Kind::pulse: {
            const double into = std::fmod(t - e.start, e.period);
            return t > e.start && (into > 0 ? into : e.period) <= e.length ? 1.0 : 0.0;
        }
        case Envelope::Kind::table:
            return t <= 0.05 ? 0 : t <= 0.3 ? 0.5 + (t - 0.05) * 4 : t <= 0.7001 ? -1 + (t - 0.3) * 3 / 0.4001 : 2.0;
        default: return 1.0;
        }
    };
    for (const Case& c : {Case{ramp, 0}, {sine, 0.25 + 0.75 * std::sin(0.4)}, {pulse, 0}, {table, 0.5 - 2.5}})
        for (double viscosity : {1.0, 0.003})
            for (Fa2 fa2 : {Fa2::point, Fa2::step_mean}) {
                CAPTURE(int(c.envelope.kind));
                CAPTURE(viscosity);
                Scene s = one_cell();
                s.material.viscosity = viscosity;
                s.load.envelope = c.envelope;
                s.time = {0.01, 1};
                s.receptors.fa2 = fa2;
                const Result r = in_double(s);
                // the integral of g and the strain, by steps so fine that the load is straight on each
                const int fine = 4000;
                const double h = 0.01 / fine, tau = viscosity / 1.54, a = std::exp(-h / tau),
                             p = -std::expm1(-h / tau) / (h / tau);
                // A jump that rounding puts inside a fine step is taken half a step early or late. FA1 is a difference
                // of numbers of size 1, over the viscosity, and FA2 one of such rates, over a step.
                const double in_rate = 1e-13 / viscosity, in_mean = 1e-14 / viscosity / 0.01;
                double J = 0, eps = 0;
                for (size_t n = 1; n < r.time.size(); ++n) {
                    for (int i = 0; i < fine; ++i) {
                        const double t = r.time[n - 1] + i * h, s0 = g(c.envelope, t + 1e-9 * h),
                                     s1 = g(c.envelope, t + h);
                        J += h * (s0 + s1) / 2;
                        eps = a * eps + (s0 * (p - a) + s1 * (1 - p)) / 1.54;
                    }
                    const double load = g(c.envelope, r.time[n]);
                    CHECK(1.54 * mean(r, Quantity::sa2)[n] + viscosity * mean(r, Quantity::strain)[n] ==
                          absolute(J, h));
                    CHECK(mean(r, Quantity::strain)[n] == absolute(eps, h / viscosity));
                    CHECK(mean(r, Quantity::fa1)[n] ==
                          absolute((load - 1.54 * mean(r, Quantity::strain)[n]) / viscosity, in_rate));
                    if (fa2 == Fa2::step_mean)
                        CHECK(mean(r, Quantity::fa2)[n] ==
                              absolute((mean(r, Quantity::fa1)[n] - mean(r, Quantity::fa1)[n - 1]) / 0.01, in_mean));
                    else if (c.envelope.kind == Envelope::Kind::sine)
                        CHECK(mean(r, Quantity::fa2)[n] ==
                              relative((0.75 * 6 * M_PI * std::cos(6 * M_PI * r.time[n] + 0.4) -
                                        1.54 * mean(r, Quantity::fa1)[n]) /
                                           viscosity,
                                       1e-10));
                }
                double impulses = 0;
                for (const Impulse& i : r.impulses) impulses += i.mean * viscosity;
                CHECK(impulses == relative(c.jumps, 1e-12));
            }
}

TEST_CASE("an elastic skin: FA1 is the load's slope over the modulus, FA2 the step mean of its change") {
    Envelope ramp, sine, table;
    ramp.kind = Envelope::Kind::ramp;
    ramp.start = 0.113;
    ramp.rise = 0.5;
    sine.kind = Envelope::Kind::sine;
    sine.frequency = 3;
    table.kind = Envelope::Kind::table;
    table.times = {0, 0.25, 0.5, 0.5, 0.6};
    table.values = {1, 2, 0, 1, -1};
    for (const Envelope& e : {ramp, sine, table}) {
        CAPTURE(int(e.kind));
        Scene s = one_cell();
        s.material.viscosity = 0;
        s.load.envelope = e;
        s.receptors.fa2 = Fa2::step_mean;
        s.time = {0.01, 1};
        const Result r = in_double(s);
        const auto &fa1 = mean(r, Quantity::fa1), &fa2 = mean(r, Quantity::fa2);
        for (size_t n = 1; n < r.time.size(); ++n) {
            const double t = r.time[n];
            double slope = 0;
            if (e.kind == Envelope::Kind::ramp) slope = t > 0.113 && t <= 0.613 ? 2 : 0;
            if (e.kind == Envelope::Kind::sine) slope = 6 * M_PI * std::cos(6 * M_PI * t);
            if (e.kind == Envelope::Kind::table) slope = t < 0.255 ? 4 : t < 0.505 ? -8 : t < 0.605 ? -20 : 0;
            // The sine's slope passes through 0; FA2 is a difference of rates over a step.
            CHECK(fa1[n] == absolute(slope / 1.54, 1e-12));
            CHECK(fa2[n] == absolute((fa1[n] - fa1[n - 1]) / 0.01, 1e-12 / 0.01));
        }
    }
}

TEST_CASE(
    "a step over hundreds of breakpoints takes few of them from where earlier steps have come, with the same bits") {
    Scene s = small_scene(6, 5);
    s.material.modulus = s.material.viscosity = 1;
    s.load.envelope.kind = Envelope::Kind::table;
    for (int i = 0; i < 600; ++i) { // every tenth one is a jump
        const double t = 0.013 + 0.0031 * i;
        for (int k = 0; k < 1 + (i % 10 == 0); ++k)
            s.load.envelope.times.push_back(t), s.load.envelope.values.push_back(std::sin(7.0 * (i + 600 * k)));
    }
    s.time = {.step = 0.9, .duration = 2.7};
    s.output.traces = {Quantity::sa1, Quantity::fa1, Quantity::sa2};
    for (int i = 1; i < 40; ++i) s.output.fields.push_back({0.0613 * i, {Quantity::strain}});
    const model::PreparedRun run = model::prepare_run(s);
    const scene::Waveform load(s.load.envelope, s.time);
    const model::Element& element = run.skin.materials.front();
    model::Timeline timeline(run.schedule, run.skin);
    int compared = 0, impulses = 0;
    for (model::Step step; timeline.next(step);) {
        if (!step.forcing) continue;
        CHECK(step.forcing->segments.size() <= 32);
        impulses += step.impulse >= 0;
        if (step.impulse >= 0) continue;
        f64::Coefficients whole = exact_coefficients(element, run.skin.rule, step.length);
        const auto forcing = model::forcing_over(load, step.begin, step.end, step.length, false, step.begin);
        model::force<f64>(whole, element, run.skin.rule, forcing);
        const f64::Coefficients k = step.coefficients_of(0, element, run.skin.rule);
        for (auto of : {&f64::Coefficients::f, &f64::Coefficients::i2, &f64::Coefficients::v1, &f64::Coefficients::a1})
            CHECK(k.*of == whole.*of);
        compared += forcing.segments.size() > 32;
    }
    CHECK(compared > 20);
    CHECK(impulses == 60);
}
