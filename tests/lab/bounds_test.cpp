// SPDX-License-Identifier: MIT
// What a bound covers, and what is measured beside it: means, many steps, released presses, witnesses.
#include "host/core/model/totals.hpp"
#include "host/lab/run/witness.hpp"
#include "tests/support.hpp"

#include <random>

using namespace test;

namespace {

// A skin of one retardation time, 1 s, under a pressure of 1 Pa that is held from 0 on.
Scene held(int width, int height) {
    Scene s;
    s.grid = {width, height, {}};
    s.material.modulus = s.material.viscosity = 1;
    s.load.kind = Load::Kind::map;
    s.load.map = std::vector<double>(size_t(width) * size_t(height), 1.0);
    s.time = {.step = 0.1, .duration = 2};
    s.output.traces = {Quantity::strain};
    return s;
}

// The closed form of such a cell's strain.
double strain_at(double t) { return -std::expm1(-t); }

template <class K> double mean_of(const std::vector<double>& values) {
    std::vector<typename K::Summary> tiles;
    for (double v : values) tiles.push_back(K::summary_of(typename K::real(v)));
    return plan::total_of<K>(tiles.data(), tiles.size(), tiles.size()).mean;
}

} // namespace

TEST_CASE("joining tiles loses no digit that a double of the mean could show, however many they are") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> number(-1, 2);
    for (size_t n : {1u, 2u, 63u, 64u, 65u, 4095u, 4097u, 300000u}) {
        std::vector<double> values(n);
        long double sum = 0, magnitudes = 0, sum_of_floats = 0;
        for (double& v : values) {
            v = number(random);
            sum += v, magnitudes += std::abs(v), sum_of_floats += float(v);
        }
        CAPTURE(n);
        CHECK(std::abs(mean_of<f64>(values) - sum / double(n)) <= 0x1p-53 * double(magnitudes) / double(n));
        CHECK(std::abs(mean_of<f32>(values) - sum_of_floats / double(n)) <= 0x1p-44 * double(magnitudes) / double(n));
    }
    CHECK(mean_of<f32>(std::vector<double>(1000000, 3e38)) == double(3e38f)); // their sum is beyond float
}

TEST_CASE("a mean is as exact as its bound says, on every model and backend") {
    const Validated vulkan;
    for (const Device& device : {Device::cpu(1), Device::cpu(2), vulkan.device()})
        for (auto model : {Model::moments, Model::maps, Model::march}) {
            if (device.info().vulkan && model != Model::march) continue;
            Scene s = held(1000, 300);
            std::mt19937 random(11);
            std::uniform_real_distribution<double> number(0, 1);
            long double sum = 0;
            for (double& p : s.load.map.edit()) sum += p = double(float(number(random)));
            s.model = model;
            s.precision = model != Model::march  ? Precision::f64
                          : device.info().vulkan ? Precision::f32_compensated
                                                 : Precision::f64;
            s.tolerance = *s.precision == Precision::f64 ? 3e-15 : 1e-6;
            s.output.extremes = false;
            const Result r = run(s, device);
            CAPTURE(name(model));
            for (size_t i = 0; i < r.time.size(); ++i) {
                const double exact = double(sum / 300000) * strain_at(0.1 * double(i));
                CHECK(std::abs(r.traces[0].mean[i] - exact) <= r.predicted_error * strain_at(1.9));
            }
        }
}

TEST_CASE("in double a march of a million steps is off by no more than a march of ten") {
    Scene s = held(1, 1);
    s.model = Model::march;
    s.precision = Precision::f64;
    for (double steps : {10.0, 1e6}) {
        s.time = {.step = 1 / steps, .duration = 1 + 0.5 / steps};
        s.tolerance = 1e-13;
        const Result r = run(s, Device::cpu(1));
        const double last = r.traces[0].mean.back();
        CHECK(r.predicted_error < 1e-14);
        CHECK(std::abs(last - strain_at(r.time.back())) <= 1e-15);
    }
}

