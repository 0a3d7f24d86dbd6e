// SPDX-License-Identifier: MIT
// What a bound covers, and what is measured beside it: means, many steps, released presses, witnesses.
#include "host/lab/march/totals.hpp"
#include "host/lab/run/witness.hpp"
#include "tests/oracle/scene_files.hpp"
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
    return model::total_of<K>(tiles.data(), tiles.size(), tiles.size()).mean;
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

TEST_CASE(
    "a witness of any method but the exact one measures how far it is from the exact one, in rows and in fields") {
    for (auto method : {Method::euler, Method::rk2, Method::rk4, Method::backward_euler, Method::crank_nicolson,
                        Method::sdirk2, Method::published})
        for (auto kind : {Load::Kind::circular, Load::Kind::point}) {
            Scene s;
            s.method = method;
            s.grid = {20, 20, {}};
            s.load.kind = kind;
            s.time = {.step = 0.1, .duration = 1};
            s.output.traces = {Quantity::strain};
            s.output.fields = {{.at = 0.5, .what = {Quantity::strain, Quantity::curvature}}};
            s.tolerance = 1;
            const Result r = run(s, Device::cpu(1));
            CAPTURE(name(method));
            CHECK(r.measured_error <= r.predicted_error);
            CHECK(r.measured_error >= r.predicted_error / 16);
            CHECK(r.measured_cells >= (kind == Load::Kind::point ? 1 : 2));
        }
}

TEST_CASE("a load that presses few cells of any grid, from rest on, is measured and bounded where it presses") {
    const auto file = temporary("from_rest.npy");
    for (const int width : {100, 250, 256, 512})
        for (const double radius : {1, 5, 20, 49}) {
            const auto run_from = [&](double first) {
                std::vector<std::vector<double>> frames;
                for (const double level : {first, 1.0, 0.5}) {
                    std::vector<double>& frame = frames.emplace_back();
                    for (int y = 0; y < 100; ++y)
                        for (int x = 0; x < width; ++x)
                            frame.push_back(std::hypot(x - 61, y - 37) < radius ? level : 0);
                }
                oracle::write_frames(file, {width, 100, {}}, frames);
                Scene s;
                s.grid = {width, 100, {}};
                s.load.kind = Load::Kind::sequence;
                s.load.path = file.string();
                s.load.interval = 0.1;
                s.time = {.step = 0.1, .duration = 0.4};
                s.output.traces = {Quantity::strain, Quantity::sa1};
                s.tolerance = 1e-2;
                return run(s, Device::cpu(1));
            };
            const Result r = run_from(0), pressed = run_from(0.01);
            CAPTURE(width);
            CAPTURE(radius);
            CHECK(r.predicted_error <= 1.01 * pressed.predicted_error);
            CHECK(r.measured_error > 0); // float is never exact here
            CHECK(r.measured_error <= r.predicted_error);
            CHECK(r.measured_cells >= (radius > 1 ? 2 : 1));
        }
    std::filesystem::remove(file);
}

TEST_CASE("a ball that is pressed in from rest to a given depth is bounded as tightly as frames are") {
    Scene s;
    s.grid = {128, 96, 1e-4};
    s.surface.relief = 5e-5;
    s.material.modulus = 1e4, s.material.viscosity = 10;
    s.material.thickness = 1e-3, s.material.curvature_length = 1e-4;
    s.receptors.poisson = 0.4;
    s.load.kind = Load::Kind::ball;
    s.load.control = Load::Control::depth;
    s.load.ball_radius = 5e-3, s.load.intensity = 5e-4;
    s.load.envelope.kind = Envelope::Kind::ramp;
    s.load.envelope.rise = 0.05;
    s.time = {.step = 2e-3, .duration = 0.1};
    s.output.traces = {Quantity::strain, Quantity::sa1};
    s.tolerance = 1e-3;
    const Result r = run(s, Device::cpu(1));
    CHECK(r.measured_error > 0);
    CHECK(r.measured_error <= r.predicted_error);
}

TEST_CASE("the cell of the fastest change tells, though others that are pressed more change slowly") {
    const auto file = temporary("fast_probe.npy");
    std::vector<std::vector<double>> frames;
    for (int n = 0; n < 40; ++n) {
        std::vector<double>& frame = frames.emplace_back(120 * 100);
        for (size_t i = 0; i < 3000; ++i) frame[i] = n / 40.0;
        frame[7777] = n % 2 ? 0.9 : 0;
    }
    oracle::write_frames(file, {120, 100, {}}, frames);
    Scene s;
    s.grid = {120, 100, {}};
    s.load.kind = Load::Kind::sequence;
    s.load.path = file.string();
    s.load.interval = s.time.step = 0.1;
    s.time.duration = 4;
    s.output.traces = {Quantity::fa1};
    const model::PreparedRun run = everything(s);
    const double rate = 0.9 / 1 * 0.5; // of the probe: its pressure over the viscosity, and more than half of it
    CHECK(planner::measured_peaks(run.skin, run.schedule).all[QUANTITY_FA1] >= rate);
    CHECK(run.schedule.changed_most == 7777);
    std::filesystem::remove(file);
}

