// SPDX-License-Identifier: MIT
// The published study's own numbers.
#include "host/lab/scenes/scene.hpp"
#include "tests/oracle/oracle.hpp"
#include "tests/support.hpp"

#include <numeric>

using namespace test;

namespace {

const Cell probes[] = {{75, 75}, {85, 85}, {60, 80}, {37, 37}, {112, 112}};

Scene published_scene(const std::string& surface, const std::string& load) {
    Scene s;
    s.model = Model::march;
    s.method = Method::published;
    if (surface != "flat") {
        s.surface.kind = Surface::Kind::map;
        s.surface.map = read_map("surface_" + surface + "_150.npy");
    }
    s.load.kind = Load::Kind::map;
    s.load.map = read_map("pressure_" + load + "_150.npy");
    s.output.probes.assign(std::begin(probes), std::end(probes));
    s.output.fields = {{9.99, {Quantity::curvature}}};
    return s;
}

} // namespace

TEST_CASE("the oracle reproduces the 20,000 published values bit for bit") {
    const Columns published = read_csv(data("traces_flat_circular.csv"));
    const std::vector<double> flat(150 * 150, 0.5), pressure = read_map("pressure_circular_150.npy");
    int compared = 0, different = 0;
    oracle::study(flat, pressure, 150, 150, 1.54, 1.0, 0.01, 1000, [&](int n, const oracle::Frame& f) {
        for (int p = 0; p < 5; ++p)
            for (auto [name, map] : {std::pair{"sa1", &f.sa1}, {"sa2", &f.sa2}, {"fa1", &f.fa1}, {"fa2", &f.fa2}}) {
                ++compared;
                different += (*map)[size_t(probes[p].y) * 150 + probes[p].x] !=
                             published.at(name + std::string("_probe") + std::to_string(p))[n];
            }
        if (n == 999) CHECK(difference(f.curvature, read_map("curvature_last_flat_circular.npy")) < 1e-15);
    });
    CHECK(compared == 20000);
    CHECK(different == 0);
}

TEST_CASE("the published method in double reproduces every reference column to 1e-12 of its largest magnitude") {
    for (const char* surface : {"flat", "wave", "spiral"})
        for (const char* load : {"circular", "point", "linear"}) {
            CAPTURE(surface);
            CAPTURE(load);
            RunOptions f64;
            f64.precision = Precision::f64;
            const Result r = run(published_scene(surface, load), Device::cpu(), f64);
            const Columns reference = read_csv(data(std::string("traces_") + surface + "_" + load + ".csv"));
            REQUIRE(r.time.size() == 1000);
            int columns = 0;
            const auto compare = [&](const std::string& name, const std::vector<double>& computed) {
                std::vector<double> rows;
                for (double step : reference.at("step")) rows.push_back(computed[size_t(step)]);
                CAPTURE(name);
                CHECK(difference(rows, reference.at(name)) < 1e-12);
                ++columns;
            };
            compare("time", r.time);
            compare("strain_mean", r.trace(Quantity::strain).mean);
            compare("strain_max", r.trace(Quantity::strain).max);
            for (Quantity q : {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2}) {
                compare(name(q) + std::string("_mean"), r.trace(q).mean);
                for (int p = 0; p < 5; ++p)
                    compare(name(q) + std::string("_probe") + std::to_string(p), r.trace(q).probes[p]);
            }
            CHECK(columns == int(reference.size()) - 1); // all but "step"
            if (std::string(load) == "circular")
                CHECK(difference(r.fields.at(0).values,
                                 read_map(std::string("curvature_last_") + surface + "_circular.npy")) < 1e-12);
        }
}

TEST_CASE("generated surfaces agree with the study's float32 ones to 1e-6") {
    for (auto [kind, file] :
         {std::pair{Surface::Kind::wave, "surface_wave_150.npy"}, {Surface::Kind::spiral, "surface_spiral_150.npy"}}) {
        Scene s;
        s.surface.kind = kind;
        CHECK(difference(maps(s).surface, read_map(file)) < 1e-6);
    }
    const std::vector<double> flat = maps(Scene{}).surface;
    for (double height : flat) REQUIRE(height == 0.5);
}

TEST_CASE("surfaces have the same bits for every number of threads") {
    for (Surface::Kind kind : {Surface::Kind::wave, Surface::Kind::spiral})
        for (double noise : {0.0, 1.5}) {
            Scene s;
            s.grid = {333, 401, {}}; // enough cells for four threads
            s.surface.kind = kind;
            s.surface.noise = noise;
            const SkinDescription d = scene::validate_skin(s, {Quantity::sa1});
            const std::vector<double> alone = scene::surface_heights(d, 1);
            for (int threads : {2, 3, 4}) CHECK(scene::surface_heights(d, threads).values() == alone);
        }
}

TEST_CASE("generated loads agree with the study's to rounding") {
    for (auto [kind, file] : {std::pair{Load::Kind::circular, "pressure_circular_150.npy"},
                              {Load::Kind::point, "pressure_point_150.npy"},
                              {Load::Kind::linear, "pressure_linear_150.npy"}}) {
        Scene s;
        s.load.kind = kind;
        CHECK(difference(maps(s).pressure, read_map(file)) < 1e-14);
    }
}

TEST_CASE("a point load keeps its whole force, reflected at the edges") {
    Scene s;
    s.grid = {40, 23, {}};
    s.load.kind = Load::Kind::point;
    s.load.center = Cell{1, 20};
    s.load.radius = 30; // wider than the grid
    s.load.intensity = 3;
    const std::vector<double> p = maps(s).pressure;
    CHECK(std::accumulate(p.begin(), p.end(), 0.0) == relative(3, 1e-13));
}
