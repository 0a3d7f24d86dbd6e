// SPDX-License-Identifier: MIT
// labels: device
// What is drawn of afferents: the endings around the sites, and the factors of their input.
#include "host/core/base/refusal.hpp"
#include "host/core/description/description.hpp"
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/output.hpp"
#include "host/lab/scenes/scene.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <sstream>

using namespace test;

namespace {

Afferents around(Quantity type, int endings, double radius, int seed = 1) {
    return {.type = type, .model = {}, .cells = {}, .endings = endings, .radius = radius, .seed = seed};
}

// The endings that are drawn around sites of SA1.
std::vector<Cell> drawn(const Grid& grid, const std::vector<Cell>& middles, const Afferents& a) {
    SkinDescription d;
    d.grid = grid;
    for (const Cell c : middles) d.sites.push_back({a.type, c});
    return scene::validated_afferents(d, {a})[0].cells;
}

double distance(Cell a, Cell b) { return std::hypot(a.x - b.x, a.y - b.y); }

std::vector<double> factors(size_t count, double spread, int seed, Quantity type = Quantity::fa1) {
    Afferents a{.type = type, .model = afferent_model(type), .cells = {}, .seed = seed};
    a.cells.resize(count);
    a.model->spread = spread;
    return scene::drawn_factors(a);
}

double normal_share(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); } // of numbers below x

// A cell that is strained by a sine, of which fibres of a class answer.
Scene vibrating_cell(Quantity type, double strain, size_t fibres, double spread) {
    Scene s;
    s.grid = {.width = 1, .height = 1, .spacing = 1e-3};
    s.surface = {.kind = Surface::Kind::flat, .relief = 1e-5};
    s.material.modulus = 1;
    s.material.viscosity = 0;
    s.material.thickness = 1e-3;
    s.material.curvature_length = 0;
    s.load.radius = 1;
    s.load.intensity = strain;
    s.load.envelope = {.kind = Envelope::Kind::sine, .frequency = type == Quantity::fa2 ? 200.0 : 40.0, .mean = 0};
    s.time = {.step = 1e-3, .duration = 0.15};
    s.output.traces = {};
    s.output.probes = {{0, 0}};
    s.output.traces = {Quantity::strain};
    Afferents a{.type = type, .model = afferent_model(type), .cells = {}};
    a.cells.resize(fibres);
    a.model->sensitivity = 1;
    a.model->spread = spread;
    s.afferents = {a};
    return s;
}

double share_that_fires(const Scene& s) {
    std::vector<bool> fires(s.afferents[0].cells.size());
    for (const FiredSpike& spike : run(s).spikes) fires[size_t(spike.afferent)] = true;
    return double(std::ranges::count(fires, true)) / double(fires.size());
}

const std::string drawn_scene = "preset = \"fingertip\"\n[sites]\nseed = 2\ndensity = { sa1 = 500 }\n[[afferents]]\n";

Scene pressed_fields() {
    return Scene::from_string(
        drawn_scene + "endings = 8\nradius = \"1 mm\"\n[grid]\nwidth = 40\nheight = 30\nspacing = \"0.1 mm\"\n"
                      "[load]\nenvelope = \"ramp\"\nrise = \"20 ms\"\nintensity = \"100 kPa\"\nradius = 6\n"
                      "[receptors]\ndepth = \"fingertip\"\n[time]\nstep = 1e-3\nduration = 0.1\n[output]\ntraces = []");
}

} // namespace

TEST_CASE("as many of 500 fibres fire as have a factor above the amplitude's: the normal share of its logarithm") {
    for (const Quantity type : {Quantity::sa1, Quantity::fa1, Quantity::fa2}) {
        const double spread = afferent_model(type).spread;
        double silent = 1e-6, fires = 10; // strains of a fibre whose factor is 1
        while (fires > 1.001 * silent) {
            const double middle = std::sqrt(silent * fires);
            (share_that_fires(vibrating_cell(type, middle, 1, 0)) > 0 ? fires : silent) = middle;
        }
        double away = 0, all = 0;
        for (const double x : {-2.0, -1.2, -0.6, 0.0, 0.6, 1.2, 2.0}) {
            const double share = share_that_fires(vibrating_cell(type, fires * std::exp(spread * x), 500, spread)),
                         expected = normal_share(x);
            CHECK(std::abs(share - expected) < 0.06); // 2.7 standard deviations
            away += (share - expected) * (share - expected);
            all += (expected - 0.5) * (expected - 0.5);
        }
        CHECK(1 - away / all > 0.99);
    }
}

