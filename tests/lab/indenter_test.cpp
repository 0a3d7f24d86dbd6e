// SPDX-License-Identifier: MIT
// labels: device threads
// What is pressed to a depth beside a round punch: elliptic punches, balls, and cells by themselves.
#include "host/lab/output/output.hpp"
#include "tests/oracle/real.hpp"
#include "tests/oracle/scene_files.hpp"
#include "tests/support.hpp"

#include <filesystem>
#include <numbers>

using namespace test;

namespace {

constexpr double E_end = 5e4, E_once = 2e5, nu = 0.4; // of the preset: the modulus in the end and at once, Pa

// The preset's material on a flat skin.
Scene flat_skin(int cells, double spacing) {
    Scene s = flat_finger(cells, spacing);
    s.time = {.step = 0.01, .duration = 0.5};
    return s;
}

// A ball of 5 mm.
Scene ball(int cells, double spacing, double depth) {
    Scene s = flat_skin(cells, spacing);
    s.load.kind = Load::Kind::ball;
    s.load.intensity = depth;
    s.load.ball_radius = 5e-3;
    return s;
}

// The creep J(t) of a material, 1/Pa.
double creep(const Material& m, double t) {
    double J = m.spring ? 1 / *m.spring : 0;
    for (const KelvinVoigt& e : m.elements)
        J += (e.viscosity > 0 ? 1 - std::exp(-t * e.modulus / e.viscosity) : 1) / e.modulus;
    return J;
}

// The response of a site at an output.
double response_of(const Result& r, const Scene& s, size_t site, size_t n) {
    return r.responses[n * s.sites.size() + site];
}

// E(t) of the preset over its end.
double relaxed(double t) { return 1 + std::exp(-t / 0.004) + std::exp(-t / 0.07) + std::exp(-t / 1.4); }

std::string depth_frames(const Grid& grid, const std::vector<std::vector<double>>& frames) {
    const auto path = temporary("depths.npy");
    oracle::write_frames(path, grid, frames);
    return path.string();
}

using oracle::Real;

// The integral of (1 - x^2 - y^2)^(-1/2), or of (1 - x^2 - y^2)^(1/2), over what the rectangle from [0, 0] to [u, v]
// and the unit circle have in common.
Real to_corner(Real u, Real v, bool flat) {
    const Real one = 1.0, s2 = one - u * u - v * v, s = sqrt(s2 < Real(0.0) ? Real(0.0) : s2), across = atan2(v, s),
               down = atan2(u, s), both = atan2(u * v, s);
    if (flat) return u * across + v * down - both;
    return (Real(2.0) * (u * v * s - both) + u * (Real(3.0) - u * u) * across + v * (Real(3.0) - v * v) * down) /
           Real(6.0);
}

// The same over the cell x columns and y rows from the middle, in an ellipse of the half-axes a and b in cells.
Real in_cell(int x, int y, const Real& a, const Real& b, bool flat) {
    const auto corner = [&](double i, double j) {
        const Real u = Real(std::abs(i)) / a, v = Real(std::abs(j)) / b, one = 1.0;
        const Real at = to_corner(u < one ? u : one, v < one ? v : one, flat);
        return i * j < 0 ? -at : at;
    };
    return corner(x + 0.5, y + 0.5) - corner(x - 0.5, y + 0.5) - corner(x + 0.5, y - 0.5) + corner(x - 0.5, y - 0.5);
}

// Units of double's last place by which some cells of a map are off `factor` times the integrals, at most: the cells
// beside the middle, those around some points of the rim, and some others.
double units_off(const Scene& s, const Map& map, const Real& factor, const Real& a, const Real& b, bool flat) {
    const int width = s.grid.width, height = s.grid.height, x0 = s.load.center ? s.load.center->x : width / 2,
              y0 = s.load.center ? s.load.center->y : height / 2;
    double worst = 0;
    const auto look = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= width || y >= height) return;
        const Real exact = factor * in_cell(x - x0, y - y0, a, b, flat);
        const double is = map[size_t(y) * size_t(width) + size_t(x)], rounded = double(exact.rounded());
        const double off = double(abs(Real(is) - exact).rounded());
        const double of =
            flat ? std::abs(rounded) : *std::ranges::max_element(map); // the rim of a ball's contact moves
        if (off > 1e-60) worst = std::max(worst, off / (of * 0x1p-52));
    };
    const double A = double(a.rounded()), B = double(b.rounded());
    for (int i = 0; i < 40; ++i) {
        const double angle = std::numbers::pi / 2 * std::pow(i / 39.0, 1 + i % 3);
        for (int k = 0; k < 16; ++k)
            look(x0 + int(A * std::cos(angle)) + k / 4 - 2, y0 + int(B * std::sin(angle)) + k % 4 - 2);
        look(int(1e9 * angle) % width, int(7e8 * angle) % height);
    }
    for (int k = 0; k < 9; ++k) look(x0 + k / 3 - 1, y0 + k % 3 - 1);
    return worst;
}

} // namespace

