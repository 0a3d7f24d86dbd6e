// SPDX-License-Identifier: MIT
// labels: threads
// What an output means: left limits, impulses, SA2 and FA2. Every envelope, breakpoint and material is drawn by the
// suite `planner` and measured against closed forms.
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
        s.material.viscosity = 0.8; // the rate at a step's start is (1 - 1.54*strain)/0.8
        const Result published = in_double(s);
        const double first = 1 / 0.8, second = (1 - 1.54 * step * first) / 0.8;
        CHECK(mean(published, Quantity::fa1)[1] == relative(first, 1e-12));
        CHECK(mean(published, Quantity::fa1)[2] == relative(second, 1e-12));
        const double spike = mean(published, Quantity::fa2)[1];
        CHECK(spike == relative(second / (2 * step), 1e-12));
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
