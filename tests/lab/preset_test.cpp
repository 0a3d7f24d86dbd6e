// SPDX-License-Identifier: MIT
// The fingertip of the preset, and what a scene in metres has to say of its material.
#include "dermis/contact.hpp"
#include "host/core/description/names.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

#include <regex>
#include <sstream>

using namespace test;

namespace {

const Folder& files() {
    static const Folder folder;
    return folder;
}

Scene scene_of(const std::string& text) { return Scene::from_file(files().write("preset.toml", text)); }
std::string why_not(const std::string& text) {
    return refusal(Error::Code::bad_input, [&] { scene_of(text); });
}
bool holds(const std::string& text, const std::string& part) { return text.find(part) != text.npos; }

const std::string tip_preset = "preset = \"fingertip\"\n";

struct Row {
    std::string value, unit, source;
};

// The rows of the table in host/core/description/fingertip.md by their keys.
std::map<std::string, Row> page_rows() {
    std::map<std::string, Row> rows;
    const std::string text = slurp(data("../../host/core/description/fingertip.md"));
    const std::regex row("\\| `([a-z0-9_.]+)` \\| ([^|]*) \\| ([^|]*)\\| ([^|\n]*) \\|\n");
    for (std::sregex_iterator i(text.begin(), text.end(), row), end; i != end; ++i)
        rows[(*i)[1]] = {(*i)[2], (*i)[3], (*i)[4]};
    return rows;
}

std::vector<double> numbers_in(const std::string& text) {
    std::vector<double> all;
    std::istringstream in(std::regex_replace(text, std::regex(","), " "));
    for (double v; in >> v;) all.push_back(v);
    return all;
}

// A small skin in metres, without a material.
Scene in_metres() {
    Scene s = small_scene(20, 12);
    s.grid.spacing = 5e-5;
    s.surface.relief = 5e-5;
    s.material.thickness = 1e-3;
    s.material.curvature_length = 1e-5;
    return s;
}

} // namespace

TEST_CASE("the fingertip has the numbers of its page, each with a source or called chosen") {
    const SkinDescription s = fingertip();
    const Relaxation r = relaxation_of(s.material.elements);
    const std::vector<KelvinVoigt> chain =
        chain_of({.moduli = {5e4, 5e4, 5e4}, .times = {0.004, 0.07, 1.4}, .equilibrium = 5e4});
    CHECK(std::ranges::equal(chain, s.material.elements, [](const KelvinVoigt& a, const KelvinVoigt& b) {
        return a.modulus == b.modulus && a.viscosity == b.viscosity;
    }));
    const Density density;
    const Depths depth = fingertip_depths();
    const std::map<std::string, std::vector<double>> given = {
        {"grid.width", {double(s.grid.width)}},
        {"grid.height", {double(s.grid.height)}},
        {"grid.spacing", {*s.grid.spacing}},
        {"surface.ridge_period", {*s.surface.ridge_period}},
        {"surface.relief", {*s.surface.relief}},
        {"surface.noise", {*s.surface.noise}},
        {"material.relaxation.times", r.times},
        {"material.relaxation.moduli", r.moduli},
        {"material.relaxation.equilibrium", {r.equilibrium}},
        {"material.thickness", {*s.material.thickness}},
        {"material.curvature_length", {*s.material.curvature_length}},
        {"sites.density.sa1", {density.sa1}},
        {"sites.density.sa2", {density.sa2}},
        {"sites.density.fa1", {density.fa1}},
        {"sites.density.fa2", {density.fa2}},
        {"receptors.depth.sa1", {*depth.sa1}},
        {"receptors.depth.sa2", {*depth.sa2}},
        {"receptors.depth.fa1", {*depth.fa1}},
        {"receptors.depth.fa2", {*depth.fa2}}};
    std::map<std::string, Row> rows = page_rows();
    CHECK(rows.at("surface.kind").value == std::string("`\"") + scene::text_of(s.surface.kind) + "\"`");
    rows.erase("surface.kind");
    CHECK(rows.size() == given.size());
    // What the page says of all densities is their sum.
    const int others = int(density.sa1 + density.fa1 + density.fa2), all = others + int(density.sa2);
    const std::string& of_sa2 = rows.at("sites.density.sa2").source;
    CHECK(holds(of_sa2, "leave " + std::to_string(241 - others) + " of the 241 "));
    CHECK(holds(of_sa2, "preset has " + std::to_string(all) + ";"));
    for (const auto& [key, values] : given) {
        CAPTURE(key);
        REQUIRE(rows.count(key));
        const std::vector<double> printed = numbers_in(rows.at(key).value);
        REQUIRE(printed.size() == values.size());
        for (size_t i = 0; i < values.size(); ++i) CHECK(values[i] == relative(printed[i], 1e-9));
        const std::string& source = rows.at(key).source;
        CHECK((source.rfind("chosen", 0) == 0 || source == "as SA1" ||
               std::regex_search(source, std::regex("[A-Z][a-z]+.*(19|20)[0-9][0-9]"))));
    }
}