TEST_CASE("every cell of a punch's map is right to two units of double's last place") {
    double worst = 0;
    for (auto [a, b] : {std::pair{1, 1},
                        {1, 2},
                        {2, 3},
                        {3, 3},
                        {5, 4},
                        {7, 30},
                        {20, 20},
                        {100, 99},
                        {220, 220},
                        {300, 1},
                        {1, 65536},
                        {997, 1000},
                        {1000, 20},
                        {4096, 4096},
                        {65536, 65536}}) {
        CAPTURE(a);
        CAPTURE(b);
        Scene s = flat_skin(3, 1e-4);
        const auto beyond = [](int n) { return std::clamp(n + 3, 8, n > 5000 ? 8 : 1010); };
        s.grid.width = beyond(a), s.grid.height = beyond(b);
        s.load.kind = Load::Kind::punch;
        s.load.radius = a, s.load.radius_y = b;
        s.load.intensity = 0x1p-10;
        const Real A = double(a), B = double(b);
        Real mean = A, other = B;
        for (int i = 0; i < 20; ++i) {
            const Real product = mean * other;
            mean = (mean + other) / Real(2.0);
            other = sqrt(product);
        }
        for (Cell center : {Cell{1, 2}, Cell{s.grid.width - 1, s.grid.height - 1}}) {
            s.load.center = center;
            s.output.probes = {center};
            const Real factor = mean * Real(0x1p-10) / (Real::pi() * (Real(1.0) - Real(nu) * Real(nu)) * Real(1e-4));
            const double off = units_off(s, maps(s).pressure, factor, A, B, true);
            CHECK(off <= 2);
            worst = std::max(worst, off);
        }
    }
    CHECK(worst > 0.5); // so that the reference is not the map itself
}

TEST_CASE("every cell below a ball has its strain to two units of the last place of the greatest strain") {
    double worst = 0;
    for (double depth : {0x1p-40, 0x1p-24, 0x1p-16, 0x1p-12, 0x1p-9}) // contacts of 0.0007 cells to 31 cells
        for (double spacing : {1e-4, 1e-5}) {
            CAPTURE(depth);
            CAPTURE(spacing);
            Scene s = ball(spacing < 1e-4 ? 700 : 70, spacing, depth);
            const Real R = 5e-3, a = sqrt(R * Real(depth)) / Real(spacing);
            const Real factor =
                Real(2.0) * sqrt(R * Real(depth)) * a * a / (Real::pi() * (Real(1.0) - Real(nu) * Real(nu)) * R);
            const double off = units_off(s, maps(s).pressure, factor, a, a, false);
            CHECK(off <= 2);
            worst = std::max(worst, off);
        }
    CHECK(worst > 0.5);
}

TEST_CASE("an elliptic punch has Johnson's force and pressure, and with equal half-axes it is the round one") {
    for (auto [a, b] : {std::pair{20, 8}, {5, 25}, {12, 12}}) {
        Scene s = flat_skin(71, 5e-5);
        s.load.kind = Load::Kind::punch;
        s.load.radius = a;
        s.load.radius_y = b;
        const Map map = maps(s).pressure; // 1/m
        const double major = 5e-5 * std::max(a, b), minor = 5e-5 * std::min(a, b);
        double K = 0; // the complete elliptic integral, by the rule that converges at once for what repeats itself
        for (int i = 0; i < 400; ++i) {
            const double sine = std::sin((i + 0.5) * std::numbers::pi / 800);
            K += std::numbers::pi / 800 / std::sqrt(1 - (1 - minor * minor / (major * major)) * sine * sine);
        }
        const double force = std::numbers::pi * major / ((1 - nu * nu) * K); // per Pa and m
        CHECK(sum_of(map) * 5e-5 * 5e-5 == relative(force, 1e-12));
        const double middle = force / (2 * std::numbers::pi * major * minor);
        const auto at = [&](int x, int y) { return map[size_t((35 + y) * 71 + 35 + x)]; };
        CHECK(at(0, 0) == relative(middle, 5e-3)); // the mean over a cell
        CHECK(at(a / 2, b / 2) ==
              relative(middle / std::sqrt(1 - std::pow(double(a / 2) / a, 2) - std::pow(double(b / 2) / b, 2)), 2e-2));
        CHECK(at(a + 1, 0) == 0);
        CHECK(at(0, b + 1) == 0);
        CHECK(at(a - 1, b - 1) == 0);
        s.load.radius_y.reset();
        if (a == b) CHECK(maps(s).pressure.values() == map.values());
    }
}