TEST_CASE("|l*C| is that of the greatest strain, also where a press has been released before the end") {
    const Validated vulkan;
    for (const Device& device : {Device::cpu(1), vulkan.device()})
        for (auto kind : {Envelope::Kind::pulse, Envelope::Kind::table})
            for (bool march : {false, true}) {
                if (device.info().vulkan && !march) continue;
                Scene s = held(9, 9);
                s.surface.kind = Surface::Kind::flat;
                std::fill(s.load.map.edit().begin(), s.load.map.edit().end(), 0.0);
                s.load.map.edit()[4 * 9 + 4] = 1; // alone, so that L(eps) is -4*eps there
                s.load.envelope.kind = kind;
                s.load.envelope.start = 0.5, s.load.envelope.length = 1, s.load.envelope.period = 100;
                s.load.envelope.times = {0, 0.5, 0.5, 1.5, 1.5}, s.load.envelope.values = {0, 0, 1, 1, 0};
                s.material.viscosity = 0.02;
                s.time = {.step = 0.05, .duration = 4};
                if (march) s.model = Model::march;
                const Result r = run(s, device);
                CHECK(r.greatest_gain == relative(4, 1e-5));
            }
}

TEST_CASE("witnesses measure an error where a tolerance binds, on every model, and never above the prediction") {
    const Validated vulkan;
    for (const Device& device : {Device::cpu(1), Device::cpu(2), vulkan.device()})
        for (auto model : {Model::moments, Model::maps, Model::sites, Model::march})
            for (auto precision : {Precision::f32, Precision::f32_compensated, Precision::f64}) {
                const bool march = model == Model::march, f64 = precision == Precision::f64;
                if (march ? f64 && device.info().vulkan : !f64 || device.info().vulkan) continue;
                Scene s = small_scene(40, 30);
                s.model = model;
                s.precision = precision;
                s.sites = {{Quantity::sa1, {3, 4}}, {Quantity::fa1, {20, 15}}};
                s.output.traces = {Quantity::strain, Quantity::fa1};
                if (model == Model::sites) s.output = {.traces = {}, .probes = {}, .fields = {}, .extremes = false};
                CHECK(std::isnan(run(s, device).measured_error));
                s.tolerance = 1e-2;
                const Result r = run(s, device);
                CAPTURE(name(model));
                CAPTURE(name(precision));
                CHECK(r.measured_error <= r.predicted_error);
                if (!f64) CHECK(r.measured_error > 0); // float is never exact here
            }
}

TEST_CASE("witnesses find a sample and a field that are wrong in one of their cells") {
    Scene s = small_scene(40, 30);
    s.output.traces = {Quantity::strain};
    s.output.fields = {{.at = 0, .what = {Quantity::strain}}};
    plan::PreparedRun run = everything(s);
    const planner::Peaks peaks = planner::measured_peaks(run.skin, run.schedule);
    Candidate taken;
    taken.model = Model::march;
    taken.precision = Precision::f64;
    const auto witness = witness_of(run, taken, peaks);
    REQUIRE(witness);
    plan::Timeline timeline(run.schedule, run.skin);
    for (plan::Step step; timeline.next(step);) {
        witness->advance(step.end);
        if (step.trace != 0) continue;
        plan::Sample sample{.totals = {}, .points = std::vector<double>(run.schedule.points.size() * REDUCED_MAPS)};
        witness->compare(step, sample); // at rest all are 0
        CHECK(witness->measured_error() == 0);
        witness->compare(Quantity::strain, std::vector<double>(run.skin.cells()));
        CHECK(witness->measured_error() == 0);
        std::vector<double> map(run.skin.cells());
        const Cell cell = run.schedule.points.back();
        map[size_t(cell.y) * 40 + size_t(cell.x)] = 0.5 * peaks.all[QUANTITY_STRAIN];
        witness->compare(Quantity::strain, map);
        CHECK(witness->measured_error() == relative(0.5, 1e-12));
        return;
    }
    FAIL("no output at rest");
}
