// SPDX-License-Identifier: MIT
// labels: threads
// Loads that are sums of products of a map and an envelope: several loads, gratings that move, windows.
#include "tests/oracle/scene_files.hpp"
#include "tests/support.hpp"

#include <complex>
#include <filesystem>
#include <numbers>

using namespace test;

namespace {

constexpr double half_turn = std::numbers::pi; // rad
const std::vector<Quantity> every = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};

double greatest_of(const std::vector<double>& values) {
    double most = 0;
    for (double v : values) most = std::max(most, std::abs(v));
    return most;
}

// Strong ridges under a smooth load, in an odd material, so that curvature and all terms count.
Scene ridged() {
    Scene s = small_scene(21, 17);
    s.material = {.modulus = 1.3, .viscosity = 0.4};
    s.load.intensity = 0.2;
    s.output.traces = every;
    s.output.fields = {{0.13, {Quantity::sa1, Quantity::fa2, Quantity::curvature, Quantity::deformation}}};
    for (int i = 0; i < 12; ++i) s.sites.push_back({all_responses[i % 4], {(5 * i) % 21, (7 * i) % 17}});
    return s;
}

// The greatest difference of two results, by the greatest value of each of their outputs.
double difference_of(const Result& a, const Result& b) {
    double most = difference(a.responses, b.responses);
    for (size_t t = 0; t < a.traces.size(); ++t) {
        const Trace &x = a.traces[t], &y = b.traces[t];
        const double greatest = std::max(greatest_of(y.max), greatest_of(y.min));
        for (auto of : {&Trace::mean, &Trace::min, &Trace::max})
            for (size_t n = 0; n < (x.*of).size(); ++n)
                most = std::max(most, std::abs((x.*of)[n] - (y.*of)[n]) / greatest);
        for (size_t p = 0; p < x.probes.size(); ++p)
            for (size_t n = 0; n < x.probes[p].size(); ++n)
                most = std::max(most, std::abs(x.probes[p][n] - y.probes[p][n]) / greatest);
    }
    for (size_t f = 0; f < a.fields.size(); ++f)
        most = std::max(most, difference(a.fields[f].values, b.fields[f].values));
    return most;
}

// A skin without relief whose responses are its signals, under a grating of 1 mm that moves at 40 mm/s.
Scene moving_grating(double step, double duration) {
    Scene s;
    s.grid = {.width = 50, .height = 8, .spacing = 1e-4};
    s.surface = {.kind = Surface::Kind::flat, .relief = 1e-6};
    s.material = {.modulus = 2e4, .viscosity = 2e2, .thickness = 1e-3, .curvature_length = 0};
    s.load = {.kind = Load::Kind::map, .intensity = 1e3, .map = std::vector<double>(50 * 8, 1)};
    s.load.grating = {.wavelength = 1e-3, .velocity = 0.04, .amplitudes = {0.5, 0.25}, .phases = {0, 0.7}};
    s.time = {.step = step, .duration = duration};
    s.output.traces = every;
    s.output.probes = {{7, 4}};
    return s;
}

// The pressure of that grating in a cell, by its definition.
double pressure_at(const Scene& s, int x, int y, double t) {
    const Grating& g = *s.load.grating;
    const double along = *s.grid.spacing * (x * std::cos(g.direction) + y * std::sin(g.direction)) - g.velocity * t;
    double factor = 1;
    for (size_t n = 1; n <= g.amplitudes.size(); ++n)
        factor += g.amplitudes[n - 1] * std::cos(double(n) * 2 * half_turn * along / g.wavelength + g.phases[n - 1]);
    return s.load.intensity * s.load.map[size_t(y) * size_t(s.grid.width) + size_t(x)] * factor;
}

// The strain of an element under a pressure from t = 0 on, by Gauss's rule of three points in each of many parts.
template <class Of> double strain_at(double t, double modulus, double viscosity, Of pressure) {
    constexpr int parts = 20000;
    constexpr double nodes[3] = {-0.7745966692414834, 0, 0.7745966692414834},
                     weights[3] = {5.0 / 18, 4.0 / 9, 5.0 / 18};
    double sum = 0;
    for (int i = 0; i < parts; ++i)
        for (int k = 0; k < 3; ++k) {
            const double s = t * (i + 0.5 + nodes[k] / 2) / parts;
            sum += weights[k] * t / parts * pressure(s) * std::exp(-(t - s) * modulus / viscosity) / viscosity;
        }
    return sum;
}

} // namespace