TEST_CASE("a punch that reaches beyond the grid presses the cells of the grid as if the grid were larger") {
    Scene s = flat_skin(31, 1e-4), large = flat_skin(61, 1e-4);
    s.load.kind = large.load.kind = Load::Kind::punch;
    s.load.radius = large.load.radius = 20;
    const Map map = maps(s).pressure, of_large = maps(large).pressure;
    for (int y = 0; y < 31; ++y)
        for (int x = 0; x < 31; ++x)
            CHECK(map[size_t(y * 31 + x)] == relative(of_large[size_t((y + 15) * 61 + x + 15)], 1e-11));
}

TEST_CASE("an elastic ball has the force and the pressure of Hertz") {
    for (double depth : {2e-8, 1e-4, 4e-4}) { // the contact is less than a cell, 0.71 and 1.4 mm
        Scene s = ball(41, 1e-4, depth);
        const Map strain = maps(s).pressure; // at the first output: the elastic limit is this times E
        CHECK(sum_of(strain) * 1e-8 ==
              relative(4.0 / 3 / (1 - nu * nu) * std::sqrt(5e-3) * std::pow(depth, 1.5), 1e-11));
        const double contact = std::sqrt(5e-3 * depth),
                     middle = 2 / (std::numbers::pi * (1 - nu * nu) * 5e-3) * contact;
        if (contact < 1e-4) continue;
        CHECK(strain[20 * 41 + 20] == relative(middle, 5e-3));
        CHECK(strain[20 * 41 + 25] == relative(middle * std::sqrt(1 - 25e-8 / (contact * contact)), 1e-2));
        CHECK(strain[20 * 41 + 20 + int(contact * 1e4 + 1.5)] == 0);
    }
}

TEST_CASE("a ball that sinks as Lee and Radok say bears a constant force") {
    constexpr double R = 5e-3, F = 0.1, dt = 5e-4;
    Scene s = ball(41, 1e-4, 1);
    s.time = {.step = dt, .duration = 0.2};
    s.load.envelope = {.kind = Envelope::Kind::table};
    for (int n = 0; n <= 400; ++n) {
        const double contact = std::cbrt(0.75 * (1 - nu * nu) * R * F * creep(s.material, n * dt));
        s.load.envelope.times.push_back(n * dt);
        s.load.envelope.values.push_back(contact * contact / R);
    }
    s.receptors.follow.sa1 = Signal::stress;
    s.material.curvature_length = 0;
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 41; ++x) s.sites.push_back({Quantity::sa1, {x, y}});
    s.output.traces = {};
    s.output.probes = {};
    const Result r = run(s);
    CHECK(r.model == Model::sites);
    double at_once = 0;
    for (size_t n = 1; n < r.time.size(); ++n) {
        double force = 0;
        for (size_t i = 0; i < s.sites.size(); ++i) force += E_end * response_of(r, s, i, n) * 1e-8;
        if (n == 1) at_once = force;
        CHECK(force == relative(F, n < 20 ? 5e-3 : 1e-3)); // the depth runs linearly between outputs
    }
    CHECK(at_once == relative(F, 5e-3));
}

TEST_CASE("the indentation of a punch and of a ball is the depth that they are pressed to") {
    Scene s = flat_skin(60, 1e-4);
    s.load.kind = Load::Kind::punch;
    s.load.radius = 10;
    s.load.intensity = 8e-4;
    s.material.thickness = 1e-3;
    s.load.envelope = {.kind = Envelope::Kind::ramp, .rise = 0.1};
    s.time = {.step = 0.01, .duration = 0.2};
    CHECK(report(s, run(s)).indentation.value == relative(8e-4, 1e-12));
    s.load.intensity = 1.2e-3;
    const std::vector<std::string> all = output::warnings(s, run(s));
    REQUIRE(!all.empty());
    CHECK(all.back() == "the indentation reaches 0.0012 m, beyond material.thickness = 0.001 m: lower load.intensity");
    Scene round = ball(31, 1e-4, 2e-4);
    CHECK(report(round, run(round)).indentation.value == relative(2e-4, 1e-12));
}