TEST_CASE("the word fingertip gives the depths at which the afferents were fitted, in every form of a scene") {
    const Depths depths = fingertip_depths();
    const std::string fit = slurp(data("../../bench/evidence/fit_afferents.py"));
    for (const auto& [model, depth] : {std::pair{"SA1", depths.sa1}, {"RA", depths.fa1}, {"PC", depths.fa2}}) {
        std::smatch found;
        REQUIRE(
            std::regex_search(fit, found, std::regex(std::string("Model\\(\"") + model + "\",.* depth=([0-9.e-]+),")));
        CHECK(std::stod(found[1]) == *depth);
    }
    const std::string word = tip_preset + "[receptors]\ndepth = \"fingertip\"\n";
    const Scene s = scene_of(word), set = Scene::from_string(tip_preset, {"receptors.depth=fingertip"});
    for (auto depth : {&Depths::sa1, &Depths::sa2, &Depths::fa1, &Depths::fa2})
        for (const Receptors& r : {s.receptors, set.receptors, Scene::from_string(scene::written(s).text).receptors})
            CHECK(*(r.depth.*depth) == *(depths.*depth));
    CHECK(s.receptors.kernel.fa2 == DepthKernel::stress);
    CHECK_FALSE(scene_of(tip_preset).receptors.depth.sa1.has_value());
    CHECK(holds(why_not(tip_preset + "[receptors]\ndepth = \"thumb\"\n"),
                "receptors.depth = 'thumb'; allowed: \"fingertip\", or a table of depths"));
    CHECK(holds(why_not("[receptors]\ndepth = 1\n"), "receptors.depth = 1; allowed: "));
}

// The input of the fits: the stress on the axis of a flat cylinder over the modulus, per displacement.
TEST_CASE("below the probe of the fits receptors at these depths feel what the fits say, by the default kernel") {
    const double radius = 5e-4, displacement = 1e-4, poisson = 0.4;
    Scene s{fingertip()};
    s.grid = {121, 121, 2.5e-5};
    s.surface = {.kind = Surface::Kind::flat, .relief = 1e-5};
    s.material.elements = {{.modulus = 5e4, .viscosity = 0}};
    s.load.kind = Load::Kind::punch;
    s.load.control = Control::depth;
    s.load.radius = 20;
    s.load.intensity = displacement;
    s.time = {.step = 1e-3, .duration = 2e-3};
    s.output.traces = {};
    const Depths depths = fingertip_depths();
    for (const double depth : {*depths.sa1, *depths.sa2, *depths.fa1, *depths.fa2}) {
        s.receptors.depth = {.sa1 = depth};
        s.sites = {{Quantity::sa1, {60, 60}}};
        const double square = depth * depth / (radius * radius),
                     expected = displacement / (3.14159265358979 * radius * (1 - poisson * poisson)) *
                                (1 + 3 * square) / ((1 + square) * (1 + square));
        CHECK(run(s).responses.back() == relative(expected, 0.01));
        CHECK(contact::strain_below_punch(displacement, depth, radius) == relative(expected, 1e-14));
    }
}

TEST_CASE("a preset is the starting value of every key, and a key of one's own takes its place") {
    const Scene tip{fingertip()}, plain = scene_of(tip_preset);
    const Result a = run(tip), b = run(plain);
    for (size_t t = 0; t < a.traces.size(); ++t) CHECK(a.traces[t].mean == b.traces[t].mean);
    CHECK(a.cells_per_ridge == relative(10, 1e-12));
    CHECK(a.greatest_gain < 1);

    Scene s = scene_of(tip_preset + "[grid]\nwidth = 400\n[material]\nthickness = 2e-3\n");
    CHECK(s.grid.width == 400);
    CHECK(s.grid.height == 200);
    CHECK(*s.material.thickness == 2e-3);
    CHECK(s.material.elements.size() == 4);
    CHECK(run(s).cells_per_ridge == relative(10, 1e-12)); // the period stays, not the number of ridges

    s = scene_of(tip_preset + "[material]\nmodulus = 5e4\nviscosity = 5e3\n");
    CHECK(s.material.elements.empty());
    CHECK(run(s).tau_max == 0.1);
    s = scene_of(tip_preset + "[material]\nelements = [{ modulus = 1e5, viscosity = 1e3 }]\n");
    CHECK(s.material.elements.size() == 1);
    s = scene_of(tip_preset + "[material]\nrelaxation = { moduli = [1e5], times = [0.1], equilibrium = 1e5 }\n");
    CHECK(s.material.elements.size() == 2);
    s = scene_of(tip_preset + "[surface]\nridges = 50\n");
    CHECK_FALSE(s.surface.ridge_period.has_value());
    s = scene_of(tip_preset + "[surface]\nkind = \"flat\"\n");
    CHECK(*s.surface.relief == 5e-5);
    CHECK(run(s).cells_per_ridge == HUGE_VAL);
    CHECK(holds(why_not(tip_preset + "[material]\nmodulus = 5e4\n"), "material.viscosity = (not given)"));
}