TEST_CASE("exact numbers measure 0, and where the load presses nothing, nothing is measured") {
    Scene s = held(20, 20);
    s.tolerance = 1e-3;
    s.load.intensity = 0;
    const Result none = run(s, Device::cpu(1));
    CHECK(std::isnan(none.measured_error));
    CHECK(none.measured_cells == 0);
    s.load.intensity = 1;
    s.time = {.step = 0.1, .duration = 0.1}; // one row: the skin at rest
    const Result at_rest = run(s, Device::cpu(1));
    CHECK(at_rest.measured_error == 0);
    CHECK(at_rest.measured_cells >= 4);
}

TEST_CASE("of a sum of loads means and extremes are measured, and what is not measured is said") {
    Scene s = small_scene(40, 30);
    s.receptors.fa2 = Fa2::step_mean;
    s.output.traces = {Quantity::strain, Quantity::sa1, Quantity::fa2};
    s.tolerance = 1e-9;
    CHECK(run(s, Device::cpu(1)).unmeasured == "fa2 in cells, impulses");
    Load other = s.load;
    other.envelope.kind = Envelope::Kind::ramp;
    other.envelope.start = 0.12, other.envelope.rise = 0.5;
    s.more_loads = {other};
    const Result r = run(s, Device::cpu(1));
    CHECK(r.measured_error > 0);
    CHECK(r.measured_error <= r.predicted_error);
    CHECK(r.measured_cells == 0);
    CHECK(r.unmeasured.find("strain in cells, sa1 in cells, fa2 in cells") == 0);
}

TEST_CASE("a mean, a least or a greatest number that is not the map's is found") {
    struct Still : model::Stepper { // a run whose maps are 0
        void frame(const std::vector<double>&) override {}
        void press(const model::Step&) override {}
        void read(const std::vector<Quantity>& what, std::vector<std::vector<double>>& maps) override {
            maps.assign(what.size(), std::vector<double>(40 * 30));
        }
    } still;
    Scene s = small_scene(40, 30);
    s.output.traces = {Quantity::sa1};
    for (double model::Totals::*total : {&model::Totals::mean, &model::Totals::min, &model::Totals::max}) {
        model::PreparedRun run = everything(s);
        const planner::Peaks peaks = planner::measured_peaks(run.skin, run.schedule);
        Candidate taken;
        const auto witness = witness_of(run, taken, peaks);
        model::Timeline timeline(run.schedule, run.skin);
        for (model::Step step; timeline.next(step);) {
            if (step.trace < 0) continue;
            model::Sample sample{.totals = {},
                                 .points = std::vector<double>(run.schedule.points.size() * REDUCED_MAPS)};
            sample.totals[QUANTITY_SA1].*total = 0.5 * peaks.all[QUANTITY_SA1];
            witness->compare(step, sample);
            witness->read(step, still);
        }
        Result result;
        witness->tell(result);
        CHECK(result.measured_error == relative(0.25, 1e-12)); // one of both is off by half of the difference, or more
    }
}

TEST_CASE("witnesses find a sample and a field that are wrong in one of their cells") {
    Scene s = small_scene(40, 30);
    s.output.traces = {Quantity::strain};
    s.output.fields = {{.at = 0, .what = {Quantity::strain}}};
    model::PreparedRun run = everything(s);
    const planner::Peaks peaks = planner::measured_peaks(run.skin, run.schedule);
    Candidate taken;
    taken.model = Model::march;
    taken.precision = Precision::f64;
    const auto witness = witness_of(run, taken, peaks);
    const auto measured = [&] {
        Result result;
        witness->tell(result);
        CHECK(result.measured_cells >= 2);
        return result.measured_error;
    };
    model::Timeline timeline(run.schedule, run.skin);
    for (model::Step step; timeline.next(step);) {
        witness->advance(step.end);
        if (step.trace != 0) continue;
        model::Sample sample{.totals = {}, .points = std::vector<double>(run.schedule.points.size() * REDUCED_MAPS)};
        witness->compare(step, sample); // at rest all are 0
        CHECK(measured() == 0);
        witness->compare(Quantity::strain, std::vector<double>(run.skin.cells()));
        CHECK(measured() == 0);
        std::vector<double> map(run.skin.cells());
        const Cell cell = run.schedule.points.back();
        map[size_t(cell.y) * 40 + size_t(cell.x)] = 0.5 * peaks.all[QUANTITY_STRAIN];
        witness->compare(Quantity::strain, map);
        CHECK(measured() == relative(0.5, 1e-12));
        return;
    }
    FAIL("no output at rest");
}