TEST_CASE("a map of depths strains each cell by depth over thickness, and nowhere pulls") {
    Scene s = flat_skin(4, 1e-3);
    s.material.thickness = 2e-3;
    std::vector<double> depths;
    for (int i = 0; i < 16; ++i) depths.push_back(1e-4 * (i - 6));
    s.load.kind = Load::Kind::map;
    s.load.map = depths;
    s.load.envelope = {.kind = Envelope::Kind::ramp, .rise = 0.2};
    s.output.fields = {{0.1, {Quantity::strain}}, {0.4, {Quantity::strain}}};
    s.tolerance = 1e-12;
    for (double sign : {1.0, -1.0}) {
        s.load.intensity = sign;
        const Result r = run(s);
        for (size_t i = 0; i < 16; ++i) {
            const double strain = std::max(0.0, sign * depths[i]) / 2e-3;
            CHECK(r.fields[0].values[i] == relative(strain / 2, 1e-12));
            CHECK(r.fields[1].values[i] == relative(strain, 1e-12));
        }
        CHECK(output::warnings(s, r).back().find("cells do not couple") != std::string::npos);
    }
    s.load = {.kind = Load::Kind::sequence, .interval = 0.1, .control = Control::depth};
    std::vector<double> less = depths;
    for (double& d : less) d *= -0.5;
    s.load.path = depth_frames(s.grid, {depths, less});
    s.output.fields = {{0.05, {Quantity::strain}}, {0.4, {Quantity::strain}}};
    const Result r = run(s);
    for (size_t i = 0; i < 16; ++i) {
        const double first = std::max(0.0, depths[i]) / 2e-3, last = std::max(0.0, -0.5 * depths[i]) / 2e-3;
        CHECK(r.fields[0].values[i] == relative((first + last) / 2, 1e-12));
        CHECK(r.fields[1].values[i] == relative(last, 1e-12));
    }
    std::filesystem::remove(s.load.path);
}

TEST_CASE("the stress under a map that is held relaxes as the material, as a map and as frames") {
    for (bool framed : {false, true}) {
        Scene s = flat_skin(3, 1e-3);
        s.load.kind = Load::Kind::map;
        s.load.map = std::vector<double>(9, 3e-4);
        if (framed) {
            s.load = {.kind = Load::Kind::sequence, .interval = 0.01, .control = Control::depth};
            s.load.path = depth_frames(s.grid, {std::vector<double>(9, 3e-4)});
        }
        s.receptors.follow = {.sa1 = Signal::stress, .sa2 = Signal::stress};
        s.sites = {{Quantity::sa1, {1, 1}}, {Quantity::sa2, {0, 2}}, {Quantity::fa1, {1, 1}}};
        s.output.traces = {};
        s.output.probes = {};
        s.tolerance = 1e-10;
        const Result r = run(s);
        CHECK(r.model == Model::sites);
        CHECK(r.predicted_error < 1e-10);
        CHECK(r.measured_error <= r.predicted_error);
        for (size_t n = 1; n < r.time.size(); ++n) {
            const double t = r.time[n];
            double integral = t;
            for (double tau : {0.004, 0.07, 1.4}) integral += tau * (1 - std::exp(-t / tau));
            CHECK(response_of(r, s, 0, n) == relative(0.3 * relaxed(t), 1e-9));
            CHECK(response_of(r, s, 1, n) == relative(0.3 * integral, 1e-9));
            CHECK(response_of(r, s, 2, n) == 0);
        }
        if (framed) std::filesystem::remove(s.load.path);
    }
}

TEST_CASE("a receptor at a depth below a ball follows the stress there, and its curvature the strain") {
    Scene s = ball(21, 2e-4, 3e-4);
    s.load.envelope = {.kind = Envelope::Kind::ramp, .rise = 0.05};
    s.surface = fingertip().surface;
    s.receptors.depth.sa1 = 5e-4;
    s.sites = {{Quantity::sa1, {10, 10}}, {Quantity::sa2, {10, 10}}, {Quantity::fa1, {12, 9}}};
    s.output.traces = {};
    s.output.probes = {};
    s.tolerance = 1e-9;
    const Result strain = run(s);
    s.receptors.follow.sa1 = Signal::stress;
    const Result stress = run(s);
    for (size_t n = 0; n < strain.time.size(); ++n)
        for (size_t i : {1, 2}) CHECK(response_of(strain, s, i, n) == response_of(stress, s, i, n));
    CHECK(stress.measured_error <= stress.predicted_error);
    const size_t last = strain.time.size() - 1; // held for 0.44 s, which two of three times have not forgotten
    CHECK(response_of(stress, s, 0, last) / response_of(strain, s, 0, last) > 1.7);
    CHECK(response_of(stress, s, 0, last) < response_of(stress, s, 0, 6));
    CHECK(response_of(strain, s, 0, last) == relative(response_of(strain, s, 0, 6), 1e-12));
}

TEST_CASE("a scene file presses ellipses, balls and depths") {
    const std::string begin = "preset = \"fingertip\"\n[load]\ncontrol = \"depth\"\n",
                      output = "[output]\ntraces = [\"sa1\"]\n";
    const Scene s =
        Scene::from_string(begin + "kind = \"ball\"\nball_radius = \"5 mm\"\nintensity = \"0.3 mm\"\n" + output);
    CHECK(s.load.kind == Load::Kind::ball);
    CHECK(s.load.ball_radius == 5e-3);
    CHECK(s.load.intensity == relative(3e-4, 1e-15));
    CHECK(Scene::from_string(begin + "kind = \"punch\"\nradius = 8\nradius_y = 20\n" + output).load.radius_y == 20);
}
