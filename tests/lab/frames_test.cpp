// SPDX-License-Identifier: MIT
// labels: device threads
// Sequences: frames are samples of a continuous pressure.
#include "host/core/press/device.hpp"
#include "host/lab/march/march.hpp"
#include "tests/oracle/scene_files.hpp"
#include "tests/support.hpp"

#include <filesystem>
#include <memory>
#include <numbers>
#include <random>

using namespace test;

namespace {

struct File { // removed at the end
    std::string path;
    File(const std::string& name, const Grid& grid, const std::vector<std::vector<double>>& frames)
        : path(temporary(name).string()) {
        oracle::write_frames(path, grid, frames);
    }
    ~File() { std::filesystem::remove(path); }
};

// A scene with the frames values[k]*map, and the same as a table.
struct Both {
    Scene sequence, table;
    std::unique_ptr<File> file;
};
Both both(const std::vector<double>& values, double interval, double step) {
    Both b;
    b.table = small_scene(14, 10);
    b.table.time = {step, 0.5};
    const std::vector<double> map = maps(b.table).pressure;
    std::vector<std::vector<double>> frames;
    for (double v : values) {
        frames.push_back(map);
        for (double& p : frames.back()) p *= v;
    }
    b.file = std::make_unique<File>("frames.npy", b.table.grid, frames);
    b.sequence = b.table;
    b.sequence.load.kind = Load::Kind::sequence;
    b.sequence.load.path = b.file->path;
    b.sequence.load.interval = interval;
    Envelope& e = b.table.load.envelope;
    e.kind = Envelope::Kind::table;
    e.values = values;
    for (size_t k = 0; k < values.size(); ++k) e.times.push_back(double(k) * interval);
    const std::vector<Quantity> what = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    b.table.output.fields = b.sequence.output.fields = {{0, what}, {0.123, what}, {0.31, what}, {0.4987, what}};
    return b;
}

void check_same(const Result& a, const Result& b, double tolerance) {
    REQUIRE(a.time == b.time);
    for (const Trace& t : b.traces) {
        CAPTURE(name(t.quantity));
        CHECK(difference(a.trace(t.quantity).mean, t.mean) < tolerance);
        CHECK(difference(a.trace(t.quantity).max, t.max) < tolerance);
        CHECK(difference(a.trace(t.quantity).probes[0], t.probes[0]) < tolerance);
    }
    REQUIRE(a.fields.size() == b.fields.size());
    for (size_t i = 0; i < a.fields.size(); ++i) CHECK(difference(a.fields[i].values, b.fields[i].values) < tolerance);
    REQUIRE(a.impulses.size() == b.impulses.size());
    for (size_t i = 0; i < a.impulses.size(); ++i) {
        CHECK(a.impulses[i].time == b.impulses[i].time);
        CHECK(a.impulses[i].mean == relative(b.impulses[i].mean, tolerance));
        CHECK(a.impulses[i].max == relative(b.impulses[i].max, tolerance));
    }
}

const std::vector<double> wavering = {0.8, 1.1, 0.3, 0.9, -0.4, 0.2, 1.7, 1.2, 0.5};

} // namespace

TEST_CASE("frames of one map are a table of its values, however outputs and frames lie to each other") {
    const Validated vulkan;
    for (auto [interval, step, fa2] : {std::tuple{0.05, 0.05, Fa2::step_mean},
                                       {0.05, 0.0125, Fa2::step_mean},
                                       {0.05, 0.05, Fa2::point},
                                       {0.04, 0.1, Fa2::point},
                                       {0.017, 0.05, Fa2::point},
                                       {0.13, 0.05, Fa2::point}}) {
        CAPTURE(interval);
        CAPTURE(step);
        Both b = both(wavering, interval, step);
        b.sequence.receptors.fa2 = b.table.receptors.fa2 = fa2;
        RunOptions f64, check;
        f64.precision = Precision::f64;
        check.check = true;
        const Result truth = run(b.table, Device::cpu(), f64);
        check_same(run(b.sequence, Device::cpu(), f64), truth, 1e-12);
        const Result device = run(b.sequence, vulkan.device(), check);
        CHECK(device.cells_different == 0);
        CHECK(device.cells_compared > 0);
        check_same(device, truth, 2e-5);
        check_same(run(b.sequence, vulkan.device()), truth, 2e-5); // many presses in one submission
    }
}

