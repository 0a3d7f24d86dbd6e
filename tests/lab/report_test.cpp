// SPDX-License-Identifier: MIT
// labels: command
// What the numbers of a result and of a skin mean.
#include "host/lab/output/output.hpp"
#include "tests/command.hpp"
#include "tests/support.hpp"

using namespace test;

namespace {

// A fingertip under 10 kPa, and what else a test changes.
Scene pressed_tip() {
    Scene s{fingertip()};
    s.grid.width = s.grid.height = 60;
    s.load.intensity = 1e4;
    s.time = {.step = 0.05, .duration = 3};
    return s;
}

std::vector<Quantity> sign_changed_in(const Scene& s) { return report(s, run(s)).sign_changed; }

} // namespace

TEST_CASE("a report gives strain, indentation, gain, ridges and times, each with the range that skin has") {
    const Scene s = pressed_tip();
    const Result r = run(s);
    const Report report = dermis::report(s, r);
    const std::vector<double>& strain = r.trace(Quantity::strain).max;
    CHECK(report.strain.value == *std::max_element(strain.begin(), strain.end()));
    CHECK(report.strain.greatest == 1);
    CHECK(report.indentation.value == report.strain.value * 1e-3);
    CHECK(report.indentation.greatest == 1e-3);
    CHECK(report.gain.value == r.greatest_gain);
    CHECK(report.gain.greatest == 1);
    CHECK(report.cells_per_ridge.value == relative(10, 1e-12));
    CHECK(report.cells_per_ridge.least == 8);
    REQUIRE(report.retardation_times.size() == 3); // the spring has none
    const double times[] = {5.2963222547e-3, 0.104303287895, 2.83840038985};
    for (size_t i = 0; i < 3; ++i) {
        CHECK(report.retardation_times[i].value == relative(times[i], 1e-9));
        CHECK(report.retardation_times[i].least == 1e-4);
        CHECK(report.retardation_times[i].greatest == 20);
    }
    CHECK(report.sign_changed.empty());
    for (const Figure* f : {&report.strain, &report.indentation, &report.gain, &report.cells_per_ridge})
        CHECK_FALSE(f->outside());
}

TEST_CASE("a pull is as large a strain as a press; a scene without units has no range of strains and times") {
    Scene s = pressed_tip();
    const double pressed = report(s, run(s)).strain.value;
    s.load.intensity = -1e4;
    CHECK(report(s, run(s)).strain.value == relative(pressed, 1e-12));
    Scene plain = small_scene(20, 12);
    plain.load.intensity = 1e9;
    plain.material.modulus = 1e-3;
    const Report r = report(plain, run(plain));
    CHECK(r.strain.value > 1e8);
    CHECK_FALSE(r.strain.outside());
    CHECK(std::isnan(r.indentation.value));
    REQUIRE(r.retardation_times.size() == 1);
    CHECK(r.retardation_times[0].value == 1000);
    CHECK_FALSE(r.retardation_times[0].outside());
}

TEST_CASE("what a result does not know is NaN, and outside no range") {
    Scene s = pressed_tip();
    s.output.traces = {};
    s.sites = {{Quantity::sa1, {3, 4}}};
    const Result r = run(s);
    REQUIRE(r.model == Model::sites);
    Report report = dermis::report(s, r);
    for (const Figure* f : {&report.strain, &report.indentation, &report.gain}) {
        CHECK(std::isnan(f->value));
        CHECK_FALSE(f->outside());
    }
    CHECK(report.retardation_times.size() == 3);
    s = pressed_tip();
    s.output.extremes = false;
    report = dermis::report(s, run(s));
    CHECK(std::isnan(report.strain.value));
    CHECK(report.gain.value > 0);
}