TEST_CASE(
    "afferents that are sensitive to change fire from a smaller vibration on, and in a hold as fast as the median's") {
    const auto spikes = [](double sensitivity, Envelope envelope, double strain) {
        Scene s = vibrating_cell(Quantity::sa1, strain, 1, 0);
        s.load.envelope = std::move(envelope);
        s.time.duration = 1;
        s.afferents[0].model->sensitivity = sensitivity;
        std::vector<FiredSpike> late = run(s).spikes; // once y is at rest
        std::erase_if(late, [](const FiredSpike& spike) { return spike.time < 0.2; });
        return late.size();
    };
    const double sensitive = scene::threshold_sensitivity(Quantity::sa1);
    const Envelope hold{.kind = Envelope::Kind::ramp, .rise = 0.01},
        sine = vibrating_cell(Quantity::sa1, 1, 1, 0).load.envelope;
    for (const double strain : {0.5, 0.6, 1.0, 3.0})
        CHECK(std::abs(int(spikes(sensitive, hold, strain)) - int(spikes(1, hold, strain))) <= 1);
    CHECK(spikes(1, hold, 0.6) > 10);
    CHECK(spikes(1, sine, 0.02) == 0);
    CHECK(spikes(sensitive, sine, 0.02) > 10);
}

TEST_CASE("the logarithms of factors are normal, with the spread as their standard deviation") {
    const double spread = 1.275, n = 20000;
    std::vector<double> x = factors(size_t(n), spread, 1);
    for (double& s : x) s = std::log(s) / spread;
    std::ranges::sort(x);
    double away = 0, mean = 0, square = 0;
    for (size_t i = 0; i < x.size(); ++i) {
        away = std::max(away, std::abs(normal_share(x[i]) - (double(i) + 0.5) / n));
        mean += x[i] / n;
        square += x[i] * x[i] / n;
    }
    CHECK(away * std::sqrt(n) < 1.63); // Kolmogorov's distance, one draw in a hundred is beyond
    CHECK(std::abs(mean) < 3 / std::sqrt(n));
    CHECK(square == doctest::Approx(1).epsilon(3 * std::sqrt(2 / n)));
}

TEST_CASE("a seed draws the same factors and endings, another seed and another class others") {
    const std::vector<double> one = factors(100, 0.5, 1);
    CHECK(factors(100, 0.5, 1) == one);
    CHECK(factors(100, 0.5, 2) != one);
    CHECK(factors(100, 0.5, 1, Quantity::sa1) != one);
    const std::vector<double> fewer = factors(40, 0.5, 1);
    CHECK(std::equal(fewer.begin(), fewer.end(), one.begin())); // whatever is drawn for others
    CHECK(factors(100, 0, 1) == std::vector<double>(100, 1));
    for (size_t i = 0; i < one.size(); ++i) // the same normal numbers
        CHECK(std::log(factors(100, 1, 1)[i]) == doctest::Approx(2 * std::log(one[i])));
    const Grid grid{.width = 300, .height = 300, .spacing = 1e-4};
    const auto key = [](const std::vector<Cell>& cells) {
        std::vector<int> all;
        for (const Cell c : cells) all.push_back(300 * c.y + c.x);
        return all;
    };
    const std::vector<Cell> middles(5, {150, 150});
    const auto endings = [&](int seed, Quantity type = Quantity::sa1) {
        return key(drawn(grid, middles, around(type, 4, 5e-3, seed)));
    };
    CHECK(endings(1) == endings(1));
    CHECK(endings(1) != endings(2));
    CHECK(endings(1) != endings(1, Quantity::fa1));
    const std::vector<int> all = endings(1);
    CHECK(!std::equal(all.begin(), all.begin() + 4, all.begin() + 4)); // each afferent has others
}