TEST_CASE("two loads of one envelope press as the sum of their maps") {
    Scene one = ridged(), two = one;
    one.load.envelope = {.kind = Envelope::Kind::ramp, .start = 0.04, .rise = 0.17};
    two.load = one.load;
    Load small = one.load;
    small.center = Cell{6, 12};
    small.radius = 3;
    small.intensity = -0.07;
    two.more_loads = {small};
    std::vector<double> map = maps(two).pressure;
    one.load.kind = Load::Kind::map;
    one.load.intensity = 1;
    one.load.map = map;
    const Result a = run(two), b = run(one);
    CHECK(int(a.model) == int(Model::maps));
    CHECK(difference_of(a, b) < 1e-13);
    CHECK(a.pressed_cells == b.pressed_cells);
    CHECK(a.greatest_curvature == doctest::Approx(b.greatest_curvature).epsilon(1e-12));
}

TEST_CASE("one load in two halves of time presses as the whole, and its jumps are impulses") {
    Scene one = ridged(), two = one;
    one.load.envelope = {.kind = Envelope::Kind::table, .times = {0.03, 0.2, 0.2}, .values = {1, 1, 3}};
    two.load.envelope = {.kind = Envelope::Kind::step, .start = 0.03};
    two.more_loads = {two.load};
    two.more_loads[0].intensity *= 2;
    two.more_loads[0].envelope.start = 0.2;
    const Result a = run(two), b = run(one);
    CHECK(difference_of(a, b) < 1e-13);
    REQUIRE(a.impulses.size() == 2);
    REQUIRE(b.impulses.size() == 2);
    for (size_t i = 0; i < 2; ++i) {
        CHECK(a.impulses[i].time == b.impulses[i].time);
        CHECK(a.impulses[i].mean == doctest::Approx(b.impulses[i].mean).epsilon(1e-12));
        CHECK(a.impulses[i].max == doctest::Approx(b.impulses[i].max).epsilon(1e-12));
    }
}

TEST_CASE("below several loads a receptor at a depth has the sum of what each causes there") {
    Scene s = ridged();
    s.grid.spacing = 5e-5;
    s.surface.relief = 2e-5;
    s.material = {.modulus = 2e4, .viscosity = 1e3, .thickness = 1e-3, .curvature_length = 0};
    s.receptors.depth = {.sa1 = 1e-4, .sa2 = 1e-3, .fa1 = 3e-4, .fa2 = 3e-4};
    s.output.fields.clear();
    Scene first = s, second = s;
    second.load.center = Cell{6, 12};
    second.load.envelope = {.kind = Envelope::Kind::sine, .frequency = 9};
    s.more_loads = {second.load};
    const Result both = run(s), a = run(first), b = run(second);
    std::vector<double> sum = a.responses;
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += b.responses[i];
    CHECK(difference(both.responses, sum) < 1e-14);
    for (size_t t = 0; t < every.size(); ++t)
        for (size_t n = 0; n < both.time.size(); ++n)
            CHECK(both.traces[t].mean[n] ==
                  doctest::Approx(a.traces[t].mean[n] + b.traces[t].mean[n]).epsilon(1e-12).scale(1e-6));
}

TEST_CASE("a grating of 1 mm that moves at 40 mm/s vibrates at 40 Hz, with the phasor of the material") {
    const Scene s = moving_grating(1e-3, 0.5);
    const Result r = run(s);
    const auto response = [&](double t, int derivative) {
        double sum = derivative == 0 ? 1e3 / 2e4 : 0;
        for (int n = 1; n <= 2; ++n) {
            const double w = 2 * half_turn * 40 * n;
            const std::complex<double> drive =
                std::polar(1e3 * s.load.grating->amplitudes[size_t(n - 1)],
                           n * (2 * half_turn * 7e-4 / 1e-3) + s.load.grating->phases[size_t(n - 1)] - w * t);
            sum += (drive / std::complex<double>(2e4, -w * 2e2) * std::pow(std::complex<double>(0, -w), derivative))
                       .real();
        }
        return sum;
    };
    double off[3] = {}, greatest[3] = {};
    int crossings = 0;                             // of FA1, upwards
    for (size_t n = 400; n < r.time.size(); ++n) { // what the start left behind has decayed by e^-40
        for (int d = 0; d < 3; ++d) {
            const std::vector<double>& probe = r.traces[d == 0 ? 0 : size_t(d + 2)].probes[0];
            off[d] = std::max(off[d], std::abs(probe[n] - response(r.time[n], d)));
            greatest[d] = std::max(greatest[d], std::abs(probe[n]));
        }
        const std::vector<double>& fa1 = r.traces[3].probes[0];
        crossings += fa1[n - 1] < 0 && fa1[n] >= 0;
    }
    CHECK(crossings == 4); // within 100 ms
    for (int d = 0; d < 3; ++d) CHECK(off[d] < 1e-9 * greatest[d]);
}