TEST_CASE("materials that differ report their least and greatest time, and neither springs nor dashpots") {
    Scene s = small_scene(2, 2);
    const auto times = [&](std::vector<double> modulus, std::vector<double> viscosity) {
        s.material.modulus_map = modulus;
        s.material.viscosity_map = viscosity;
        std::vector<double> all;
        for (const Figure& f : report(s, run(s)).retardation_times) all.push_back(f.value);
        return all;
    };
    CHECK(times({1, 2, 4, 8}, {1, 1, 1, 1}) == std::vector<double>{0.125, 1});
    CHECK(times({1, 2, 4, 8}, {1, 2, 4, 8}) == std::vector<double>{1});
    CHECK(times({1, 2, 4, 8}, {1, 1, 1, 0}) == std::vector<double>{1}); // the least is a spring's
    CHECK(times({0, 0, 0, 0}, {1, 1, 1, 1}).empty());
}

TEST_CASE("responses whose sign the curvature changes are named") {
    const std::vector<Quantity> all(std::begin(all_responses), std::end(all_responses));
    Scene s = pressed_tip();
    s.material.curvature_length = 1e-3; // |l*C| far above 1 on the crests
    CHECK(sign_changed_in(s) == all);
    s.load.intensity = -1e4;
    CHECK(sign_changed_in(s) == all);
    s.receptors.fa2_gains = {1, 1}; // rectified: without a sign
    s.material.elements = {{5e4, 5e3}};
    CHECK(sign_changed_in(s) == std::vector<Quantity>{Quantity::sa1, Quantity::sa2, Quantity::fa1});
    s.receptors.fa2_gains = {1, -1};
    s.output.traces = {Quantity::strain, Quantity::fa1};
    CHECK(sign_changed_in(s) == std::vector<Quantity>{Quantity::fa1});
    s.output.traces = {Quantity::fa1}; // nothing shows which sign it should have
    CHECK(sign_changed_in(s).empty());
    s = pressed_tip();
    s.material.curvature_length = 0;
    s.load.envelope = {
        .kind = Envelope::Kind::pulse, .length = 0.5, .period = 1}; // FA1 and FA2 have both signs in time
    CHECK(sign_changed_in(s).empty());
    s.load.envelope = {.kind = Envelope::Kind::sine, .frequency = 1}; // and so has the strain
    CHECK(sign_changed_in(s).empty());
}

TEST_CASE("a skin reports what its description tells: times, ridges and the gain at rest") {
    SkinDescription d = pressed_tip();
    d.material.elements.clear();
    d.material.modulus = 5e4;
    d.material.viscosity = 5e3;
    const Scene scene = [&] {
        Scene s = pressed_tip();
        static_cast<SkinDescription&>(s) = d;
        return s;
    }();
    double greatest = 0;
    for (double C : maps(scene).rest_curvature) greatest = std::max(greatest, std::abs(C));
    Skin skin(Device::cpu(1), d);
    const Report report = skin.report();
    CHECK(report.gain.value == relative(1e-5 * greatest, 1e-12));
    CHECK(report.cells_per_ridge.value == relative(10, 1e-12));
    REQUIRE(report.retardation_times.size() == 1);
    CHECK(report.retardation_times[0].value == 0.1);
    CHECK(report.strain.value == 0); // at rest
    CHECK(report.indentation.greatest == 1e-3);
    SkinDescription same = d; // of a map in place of the spiral, and of materials that differ in one cell
    same.surface = {.kind = Surface::Kind::map, .relief = 1, .map = maps(scene).surface};
    same.material.modulus_map = std::vector<double>(3600, 5e4);
    same.material.modulus_map.edit()[61] = 1e5;
    const Report of_map = Skin(Device::cpu(1), same).report();
    CHECK(of_map.gain.value == relative(report.gain.value, 1e-9));
    CHECK(of_map.cells_per_ridge.value == HUGE_VAL);
    REQUIRE(of_map.retardation_times.size() == 2);
    CHECK(of_map.retardation_times[0].value == 0.05);
    d.material.viscosity = 5e-3; // mPa s for Pa s
    CHECK(Skin(Device::cpu(1), d).report().retardation_times[0].outside());
}

