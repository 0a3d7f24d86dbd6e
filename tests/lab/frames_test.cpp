// SPDX-License-Identifier: MIT
// labels: threads
// Sequences: frames are samples of a continuous pressure. That it runs along lines or parabolas between them, at
// outputs, fields and sites, is measured by the suite `planner`.
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

} // namespace

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
    const Material chain =
        std::exchange(b.sequence.material, {0, 8e3, {}, {}}); // the rate is the pressure, by lines as by parabolas
    CHECK(plan(b.sequence).fa1_between_frames == 0);
    b.sequence.material = chain;
    CHECK(report(b.sequence, Result()).vibration.value == relative(17.8013, 1e-5));
    CHECK(std::isnan(report(b.table, Result()).vibration.value));
}

TEST_CASE("an output just behind a frame does not magnify what float rounds along parabolas") {
    std::vector<double> values;
    for (int k = 0; k <= 26; ++k) values.push_back(1 + std::sin(0.7 * k));
    const Both b = both(values, 0.02 * (1 - 1e-8), 0.01); // output 2k lies k * 0.2 ns behind frame k
    Scene s = b.sequence;
    s.load.hold = Hold::parabolic;
    s.output.fields.clear();
    s.output.traces = {Quantity::strain, Quantity::sa2, Quantity::fa1};
    RunOptions f32{.precision = Precision::f32}, f64{.precision = Precision::f64};
    const Result rounded = run(s, Device::cpu(), f32), exact = run(s, Device::cpu(), f64);
    for (size_t t = 0; t < exact.traces.size(); ++t)
        CHECK(difference(rounded.traces[t].max, exact.traces[t].max) < 1e-5);
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