TEST_CASE("one frame is a step; it meets a skin at rest at t = 0") {
    Both b = both({0.7}, 1, 0.05);
    b.sequence.receptors.fa2 = b.table.receptors.fa2 = Fa2::step_mean;
    b.table.load.envelope = {};
    b.table.load.intensity = 0.7;
    RunOptions f64;
    f64.precision = Precision::f64;
    const Result r = run(b.sequence, Device::cpu(), f64);
    check_same(r, run(b.table, Device::cpu(), f64), 1e-13);
    CHECK(r.impulses.size() == 1);
}

TEST_CASE("a 250 Hz load sampled at 1 kHz has its FA2 within 1 %; held frames would lose it") {
    const double w = 2 * std::numbers::pi * 250;
    std::vector<std::vector<double>> frames;
    for (int k = 0; k <= 200; ++k) frames.push_back({1 + std::sin(w * k * 1e-3 + 0.3)});
    const File file("frames.npy", {1, 1, {}}, frames);
    Scene s;
    s.grid = {1, 1, {}};
    s.time = {1e-3, 0.2};
    s.load.kind = Load::Kind::map;
    s.load.map = {1};
    s.load.envelope.kind = Envelope::Kind::sine;
    s.load.envelope.frequency = 250;
    s.load.envelope.phase = 0.3;
    s.load.envelope.mean = 1;
    s.receptors.fa2 = Fa2::step_mean;
    RunOptions f64;
    f64.precision = Precision::f64;
    const std::vector<double> exact = run(s, Device::cpu(), f64).trace(Quantity::fa2).mean;
    s.load.map = {};
    s.load.kind = Load::Kind::sequence;
    s.load.path = file.path;
    s.load.interval = 1e-3;
    s.load.envelope = {};
    s.receptors.fa2.reset(); // the step mean by itself
    const std::vector<double> framed = run(s, Device::cpu(), f64).trace(Quantity::fa2).mean;
    double worst = 0, largest = 0, held = 0;
    for (size_t n = 20; n < exact.size(); ++n) {
        worst = std::max(worst, std::abs(framed[n] - exact[n]));
        largest = std::max(largest, std::abs(exact[n]));
        // frames held over a step: FA2 as a density is -E/eta of FA1, some (p - E*eps)/eta
        held = std::max(held, std::abs(1.54 * (frames[n][0] - 1)));
    }
    CHECK(worst < 0.01 * largest);
    CHECK(held < 0.03 * largest);
}

namespace {

// The strain at a time of an element under frames h apart, along a line in the first interval, parabolas in the others,
// and held after the last: in each interval a particular solution, and what decays.
double strain_along_parabolas(const std::vector<double>& frames, double h, double E, double eta, double time) {
    const double tau = eta / E;
    double eps = 0;
    for (size_t k = 0; double(k) * h < time; ++k) {
        const bool held = k + 1 >= frames.size();
        const double p = held ? frames.back() : frames[k], ds = held ? 0 : frames[k + 1] - p,
                     c = held || k == 0 ? 0 : (ds - (p - frames[k - 1])) / 2, slope = (ds - c) / h, bow = c / (h * h);
        const auto particular = [&](double t) {
            return (p - tau * slope + 2 * tau * tau * bow + (slope - 2 * tau * bow) * t + bow * t * t) / E;
        };
        const double t = std::min(h, time - double(k) * h);
        eps = particular(t) + (eps - particular(0)) * std::exp(-t / tau);
    }
    return eps;
}

} // namespace