TEST_CASE("a grating is the limit of explicit frames, in any direction") {
    Scene s = moving_grating(2e-3, 0.02);
    s.load.grating->direction = 0.6;
    s.load.grating->velocity = -0.03;
    s.material.curvature_length = 1e-4;
    s.output.traces = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1};
    const double interval = s.time.step / 64;
    const int frames = int(s.time.duration / interval) + 1;
    const auto path = temporary("grating.npy");
    std::vector<std::vector<double>> pressures(static_cast<size_t>(frames));
    for (int k = 0; k < frames; ++k)
        for (int i = 0; i < 8 * 50; ++i) pressures[size_t(k)].push_back(pressure_at(s, i % 50, i / 50, k * interval));
    oracle::write_frames(path, s.grid, pressures);
    Scene framed = s;
    framed.load = {.kind = Load::Kind::sequence, .path = path.string(), .interval = interval, .hold = Hold::parabolic};
    framed.precision = Precision::f64;
    const Result a = run(s), b = run(framed);
    std::filesystem::remove(path);
    for (size_t t = 0; t < a.traces.size(); ++t) {
        const double greatest = std::max(greatest_of(b.traces[t].max), greatest_of(b.traces[t].min));
        for (size_t n = 0; n < a.time.size(); ++n)
            for (auto of : {&Trace::mean, &Trace::min, &Trace::max})
                CHECK(std::abs((a.traces[t].*of)[n] - (b.traces[t].*of)[n]) < 1e-6 * greatest);
    }
}

TEST_CASE("a window multiplies a step and a sine, whatever the step of the run") {
    Scene s = ridged();
    s.grid.spacing = s.surface.relief = s.material.thickness = 1;
    s.material.curvature_length = 0; // responses are signals
    s.output = {.traces = {Quantity::strain}, .probes = {{10, 8}}, .fields = {}};
    s.load.intensity = 1;
    const double p = maps(s).pressure[8 * 21 + 10];
    const Envelope::Window window{.start = 0.03, .rise = 0.11, .until = 0.21, .fall = 0.08};
    const auto weight = [&](double t) {
        if (t < 0.03 || t > 0.29) return 0.0;
        return t < 0.14 ? (t - 0.03) / 0.11 : t < 0.21 ? 1 : (0.29 - t) / 0.08;
    };
    for (bool sine : {false, true}) {
        Envelope& e = s.load.envelope;
        e = {.kind = sine ? Envelope::Kind::sine : Envelope::Kind::step};
        e.frequency = 17;
        e.phase = 0.4;
        e.mean = 0.3;
        e.window = window;
        const auto pressure = [&](double t) {
            return p * weight(t) * (sine ? 0.3 + std::sin(2 * half_turn * 17 * t + 0.4) : 1);
        };
        for (double step : {0.05, 0.0125})
            for (const auto& [model, most] : {std::pair{Model::moments, 1e-7}, {Model::march, 1e-6}}) {
                s.time = {.step = step, .duration = 0.4};
                s.model = model;
                const Result r = run(s);
                for (size_t n = 0; n < r.time.size(); ++n)
                    CHECK(std::abs(r.traces[0].probes[0][n] - strain_at(r.time[n], 1.3, 0.4, pressure)) < most);
            }
    }
}

TEST_CASE("a scene file lists loads") {
    const std::string text = "[[load]]\nradius = 9\n[[load]]\nkind = \"linear\"\nintensity = \"2 Pa\"\n"
                             "envelope = \"sine\"\nwindow = { rise = \"20 ms\", until = 2 }\n"
                             "[[load]]\ngrating = { wavelength = 8, velocity = 3, amplitudes = [0.5], phases = [1] }\n";
    const Scene s = Scene::from_string(text, {"load[1].frequency=50"});
    REQUIRE(s.more_loads.size() == 2);
    CHECK(s.load.radius == 9);
    CHECK(s.more_loads[0].intensity == 2);
    CHECK(s.more_loads[0].envelope.frequency == 50);
    REQUIRE(s.more_loads[0].envelope.window);
    CHECK(s.more_loads[0].envelope.window->rise == 0.02);
    REQUIRE(s.more_loads[1].grating);
    CHECK(s.more_loads[1].grating->phases == std::vector<double>{1});
    refuses([&] { Scene::from_string(text, {"load.radius=3"}); }, "a table of the list is load[0]");
}
