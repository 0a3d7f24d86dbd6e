// SPDX-License-Identifier: MIT
// labels: device threads command
// Receptor populations: drawn, read, and answering what the field has in their cells.
#include "tests/command.hpp"
#include "tests/oracle/scene_files.hpp"
#include "tests/support.hpp"

#include <filesystem>
#include <fstream>
#include <random>

using namespace test;

namespace {

std::vector<Site> scattered(int width, int height, int count) {
    std::mt19937 random(9);
    std::vector<Site> sites = {{Quantity::sa1, {0, 0}}, {Quantity::fa2, {width - 1, height - 1}}}; // corners
    while (int(sites.size()) < count)
        sites.push_back({Quantity(1 + random() % 4), {int(random() % width), int(random() % height)}});
    return sites;
}

} // namespace

TEST_CASE("a site has the bits of the field at its cell, in every model that can serve it") {
    const Validated vulkan;
    const std::vector<Quantity> classes = {Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
    const auto path = temporary("frames_of_sites.npy");
    std::vector<std::vector<double>> frames;
    for (int k = 0; k < 5; ++k) {
        frames.emplace_back();
        for (int i = 0; i < 37 * 21; ++i) frames.back().push_back(std::sin(0.3 * i + k * k));
    }
    oracle::write_frames(path, {37, 21, {}}, frames);
    enum class Case { uniform, materials, parabolas }; // parabolas: through frames, on elements and a spring in series
    for (Case of : {Case::uniform, Case::materials, Case::parabolas})
        for (auto [stencil, edges] : {std::pair{Stencil::five_point, Edges::mirror},
                                      {Stencil::five_point, Edges::periodic},
                                      {Stencil::fourth_order, Edges::mirror},
                                      {published_stencil, published_edges}}) {
            CAPTURE(int(of));
            Scene s = small_scene(37, 21);
            s.stencil = stencil;
            s.edges = edges;
            s.output.probes.clear();
            if (of == Case::materials)
                for (int i = 0; i < 37 * 21; ++i) s.material.modulus_map.edit().push_back(1 + 0.1 * (i % 11));
            if (of == Case::parabolas) {
                s.load = {
                    .kind = Load::Kind::sequence, .path = path.string(), .interval = 0.1, .hold = Hold::parabolic};
                s.material = {};
                s.material.elements = {{1, 0.2}, {2, 0.05}, {3, 1}};
                s.material.spring = 4;
            }
            Scene field = s;
            field.output.traces.clear();
            for (int n = 1; n < 8; ++n) field.output.fields.push_back({n * 0.05, classes});
            s.sites = scattered(37, 21, 40);
            s.output.traces.clear();
            const auto check = [&](const Result& sites, const Result& fields) {
                REQUIRE(sites.responses.size() == 8 * 40);
                for (size_t n = 1; n < 8; ++n)
                    for (size_t i = 0; i < 40; ++i) {
                        const Site& site = s.sites[i];
                        const Field& f = fields.fields[(n - 1) * 4 + size_t(site.type) - 1];
                        REQUIRE(sites.responses[n * 40 + i] == f.values[site.cell.y * 37 + site.cell.x]);
                    }
            };
            RunOptions f64, f32;
            f64.precision = Precision::f64;
            f32.precision = Precision::f32;
            s.model = Model::sites;
            check(run(s, Device::cpu(), f64), run(field, Device::cpu(), f64));
            s.model.reset();
            check(run(s, Device::cpu(), f32), run(field, Device::cpu(), f32));
            check(run(s, vulkan.device(), f32), run(field, vulkan.device(), f32));
        }
    std::filesystem::remove(path);
}

TEST_CASE("a population has the densities asked for, anywhere alike, and is the same for the same seed") {
    Grid g{400, 200, 50e-6}; // 2 cm2
    const std::vector<Site> sites = population(g);
    std::map<Quantity, int> count;
    double x = 0, y = 0;
    for (const Site& s : sites) {
        ++count[s.type];
        x += s.cell.x;
        y += s.cell.y;
        REQUIRE((s.cell.x >= 0 && s.cell.x < 400 && s.cell.y >= 0 && s.cell.y < 200));
    }
    CHECK(count[Quantity::sa1] == 140);
    CHECK(count[Quantity::sa2] == 20);
    CHECK(count[Quantity::fa1] == 280);
    CHECK(count[Quantity::fa2] == 50);
    CHECK(x / 490 == relative(199.5, 0.1)); // 5 standard deviations are 13 %
    CHECK(y / 490 == relative(99.5, 0.1));
    // splitmix64 from seed 1 begins with 0x910a2dec89025cc1, 0xbeeb8da1658eec67
    CHECK(sites[0].cell.x == int(0x910a2dec89025cc1 / 18446744073709551616.0 * 400));
    CHECK(sites[0].cell.y == int(0xbeeb8da1658eec67 / 18446744073709551616.0 * 200));
    const std::vector<Site> other = population(g, {}, 2), few = population(g, {1, 0, 0, 0});
    CHECK(other[0].cell.x != sites[0].cell.x);
    CHECK(few.size() == 2);
    refuses([&] { population(g, {-1}); }, "sites.density.sa1 = -1");
    refuses([] { population({-5, -5, 1e-3}); }, "grid.width = -5");
    g.spacing.reset();
    refuses([&] { population(g); }, "grid.spacing");
}

TEST_CASE("receptors alone are served by sites, however many they are, whether the strain is a product or not") {
    Scene s = small_scene(30, 30);
    s.output.traces.clear();
    for (int i = 0; i < 900; ++i) s.material.modulus_map.edit().push_back(1 + i % 3);
    s.load.kind = Load::Kind::map;
    s.load.map = std::vector<double>(900, 1.0);
    for (int receptors : {20, 2000}) { // that read about 100 cells, or all of them
        s.sites = scattered(30, 30, receptors);
        for (double minus : {-1.0, 0.0}) {
            s.receptors.fa2_gains = {1, minus};
            CHECK(int(run(s, Device::cpu()).model) == int(Model::sites));
        }
    }
    s.output.traces = {Quantity::sa1};
    s.model = Model::sites;
    refuses([&] { run(s, Device::cpu()); }, "traces or fields");
    s.sites[3].cell.x = 30;
    refuses([&] { run(s, Device::cpu()); }, "sites[3] = [30, ");
}

TEST_CASE("the receptors of a run are a list of receptors, whatever program has written it again") {
    const Folder folder;
    const std::string scene =
        folder.write("scene.toml",
                     "preset = \"fingertip\"\n[grid]\nwidth = 40\nheight = 30\nspacing = \"0.25 mm\"\n[time]\nduration "
                     "= 0.02\n[sites]\ndensity = {}\n[output]\ntraces = []\n");
    const Outcome o = command(folder, "run " + scene + " --out " + (folder / "out").string());
    REQUIRE_MESSAGE(o.status == 0, o.err);
    const Scene s = Scene::from_file(scene);
    const std::string list = slurp(folder / "out/receptors.csv");
    const auto same = [&](const std::string& text, const Grid& grid) {
        const std::vector<Site> read = dermis::scene::read_sites(folder.write("list.csv", text), grid);
        REQUIRE(read.size() == s.sites.size());
        for (size_t i = 0; i < read.size(); ++i) {
            CHECK(int(read[i].type) == int(s.sites[i].type));
            CHECK(read[i].cell.x == s.sites[i].cell.x);
            CHECK(read[i].cell.y == s.sites[i].cell.y);
        }
    };
    same(list, s.grid);
    same(list + "\n\r\n", s.grid);
    same("\xef\xbb\xbf# from a spreadsheet\r\n" + list, s.grid);
    same(list, {.width = 40, .height = 30, .spacing = {}}); // its cells
}

TEST_CASE("a list of receptors is read from a file, and a bad one refused with its line") {
    const auto folder = temporary("sites");
    std::filesystem::create_directories(folder);
    const auto scene = [&](const std::string& list, const std::string& more = "") {
        std::ofstream(folder / "list.csv") << list;
        std::ofstream(folder / "scene.toml")
            << "[grid]\nwidth = 20\nheight = 20\n[sites]\npath = \"list.csv\"\n" + more + "[output]\ntraces = []\n";
        return (folder / "scene.toml").string();
    };
    const Scene s = Scene::from_file(scene("type,x,y\nsa1,3,4\r\nfa2,19,0\n"));
    const Scene places = Scene::from_file(scene("type,x_m,y_m\nsa1,0.00035,4.5e-4\nfa2,1.9e-3,0\n"),
                                          {"preset=\"fingertip\"", "grid.spacing=1e-4"});
    REQUIRE(places.sites.size() == 2);
    for (size_t i = 0; i < 2; ++i) {
        CHECK(places.sites[i].type == s.sites[i].type);
        CHECK(places.sites[i].cell.x == s.sites[i].cell.x);
        CHECK(places.sites[i].cell.y == s.sites[i].cell.y);
    }
    REQUIRE(s.sites.size() == 2);
    CHECK(int(s.sites[1].type) == int(Quantity::fa2));
    CHECK(s.sites[1].cell.x == 19);
    for (auto [list, says] :
         {std::pair{"sa1,3,4\n",
                    "list.csv\":1: line = \"sa1,3,4\"; allowed: names of columns, each once: type,x,y, or with"},
          {"type,x,type,y\nsa1,1,fa1,2\n", ":1: line = \"type,x,type,y\"; allowed: names of columns, each once"},
          {"type,x,y\nsa1,3\n", "list.csv\":2: line = \"sa1,3\"; allowed: 3 columns with commas"},
          {"type,x,y\nsa1,1,1\nsa3,3,4\n", ":3: type = \"sa3\"; allowed: sa1, sa2, fa1, fa2; the line: \"sa3,3,4\""},
          {"type,x,y\nsa1,1,1,1\n", ":2: line = \"sa1,1,1,1\"; allowed: 3 columns"},
          {"type,x,y\nsa1,1.5,1\n", ":2: x = 1.5; allowed: a cell of the grid, a whole number in 0..19"},
          {"type,x,y\nsa1,1,1e99\n", ":2: y = 1e99; allowed: a cell"},
          {"type,x,y\nsa1,1,\n", ":2: y = \"\"; allowed: a finite number"},
          {"type,x,y\n", "no site"},
          {"", "is empty; allowed: names of columns"},
          {"type,x,y,depth\nsa1,1,1,1\n", ":1: line = \"type,x,y,depth\""},
          {"type,x_m,y_m\nsa1,1e-3,1e-3\n", ":1: line = \"type,x_m,y_m\""}, // without a spacing
          {"type,x,y\nsa1,1,1\nsa1,20,1\n",
           "list.csv\":3: x = 20; allowed: a cell of the grid, a whole number in 0..19"},
          {"type,x,y\nsa1,1,-1\n", "list.csv\":2: y = -1; allowed: a cell of the grid"}})
        refuses([&] { Scene::from_file(scene(list)); }, says);
    refuses([&] { Scene::from_file(scene("type,x,y\nsa1,1,1\n", "seed = 3\n")); }, "sites.path");
    std::filesystem::remove_all(folder);
}