TEST_CASE("a figure outside its range is a warning, and one within is none") {
    const auto warned = [](const Scene& s, const char* part) {
        const Result r = run(s);
        for (const std::string& sentence : output::warnings(s, r))
            if (sentence.find(part) != sentence.npos) return true;
        return false;
    };
    Scene s = pressed_tip();
    for (const char* part : {"|l*C|", "cells per ridge", "retardation time", "indentation"})
        CHECK_FALSE(warned(s, part));
    s.load.intensity = 1e5;
    CHECK(report(s, run(s)).indentation.outside());
    CHECK(warned(s, "the indentation reaches 0.001"));
    s = pressed_tip();
    s.material.curvature_length = 1e-3;
    CHECK(report(s, run(s)).gain.outside());
    CHECK(warned(s, "above 1 responses change sign"));
    s = pressed_tip();
    s.surface.ridge_period = 2e-4;
    CHECK(report(s, run(s)).cells_per_ridge.outside());
    CHECK(warned(s, "4 cells per ridge: curvature is coarse below 8"));
    s = pressed_tip();
    s.material.elements = {{5e4, 1}}; // 20 us
    CHECK(report(s, run(s)).retardation_times[0].outside());
    CHECK(warned(s, "is 2e-05 s, and skin's lie in 0.1 ms to 20 s"));
}

TEST_CASE(
    "a run whose ridges change no spike says so, unless its load touches crests, or it has no ridges or no spikes") {
    const auto warned = [](const Scene& s) {
        for (const std::string& sentence : output::warnings(s, run(s)))
            if (sentence.find("the ridges of the surface change no spike") != sentence.npos) return true;
        return false;
    };
    Scene s = pressed_tip();
    CHECK_FALSE(warned(s));
    s.afferents = {{.type = Quantity::sa1, .model = {}, .cells = {{20, 20}}}};
    CHECK(warned(s));
    const std::vector<FiredSpike> ridged = run(s).spikes;
    Scene flat = s;
    flat.surface = {.kind = Surface::Kind::flat, .relief = s.surface.relief};
    CHECK_FALSE(warned(flat));
    const std::vector<FiredSpike> even = run(flat).spikes; // and it is true
    REQUIRE(ridged.size() == even.size());
    for (size_t i = 0; i < even.size(); ++i) CHECK(ridged[i].time == even[i].time);
    s.load.contact = Load::Contact::crests;
    CHECK_FALSE(warned(s));
}

TEST_CASE("summary.json holds the report") {
    const Folder folder;
    const std::string scene =
        folder.write("scene.toml", "preset = \"fingertip\"\n[grid]\nwidth = 40\nheight = 40\n[load]\nintensity = 1e5\n"
                                   "[output]\ntraces = [\"strain\", \"sa1\"]\n");
    const auto summary = [&](const std::string& set) {
        const std::string out = (folder / "out").string();
        REQUIRE(command(folder, "run " + scene + " --device cpu --out " + out + set).status == 0);
        return output::Json::parse(slurp(folder / "out/summary.json")).at("report");
    };
    output::Json report = summary("");
    CHECK(report["strain"]["greatest"] == 1);
    CHECK(report["strain"]["within"] == false);
    CHECK(report["cells_per_ridge"].dump() == R"({"value":10.0,"least":8.0,"greatest":null,"within":true})");
    CHECK(report["retardation_times"][0]["value"] == relative(0.005296, 1e-3));
    CHECK(report["sign_changed"].empty());
    report = summary(" --set material.curvature_length=1e-3 output.extremes=true");
    CHECK(report["sign_changed"] == output::Json{"sa1"});
    report = summary(" --set output.extremes=false");
    CHECK(report["strain"].dump() == R"({"value":null,"least":0.0,"greatest":1.0,"within":null})");
}