TEST_CASE("factors have the same bits on every machine") {
    const std::vector<double> s = factors(3, 1, 7, Quantity::sa1);
    CHECK(s[0] == 1.1173513872943808);
    CHECK(s[1] == 0.3514753300853395);
    CHECK(s[2] == 2.552133275541022);
}

TEST_CASE("endings lie evenly in the circle around their site: two thirds of the radius away in the mean") {
    const Grid grid{.width = 1000, .height = 900, .spacing = 1e-5};
    const double radius = 200, n = 300 * 8;                                  // cells; endings
    for (const Cell middle : {Cell{500, 450}, Cell{0, 0}, Cell{999, 450}}) { // at a border a half or a quarter of it
        double mean = 0, square = 0, greatest = 0;
        for (const Cell c : drawn(grid, std::vector<Cell>(300, middle), around(Quantity::sa1, 8, 2e-3))) {
            REQUIRE((c.x >= 0 && c.x < grid.width && c.y >= 0 && c.y < grid.height));
            const double r = distance(c, middle);
            mean += r / n;
            square += r * r / n;
            greatest = std::max(greatest, r);
        }
        CHECK(greatest <= radius + std::sqrt(0.5)); // the point lies within, and the cell's middle half a diagonal off
        CHECK(greatest > 0.99 * radius);
        CHECK(mean == doctest::Approx(2 * radius / 3).epsilon(3 * std::sqrt(1.0 / 18) / std::sqrt(n) * 1.5));
        CHECK(square == doctest::Approx(radius * radius / 2).epsilon(3 * std::sqrt(1.0 / 12) / std::sqrt(n) * 2));
    }
    const std::vector<Cell> line = drawn({.width = 1, .height = 50}, {{0, 20}}, around(Quantity::sa1, 64, 1e9));
    CHECK(line.size() == 64); // a radius far beyond the grid
}

TEST_CASE("a density counts afferents: each site is one, with all its endings, and the files say where it is") {
    const Scene s = pressed_fields();
    const size_t sites = size_t(std::ranges::count(s.sites, Quantity::sa1, &Site::type));
    CHECK(sites == 60);              // 500 per cm2 on 0.12 cm2
    CHECK(s.afferents[0].seed == 2); // that of the sites
    const Result r = run(s);
    const Folder folder;
    output::write_result(output::Folder(folder / "out"), s, r, output::origin_of("", {}, {}, {}));
    std::istringstream list(slurp(folder / "out" / "afferents.csv"));
    std::string line;
    std::getline(list, line);
    size_t number = 0;
    for (; std::getline(list, line); ++number) {
        const Cell c = s.sites[number].cell;
        CHECK(
            line.starts_with(std::to_string(number) + ",sa1," + std::to_string(c.x) + "," + std::to_string(c.y) + ","));
    }
    CHECK(number == sites);
    REQUIRE(!r.spikes.empty());
    CHECK(std::ranges::max(r.spikes, {}, &FiredSpike::afferent).afferent < int(sites));
    // and the text of the scene draws them again
    const Result again = run(Scene::from_string(scene::written(s).text));
    REQUIRE(again.spikes.size() == r.spikes.size());
    for (size_t i = 0; i < r.spikes.size(); ++i) {
        CHECK(again.spikes[i].time == r.spikes[i].time);
        CHECK(again.spikes[i].afferent == r.spikes[i].afferent);
    }
}

