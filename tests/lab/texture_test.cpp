// SPDX-License-Identifier: MIT
// labels: device threads
// Textures that slide over the skin.
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/output.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>

using namespace test;

namespace {

constexpr double pi = std::numbers::pi;

// A grating of 1 mm, 20 numbers to the period, that slides at 40 mm/s: 40 Hz.
Scene grating(double step, double duration) {
    Scene s = flat_strip(step, duration);
    Texture t{.map = {}, .width = 40, .height = 3, .spacing = 5e-5, .velocity = {0.04, 0}};
    for (int i = 0; i < 40 * 3; ++i) t.map.edit().push_back(std::cos(2 * pi * (i % 40) / 20.0));
    s.load.texture = t;
    return s;
}

std::string written(const std::string& name, const std::string& shape, const std::vector<double>& values) {
    const auto path = temporary(name + ".npy");
    std::ofstream out(path, std::ios::binary);
    out << npy_header("<f8", shape);
    out.write(reinterpret_cast<const char*>(values.data()), std::streamsize(values.size() * 8));
    return path.string();
}

} // namespace

TEST_CASE("a grating of 1 mm that slides at 40 mm/s vibrates at 40 Hz, with the phasor of the material") {
    const double dt = 2.5e-4, w = 2 * pi * 40;
    const Result r = run(grating(dt, 0.5));
    const std::vector<double>& strain = r.traces[0].probes[0];
    std::complex<double> seen = 0;
    const size_t first = 400, count = strain.size() - first; // whole periods, long after the start
    for (size_t n = first; n < strain.size(); ++n)
        seen += strain[n] * std::polar(1.0, -w * double(n) * dt) / double(count);
    const double sinc = std::sin(w * dt / 2) / (w * dt / 2); // lines between frames keep its square
    const std::complex<double> drive = std::polar(1e3 * sinc * sinc / 2, -2 * pi * 7e-4 / 1e-3);
    const std::complex<double> expected = drive / std::complex<double>(2e4, w * 2e2);
    CHECK(std::abs(seen - expected) < 2e-4 * std::abs(expected));
}

TEST_CASE("a texture is read as it is where its numbers lie on cells, and repeats itself") {
    Scene s = grating(0.01, 0.03);
    Texture t{.map = {}, .width = 5, .height = 4, .spacing = {}, .velocity = {0.01, 0.02}}; // 1 and 2 cells a step
    for (int i = 0; i < 20; ++i) t.map.edit().push_back(std::sin(7.0 * i * i));
    s.load.texture = t;
    std::vector<double> frames;
    for (int k = 0; k < 4; ++k)
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 50; ++x)
                frames.push_back(t.map[size_t(((y - 2 * k) % 4 + 4) % 4 * 5 + ((x - k) % 5 + 5) % 5)]);
    Scene sequence = s;
    sequence.load = {.kind = Load::Kind::sequence,
                     .intensity = 1e3,
                     .path = written("frames", "(4, 8, 50)", frames),
                     .interval = 0.01};
    s.output.fields = sequence.output.fields = {{0.03, {Quantity::strain, Quantity::fa1, Quantity::fa2}}};
    RunOptions f64;
    f64.precision = Precision::f64;
    const Result a = run(s, Device::cpu(), f64), b = run(sequence, Device::cpu(), f64);
    for (size_t i = 0; i < 3; ++i) CHECK(difference(a.fields[i].values, b.fields[i].values) < 1e-12);
    std::filesystem::remove(sequence.load.path);
}

TEST_CASE("a texture that has steps is said to press beyond its numbers, by as much as its spline does") {
    Scene s = grating(0.01, 0.03);
    Texture t{.map = {}, .width = 40, .height = 1, .spacing = 1e-4, .velocity = {0.005, 0}}; // half a cell a step
    for (int i = 0; i < 40; ++i) t.map.edit().push_back(i % 40 < 20 ? 0.0 : 1.0);
    s.load.texture = t;
    s.output.traces = {Quantity::sa1};
    s.output.fields = {{0.01, {Quantity::strain}}};
    s.material = {.modulus = 1e3, .viscosity = 0, .thickness = 1e-3, .curvature_length = 0};
    const Result r = run(s);
    const auto [least, greatest] = std::ranges::minmax(r.fields[0].values); // pressure over the modulus
    const std::vector<std::string> all = output::warnings(s, r);
    REQUIRE(all.size() == 1);
    CHECK_MESSAGE(
        all[0].find("differ by up to 1, and the spline through them passes such a step by about 0.11 on either "
                    "side, from -0.11 to 1.11") != std::string::npos,
        all[0]);
    CHECK(least == doctest::Approx(-0.11).epsilon(0.2));
    CHECK(greatest == doctest::Approx(1.11).epsilon(0.02));
    s.load.texture = grating(0.01, 0.03).load.texture;
    CHECK(output::warnings(s, run(s)).empty());
}

TEST_CASE("a scene file names a texture and its velocity") {
    const std::string path = written("texture", "(2, 3)", {1, 2, 3, 4, 5, 6});
    const std::string grid = "preset = \"fingertip\"\n[load.texture]\n";
    const Scene s =
        Scene::from_string(grid + "path = \"" + path + "\"\nspacing = \"0.2 mm\"\nvelocity = [\"40 mm/s\", 0]\n");
    REQUIRE(s.load.texture);
    CHECK(s.load.texture->width == 3);
    CHECK(s.load.texture->height == 2);
    CHECK(s.load.texture->map[5] == 6);
    CHECK(s.load.texture->velocity[0] == 0.04);
    std::filesystem::remove(path);
}

TEST_CASE("summary.json has the velocity and the repeat of the one pattern that moves") {
    const Folder folder;
    const auto pattern = [&](const Scene& s) {
        output::write_result(output::Folder(folder / "out"), s, run(s), output::origin_of("", {}, {}, {}));
        return output::Json::parse(slurp(folder / "out/summary.json")).at("pattern");
    };
    Scene s = grating(1e-3, 2e-3);
    CHECK(pattern(s)["velocity"] == output::Json{0.04, 0.0});
    CHECK(pattern(s)["repeat"][0] == relative(40 * 5e-5, 1e-14));
    CHECK(pattern(s)["repeat"][1] == relative(3 * 5e-5, 1e-14));
    s.load.texture->velocity = {0, 0};
    CHECK(pattern(s).is_null());
    s.load.texture.reset();
    s.load.grating = Grating{.wavelength = 1e-3, .direction = pi / 3, .velocity = -0.04};
    CHECK(pattern(s)["velocity"][1] == relative(-0.04 * std::sqrt(0.75), 1e-14));
    CHECK(pattern(s)["repeat"][0] == relative(2e-3, 1e-14));
    s.load.grating->direction = pi / 2; // whose cosine in double is 6e-17
    CHECK(pattern(s).dump() == R"({"velocity":[-0.0,-0.04],"repeat":[null,0.001]})");
    s.load.grating->direction = 0;
    CHECK(pattern(s).dump() == R"({"velocity":[-0.04,-0.0],"repeat":[0.001,null]})");
    s.more_loads = {s.load};
    CHECK(pattern(s).is_null());
    s.load.grating.reset();
    CHECK(pattern(s)["velocity"] == output::Json{-0.04, -0.0});
}
