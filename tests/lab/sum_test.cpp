// SPDX-License-Identifier: MIT
// labels: threads
// Loads that are sums of products of a map and an envelope. Sums and windows are drawn by the suite `planner`; gratings
// that move are here.
#include "tests/oracle/scene_files.hpp"
#include "tests/support.hpp"

#include <complex>
#include <filesystem>
#include <numbers>

using namespace test;

namespace {

constexpr double half_turn = std::numbers::pi; // rad
const std::vector<Quantity> every = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};

// A skin without relief whose responses are its signals, under a grating of 1 mm that moves at 40 mm/s.
Scene moving_grating(double step, double duration) {
    Scene s = flat_strip(step, duration);
    s.load.grating = {.wavelength = 1e-3, .velocity = 0.04, .amplitudes = {0.5, 0.25}, .phases = {0, 0.7}};
    s.output.traces = every;
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

} // namespace

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