TEST_CASE("a scene in metres says what it is made of; without units it has the study's material") {
    const std::string metres = "[grid]\nwidth = 20\nheight = 12\nspacing = 5e-5\n[surface]\nrelief = 5e-5\n[material]\n"
                               "thickness = 1e-3\ncurvature_length = 1e-5\n";
    const std::string needs = "required with grid.spacing; or material.elements, material.relaxation, or preset";
    CHECK(holds(why_not(metres + "modulus = 1\n"), "material.viscosity = (not given)"));
    CHECK(holds(why_not(metres + "modulus = 1\n"), needs));
    CHECK(scene_of(metres + "modulus = 1\nviscosity = 1\n").material.modulus == 1);
    CHECK(scene_of(metres + "elements = [{ modulus = 1, viscosity = 1 }]\n").material.elements.size() == 1);

    Scene s = in_metres();
    refuses([&] { run(s); }, "material.modulus = (not given)");
    refuses([&] { Skin(Device::cpu(1), s); }, "material.modulus = (not given)");
    s.material.modulus_map = std::vector<double>(240, 1e5);
    refuses([&] { run(s); }, "material.viscosity = (not given)");
    s.material.viscosity = 1e4;
    CHECK(run(s).tau_max == 0.1);
    refuses(
        [&] {
            run(s, {s.material, Material{.thickness = 1e-3, .curvature_length = 1e-5}});
        },
        "material.modulus = (not given)");

    Scene study = small_scene(20, 12), same = study;
    same.material.modulus = 1.54, same.material.viscosity = 1;
    CHECK(run(study).trace(Quantity::sa1).mean == run(same).trace(Quantity::sa1).mean);
}

TEST_CASE("ridges have the period asked for, on a grid of any size") {
    for (Surface::Kind kind : {Surface::Kind::wave, Surface::Kind::spiral})
        for (int width : {20, 150, 401}) {
            Scene s = in_metres();
            s.material.modulus = 1e5, s.material.viscosity = 1e4;
            s.grid = {.width = width, .height = 12, .spacing = 5e-5};
            s.surface = {.kind = kind, .noise = 0, .relief = 5e-5, .ridge_period = 6e-4};
            CHECK(run(s).cells_per_ridge == relative(12, 1e-12));
        }
}

TEST_CASE("FA2 is by default the mean over a step where a cell has a spring; a density asked for is refused") {
    const auto rule = [](const Material& m) {
        Scene s = small_scene(20, 12), mean = s;
        s.material = mean.material = m;
        mean.receptors.fa2 = Fa2::step_mean;
        const std::vector<double> a = run(s).trace(Quantity::fa2).mean;
        return a == run(mean).trace(Quantity::fa2).mean ? "mean" : "density";
    };
    const Material viscous{.modulus = 1, .viscosity = 0.5}, elastic{.modulus = 1, .viscosity = 0},
        sprung{.elements = {{1, 0.5}}, .spring = 3}, with_element{.elements = {{3, 0}, {1, 0.5}}},
        chain{.elements = {{3, 1}, {1, 0.5}}};
    CHECK(rule(viscous) == "density");
    CHECK(rule(chain) == "density");
    for (const Material& m : {elastic, sprung, with_element}) {
        CHECK(rule(m) == "mean");
        Scene s = small_scene(20, 12);
        s.material = m;
        s.receptors.fa2 = Fa2::point;
        refuses([&] { run(s); }, "step-mean");
    }
    Material some = viscous;
    some.viscosity_map = std::vector<double>(240, 0.5);
    some.viscosity_map.edit()[7] = 0;
    CHECK(rule(some) == "mean");
    // each run of a sweep by itself
    const Scene s = small_scene(20, 12);
    const std::vector<Material> all = {viscous, sprung, elastic, chain};
    const std::vector<Result> results = run(s, all);
    for (size_t i = 0; i < all.size(); ++i) {
        Scene one = s;
        one.material = all[i];
        CHECK(results[i].trace(Quantity::fa2).mean == run(one).trace(Quantity::fa2).mean);
    }
}