TEST_CASE("a skin fires fields of endings around its sites as afferents with these cells, and a sensitivity of 4 as "
          "a rate four times as great, to the last bit") {
    const Validated vulkan;
    for (const Device& device : {Device::cpu(1), Device::cpu(2), vulkan.device()}) {
        Scene s = pressed_fields();
        SkinOptions fields{.afferents = s.afferents}, cells = fields;
        fields.afferents[0].model = cells.afferents[0].model = afferent_model(Quantity::sa1);
        fields.afferents[0].model->sensitivity = 4;
        fields.afferents[0].model->spread = 0;
        cells.afferents = scene::validated_afferents(s, fields.afferents);
        CHECK(cells.afferents[0].cells.size() == 480);
        CHECK(!cells.afferents[0].radius);
        cells.afferents[0].model->sensitivity = 1;
        cells.afferents[0].model->rate *= 4;
        Skin one(device, s, fields), other(device, s, cells);
        std::vector<float> pressure(size_t(s.grid.width * s.grid.height));
        size_t fired = 0;
        for (int n = 1; n <= 60; ++n) {
            for (size_t i = 0; i < pressure.size(); ++i) pressure[i] = float(n) * float(i % 7) * 2e3f;
            one.press(pressure, 1e-3);
            other.press(pressure, 1e-3);
            const Skin::Spikes a = one.spikes(), b = other.spikes();
            REQUIRE(a.size == b.size);
            CHECK((a.size == 0 || std::memcmp(a.begin(), b.begin(), a.size * sizeof(Spike)) == 0));
            fired += a.size;
        }
        CHECK(fired > 30);
    }
}

TEST_CASE(
    "without gains afferents are as sensitive as those of the thresholds, and drawn; with gains as given, alike") {
    const auto model_of = [](const std::string& keys, const std::string& type = "sa1") {
        const Scene s = Scene::from_string("[afferents]\ntype = \"" + type + "\"\ncells = [[1, 1]]\n" + keys);
        return *scene::validated_afferents(s, s.afferents)[0].model;
    };
    const AfferentModel fitted = afferent_model(Quantity::sa1);
    CHECK(fitted.sensitivity == scene::threshold_sensitivity(Quantity::sa1));
    for (const char* keys : {"", "reset = 0.1", "sensitivity = \"threshold\""}) {
        CHECK(model_of(keys).sensitivity == fitted.sensitivity);
        CHECK(model_of(keys).spread == fitted.spread);
    }
    const std::string gains = "gains = [[2, 1]]\n";
    CHECK(model_of(gains).sensitivity == 1);
    CHECK(model_of(gains).spread == 0);
    CHECK(model_of(gains + "sensitivity = \"threshold\"\nspread = 0.3").sensitivity == fitted.sensitivity);
    CHECK(model_of(gains + "sensitivity = \"threshold\"\nspread = 0.3").spread == 0.3);
    CHECK(model_of("sensitivity = \"median\"").sensitivity == 1);
    CHECK(model_of("sensitivity = \"median\"").spread == fitted.spread);
    CHECK(model_of("sensitivity = 2.5\nspread = 0", "fa2").sensitivity == 2.5);
    CHECK(model_of("sensitivity = 2.5\nspread = 0", "fa2").spread == 0);
}

TEST_CASE("endings join cells that are listed, or points around their site, not sites that are drawn anywhere") {
    CHECK(Scene::from_string(drawn_scene + "endings = 1").afferents[0].endings == 1);
    CHECK(Scene::from_string(drawn_scene + "endings = 2\ncells = [[3, 4], [5, 6]]").afferents[0].endings == 2);
    const Folder folder;
    std::ofstream(folder / "sites.csv") << "type,x,y\nsa1,3,4\nsa1,5,6\n";
    std::ofstream(folder / "scene.toml") << "preset = \"fingertip\"\nsites.path = \"sites.csv\"\n[afferents]\n"
                                            "endings = 2\n";
    const std::vector<Cell> path = Scene::from_file(folder / "scene.toml").afferents[0].cells;
    REQUIRE(path.size() == 2);
    CHECK(path[1].y == 6);
    std::ofstream(folder / "scene.toml", std::ios::app) << "radius = 1e-3\n";
    const std::string listed = refusal(Error::Code::bad_input, [&] { Scene::from_file(folder / "scene.toml"); });
    CHECK(listed.find("afferents.radius = ") != listed.npos);
    CHECK(listed.find("none with sites.path, a list of endings") != listed.npos);
    SkinDescription d = pressed_fields(); // at the surface a skin holds the cells of its sites alone
    d.receptors.depth = {};
    refuses([&] { Skin(Device::cpu(1), d, {.afferents = {around(Quantity::sa1, 4, 1e-3)}}); },
            "afferents[0].radius = 0.001; allowed: none in a skin with sites but without receptors.depth");
}