TEST_CASE("along parabolas every time has the exact strain, at frames or between them, on every backend and at sites") {
    Validated vulkan;
    RunOptions check{.check = true};
    const std::vector<double> values = {0.3, 1, 0.8, -0.2, 0, 0, 0.7, 1.1, 0.4, 0.9, 0.1, 0.6};
    for (double step : {0.03, 0.01, 0.007, 0.05}) {
        CAPTURE(step);
        Both b = both(values, 0.03, step);
        Scene& s = b.sequence;
        s.load.hold = Hold::parabolic;
        s.receptors.fa2 = Fa2::point;
        s.material.modulus = 1.5;
        s.material.viscosity = 0.2;
        const std::vector<double> map = maps(s).pressure;
        Scene at_sites = s;
        s.model = Model::march;
        s.precision = Precision::f64;
        const Result r = run(s, Device::cpu());
        for (const Field& f : r.fields) {
            if (f.quantity != Quantity::strain) continue;
            const double eps = strain_along_parabolas(values, 0.03, 1.5, 0.2, f.at);
            for (size_t i = 0; i < map.size(); ++i) CHECK(f.values[i] == absolute(map[i] / values[0] * eps, 1e-13));
        }
        for (Precision precision : {Precision::f32, Precision::f32_compensated}) {
            s.precision = precision;
            CHECK(run(s, vulkan.device(), check).cells_different == 0);
        }
        at_sites.output.fields.clear();
        at_sites.output.traces.clear();
        at_sites.output.probes.clear();
        at_sites.sites = {{Quantity::sa1, {3, 4}}, {Quantity::fa1, {3, 4}}};
        const Result sites = run(at_sites, Device::cpu());
        CHECK(sites.model == Model::sites);
        s.precision = Precision::f64;
        s.output.fields.clear();
        s.output.probes = {{3, 4}};
        const Result all = run(s, Device::cpu());
        for (size_t n = 0; n < all.time.size(); ++n) {
            CHECK(sites.responses[2 * n] == absolute(all.trace(Quantity::sa1).probes[0][n], 1e-12));
            CHECK(sites.responses[2 * n + 1] == absolute(all.trace(Quantity::fa1).probes[0][n], 1e-11));
        }
    }
}

TEST_CASE("a plan says what the frames of a sequence lose, and a report at which frequency they lose a tenth") {
    std::vector<double> values;
    for (int k = 0; k <= 256; ++k) values.push_back(1 + std::sin(0.1 * std::numbers::pi * k));
    Both b = both(values, 0.01, 0.01);
    for (Scene* s : {&b.sequence, &b.table}) {
        s->material.modulus = s->material.viscosity = {};
        s->material.elements = {{2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}};
    }
    // The error of lines (suite hold), up to the error of parabolas.
    const Explanation e = plan(b.sequence);
    CHECK(std::abs(e.strain_between_frames - 2.011e-3) < 2.8e-4);
    CHECK(std::abs(e.fa1_between_frames - 2.276e-2) < 3.9e-3);
    CHECK(std::isnan(plan(b.table).strain_between_frames));
    CHECK(report(b.sequence, Result()).vibration.value == relative(17.8013, 1e-5));
    CHECK(std::isnan(report(b.table, Result()).vibration.value));
}

TEST_CASE(
    "frames may lie beside outputs, and springs have FA1 of them; what is beyond float is refused with its cell") {
    const File good("good.npy", {3, 2, {}}, std::vector<std::vector<double>>(4, std::vector<double>(6, 1.0)));
    Scene s = small_scene(3, 2);
    s.load = {.kind = Load::Kind::sequence, .path = good.path, .interval = 0.05};
    s.time = {0.05, 0.4};
    CHECK(run(s, Device::cpu()).time.size() == 8);
    Scene b = s;
    b.load.interval = 0.07; // no multiple of the step
    b.receptors.fa2 = Fa2::point;
    CHECK(run(b, Device::cpu()).time.size() == 8);
    b = s;
    b.material.viscosity = 0;
    b.output.traces = {Quantity::fa1};
    CHECK(run(b, Device::cpu()).trace(Quantity::fa1).mean.size() == 8);
    s.load.intensity = 1e39;
    s.precision = Precision::f32;
    const std::string why = refusal(Error::Code::bad_input, [&] { run(s, Device::cpu()); });
    for (const char* part : {"load.intensity = 1e+39", "cell [0, 0]", "3.4e38"})
        CHECK_MESSAGE(why.find(part) != std::string::npos, why);
}
