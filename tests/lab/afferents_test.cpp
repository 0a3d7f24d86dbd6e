// SPDX-License-Identifier: MIT
// The nerve fibres of scenes: what acts on them, when they fire, and the files that say so.
#include "host/core/base/watch.hpp"
#include "host/core/cpu/fibres.hpp"
#include "host/lab/output/earlier.hpp"
#include "host/lab/output/output.hpp"
#include "host/lab/run/collector.hpp"
#include "tests/command.hpp"
#include "tests/oracle/scene_files.hpp"
#include "tests/support.hpp"

#include <cstring>
#include <fstream>

using namespace test;

namespace {

// Fibres that fire well under strains of a thousandth; those of the classes are fitted, and may be fitted again.
AfferentModel lively(Quantity type) {
    AfferentModel m;
    m.time_constants = {0.54e-3, type == Quantity::fa1 ? 0.66e-3 : 0.47e-3};
    m.value = 0;
    m.rate = 1;
    m.gains = {{{120, 2.4}, {0, 0}, {0, 0}}};
    m.membrane_time = 0.0065;
    m.refractory_time = 1.9e-3;
    if (type == Quantity::sa1) {
        m.time_constants = {2.25e-3, 1.8e-3};
        m.value = 15.3;
        m.gains[0] = {68, 5.4};
        m.membrane_time = 0.0237;
        m.refractory_time = 0.94e-3;
    } else if (type == Quantity::fa2) {
        m.gains = {{{0, 0}, {8.6, 0}, {0, 0}}};
        m.membrane_time = 0.05;
        m.refractory_time = 2.7e-3;
    }
    return m;
}

Afferents fibres(Quantity type, std::vector<Cell> cells) {
    Afferents a;
    a.type = type;
    a.model = lively(type);
    a.cells = std::move(cells);
    return a;
}

// An even skin in metres without gain, so that SA1 is what a fibre answers to, under a load that rises and is held.
Scene pressed_skin() {
    Scene s;
    s.grid = {.width = 20, .height = 16, .spacing = 2e-4};
    s.surface = {.kind = Surface::Kind::flat, .relief = 1e-6};
    s.material.elements = {{.modulus = 8e4, .viscosity = 8e4 * 0.008}, {.modulus = 1e5, .viscosity = 1e5 * 0.3}};
    s.material.spring = 1e5;
    s.material.thickness = 1e-3;
    s.material.curvature_length = 0;
    s.load.intensity = 300;
    s.load.envelope = {.kind = Envelope::Kind::ramp, .start = 0.0103, .rise = 0.02};
    s.time = {.step = 1e-3, .duration = 0.3};
    s.output.traces = {Quantity::strain};
    s.afferents = {fibres(Quantity::sa1, {{10, 8}, {12, 9}}), fibres(Quantity::fa1, {{10, 8}, {7, 7}}),
                   fibres(Quantity::fa2, {{10, 8}})};
    return s;
}

Scene vibrating_skin() {
    Scene s = pressed_skin();
    s.load.envelope = {.kind = Envelope::Kind::sine, .frequency = 40, .phase = -1.5707963267948966, .mean = 1};
    return s;
}

// The greatest difference of spikes of two runs, s; infinite where they are not the same spikes.
double apart(const std::vector<FiredSpike>& a, const std::vector<FiredSpike>& b) {
    if (a.size() != b.size()) return INFINITY;
    double greatest = 0;
    const auto by_fibre = [](std::vector<FiredSpike> s) {
        std::ranges::stable_sort(s, {}, &FiredSpike::afferent);
        return s;
    };
    const std::vector<FiredSpike> one = by_fibre(a), other = by_fibre(b);
    for (size_t i = 0; i < one.size(); ++i) {
        if (one[i].afferent != other[i].afferent) return INFINITY;
        greatest = std::max(greatest, std::abs(one[i].time - other[i].time));
    }
    return greatest;
}

// The spikes of a scene's first fibre, stepped from output to output of the run's own SA1 in its cell, for which the
// scene must have no gain.
std::vector<FiredSpike> fed_with_sa1(Scene s, double step) {
    s.time.step = step;
    s.output.traces = {Quantity::sa1};
    s.output.probes = {s.afferents[0].cells[0]};
    const AfferentModel model = *s.afferents[0].model;
    s.afferents.clear();
    const Result r = run(s);
    cpu::Fibres<f64> fibre({{.model = model, .count = 1}}, 1, 1, simd::best());
    REQUIRE(fibre.prepare(step));
    std::vector<FiredSpike> spikes;
    for (size_t n = 1; n < r.time.size(); ++n) {
        fibre.set_input(0, &r.traces[0].probes[0][n]);
        fibre.forget_spikes();
        fibre.press(0, 1);
        for (const auto& spike : fibre.spikes()) spikes.push_back({(double(n - 1) + spike.share) * step, 0});
    }
    return spikes;
}

// Takes the elements away: a spring is left, which takes the whole strain at once.
void make_elastic(Scene& s) {
    s.material.elements.clear();
    s.material.spring.reset();
    s.material.modulus = 1e5;
    s.material.viscosity = 0;
}

std::vector<FiredSpike> first_fibre(Scene s) {
    s.afferents = {fibres(s.afferents[0].type, {s.afferents[0].cells[0]})};
    return run(s).spikes;
}

} // namespace

TEST_CASE("a fibre under a held load fires after each refractory time and tau ln(I/(I - 1))") {
    Scene s = pressed_skin();
    make_elastic(s);
    s.load.envelope = {};
    s.load.intensity = 200; // Pa: a strain of 0.002 in the middle
    const AfferentModel m = lively(Quantity::sa1);
    const double current = m.gains[0][0] * m.value * 0.002,
                 period = m.refractory_time + m.membrane_time * std::log(current / (current - 1));
    std::vector<double> times;
    for (const FiredSpike& spike : run(s).spikes)
        if (spike.afferent == 0 && spike.time > 0.1) times.push_back(spike.time);
    REQUIRE(times.size() > 5);
    for (size_t i = 1; i < times.size(); ++i) CHECK(times[i] - times[i - 1] == doctest::Approx(period).epsilon(1e-9));
}

TEST_CASE("a jump of the load makes fibres fire as a rise within a microsecond does") {
    Scene s = pressed_skin();
    make_elastic(s);
    for (double start : {0.0, 0.0501}) {
        s.load.envelope = {.kind = Envelope::Kind::step, .start = start};
        const std::vector<FiredSpike> spikes = run(s).spikes;
        s.load.envelope = {.kind = Envelope::Kind::ramp, .start = start, .rise = 1e-6};
        CHECK(
            std::ranges::any_of(spikes, [&](auto& spike) { return spike.afferent == 4 && spike.time < start + 2e-3; }));
        CHECK(std::ranges::none_of(spikes, [&](auto& spike) { return spike.time < start; }));
        CHECK(apart(run(s).spikes, spikes) < 2e-6);
    }
}

TEST_CASE("the step of the outputs does not change a spike") {
    for (const Scene& scene : {vibrating_skin(), pressed_skin()}) {
        const bool sine = scene.load.envelope.kind == Envelope::Kind::sine;
        Scene s = scene;
        const std::vector<FiredSpike> spikes = run(s).spikes;
        CHECK(spikes.size() > 30);
        for (double step : {2.5e-4, 7e-4, 5e-3}) {
            s.time.step = step;
            CAPTURE(step);
            CHECK(apart(run(s).spikes, spikes) < (sine && step == 2.5e-4 ? 1e-6 : 1e-5));
        }
    }
}

TEST_CASE("nor does it of FA2, which follows jumps of the rate, under a slow sine, in slow skin and between frames") {
    Scene s = pressed_skin();
    s.afferents = {{.type = Quantity::fa2, .cells = {{10, 8}, {7, 7}}}};
    s.load.intensity = 3e4;
    Scene slow = s, frames = s;
    s.load.envelope = {
        .kind = Envelope::Kind::sine, .frequency = 0.5, .phase = 1.5707963267948966, .mean = 1, .amplitude = -1};
    s.time.duration = 2;
    slow.material.elements = {{.modulus = 5e4, .viscosity = 5e4}};
    slow.material.spring.reset();
    frames.material.elements = {{.modulus = 5e4, .viscosity = 5e3}};
    frames.material.spring.reset();
    const Folder folder;
    std::vector<std::vector<double>> maps(4, std::vector<double>(20 * 16));
    for (size_t i = 320; i < 4 * 320; ++i) maps[i / 320][i % 320] = double(i * 37 % 101) * 400;
    oracle::write_frames(folder / "frames.npy", frames.grid, maps);
    frames.load = {.kind = Load::Kind::sequence};
    frames.load.path = (folder / "frames.npy").string();
    frames.load.interval = 0.03;
    for (Scene* scene : {&s, &slow, &frames}) {
        scene->time.step = 1e-4;
        const std::vector<FiredSpike> spikes = run(*scene).spikes;
        CHECK(spikes.empty() == (scene == &s));
        for (double step : {1e-3, 1e-2}) {
            scene->time.step = step;
            CAPTURE(step);
            CHECK(apart(run(*scene).spikes, spikes) < 1e-5);
        }
    }
}

TEST_CASE("the spikes of all models and precisions are the same") {
    Scene s = vibrating_skin();
    s.sites = {{Quantity::sa1, {10, 8}}};
    const std::vector<FiredSpike> spikes = run(s).spikes;
    for (Model model : {Model::moments, Model::maps, Model::march})
        for (Precision precision : {Precision::f32, Precision::f64}) {
            if (model != Model::march && precision == Precision::f32) continue;
            s.model = model;
            s.precision = precision;
            CHECK(apart(run(s).spikes, spikes) == 0);
        }
    s.precision.reset();
    s.output.traces.clear();
    s.model = Model::sites;
    CHECK(apart(run(s).spikes, spikes) == 0);
    const Result of_materials = run(s, {s.material, s.material}).back();
    CHECK(apart(of_materials.spikes, spikes) == 0);
}

TEST_CASE("fibres fire as if they were stepped through the responses of the run at close outputs") {
    for (double depth : {0.0, 3e-4})
        for (bool vibrates : {false, true}) {
            Scene s = vibrates ? vibrating_skin() : pressed_skin();
            if (depth > 0) s.receptors.depth.sa1 = depth, s.load.intensity *= 2;
            const std::vector<FiredSpike> spikes = first_fibre(s);
            CAPTURE(depth);
            CHECK(spikes.size() > 5);
            CHECK(apart(spikes, fed_with_sa1(s, 5e-5)) < 2e-5);
        }
}

TEST_CASE("a spike of a scene is right to 1e-10 s where the strain runs along lines, and else to some 1e-5 s") {
    Scene s = pressed_skin();
    s.time.duration = 0.08;
    s.load.envelope = {.kind = Envelope::Kind::table, .times = {0, 0.02, 0.05}, .values = {0, 0.5, 1.5}};
    Scene elastic = s;
    make_elastic(elastic);
    const std::vector<FiredSpike> along_lines = first_fibre(elastic), curved = first_fibre(s);
    CHECK(along_lines.size() > 3);
    CHECK(curved.size() > 3);
    CHECK(apart(along_lines, fed_with_sa1(elastic, 1e-3)) < 1e-10);
    const double off = apart(curved, fed_with_sa1(s, 5e-6)); // its lines are off by a hundredth of a run's
    CHECK(off < 2e-5);
    CHECK(off > 1e-10);
}

TEST_CASE("of several endings the most strained one fires a fibre, and fibres are counted, not endings") {
    for (Scene s : {pressed_skin(), vibrating_skin()}) {
        const std::vector<FiredSpike> alone = first_fibre(s);
        CHECK(alone.size() > 5);
        s.afferents = {fibres(Quantity::sa1, {{0, 0}, {10, 8}, {5, 7}, {3, 3}, {10, 8}, {11, 1}}),
                       fibres(Quantity::sa1, {{10, 8}})};
        s.afferents[0].endings = 3;
        std::vector<std::vector<double>> times(3);
        for (const FiredSpike& spike : run(s).spikes) times.at(size_t(spike.afferent)).push_back(spike.time);
        for (const std::vector<double>& of_fibre : times) {
            REQUIRE(of_fibre.size() == alone.size());
            for (size_t i = 0; i < alone.size(); ++i) CHECK(of_fibre[i] == alone[i].time);
        }
    }
}

TEST_CASE("a depth and the stress are those of the fibre's class") {
    Scene s = pressed_skin();
    const std::vector<FiredSpike> strain = first_fibre(s);
    s.receptors.depth.fa1 = 3e-4; // of another class
    CHECK(apart(first_fibre(s), strain) == 0);
    s.receptors.depth = {};
    s.afferents[0].follow = Signal::stress; // under a pressure: pressure/modulus at rest, which comes at once
    const double at_rest = 1 / (1 / 8e4 + 2 / 1e5), q = 300 / at_rest;
    const AfferentModel m = lively(Quantity::sa1);
    const double current = m.gains[0][0] * m.value * q,
                 period = m.refractory_time + m.membrane_time * std::log(current / (current - 1));
    std::vector<double> times;
    for (const FiredSpike& spike : run(s).spikes)
        if (spike.afferent == 0 && spike.time > 0.1) times.push_back(spike.time);
    REQUIRE(times.size() > 5);
    CHECK(times[4] - times[3] == doctest::Approx(period).epsilon(1e-9));

    Scene punched = pressed_skin();
    punched.load = {.kind = Load::Kind::punch, .radius = 4, .intensity = 3e-5};
    punched.load.control = Load::Control::depth;
    punched.load.envelope = {.kind = Envelope::Kind::ramp, .start = 0.0103, .rise = 0.02};
    punched.receptors.follow.sa1 = Signal::stress;
    const std::vector<FiredSpike> followed = first_fibre(punched);
    CHECK(followed.size() > 5);
    CHECK(apart(followed, fed_with_sa1(punched, 5e-5)) < 2e-5);
    punched.receptors.follow.sa1 = Signal::strain;
    CHECK(apart(first_fibre(punched), followed) > 1e-3);
    punched.afferents[0].follow = Signal::stress;
    Result own = run(punched);
    std::erase_if(own.spikes, [](auto& spike) { return spike.afferent > 0; });
    CHECK(apart(own.spikes, followed) == 0);
}

TEST_CASE("a sequence fires the fibres of a skin that is pressed with the same frames") {
    constexpr int side = 12, frames = 400;
    constexpr double dt = 2.5e-4;
    Scene s;
    s.grid = {.width = side, .height = side, .spacing = 5e-4};
    s.surface = {.kind = Surface::Kind::flat, .relief = 1e-6};
    s.material.modulus = 2e4;
    s.material.viscosity = 1e3;
    s.material.thickness = 1e-3;
    s.material.curvature_length = 1e-4;
    s.load.kind = Load::Kind::sequence;
    s.load.interval = dt;
    s.time = {.step = 1e-3, .duration = dt * (frames - 1)};
    s.output.traces = {Quantity::strain};
    s.afferents = {fibres(Quantity::sa1, {{1, 1}, {10, 8}}), fibres(Quantity::fa1, {{6, 6}}),
                   fibres(Quantity::fa2, {{2, 11}})};
    const Folder folder;
    s.load.path = folder / "frames.npy";
    Skin skin(Device::cpu(1), s, {.responses = {Quantity::sa1}, .afferents = s.afferents});
    std::ofstream file(s.load.path, std::ios::binary);
    file << npy_header("<f4", "(" + std::to_string(frames) + ", 12, 12)");
    std::vector<FiredSpike> spikes;
    for (int n = 0; n < frames; ++n) {
        std::vector<float> pressure;
        for (int i = 0; i < side * side; ++i)
            pressure.push_back(float(150 * (1 + 0.002 * i) * (1 - std::cos(2 * 3.14159265 * 60 * dt * n))));
        file.write(reinterpret_cast<const char*>(pressure.data()), std::streamsize(pressure.size() * sizeof(float)));
        skin.press(pressure, n ? dt : 0);
        for (const Spike& spike : skin.spikes()) spikes.push_back({(n - 1 + double(spike.share)) * dt, spike.afferent});
    }
    file.close();
    CHECK(spikes.size() > 20);
    CHECK(apart(run(s).spikes, spikes) <
          2e-5); // the skin knows its frames alone, the scene the strain between them too
}

TEST_CASE("progress grows while fibres are stepped, up to half of the run") {
    const Scene s = pressed_skin();
    std::vector<double> done;
    const scene::Watch::Progress note = [&](double share) { done.push_back(share); };
    const scene::Watch watch(note, std::chrono::milliseconds(0));
    CHECK(!spikes_of(s, s.afferents, 1).empty());
    REQUIRE(done.size() > 100);
    CHECK(std::ranges::is_sorted(done));
    CHECK(done.front() == 0);
    CHECK(done.back() > 0.45);
    CHECK(done.back() <= 0.5);
    CHECK(std::ranges::count_if(done, [](double share) { return share > 0.1 && share < 0.4; }) > 50);
}

TEST_CASE("frames further apart than the material takes to follow fire as the same load in closer frames") {
    constexpr int frames = 30, closer = 8, cells = 20 * 16;
    const Folder folder;
    const auto written = [&](const std::string& name, int parts) {
        std::vector<std::vector<double>> all;
        const auto height = [](int k) { return k == 0 ? 0 : 300 * (1 + 0.3 * std::sin(1.3 * k)); };
        for (int n = 0; n <= (frames - 1) * parts; ++n) {
            const double share = double(n % parts) / parts;
            all.emplace_back(cells, height(n / parts) * (1 - share) + height(n / parts + 1) * share);
        }
        oracle::write_frames(folder / name, pressed_skin().grid, all);
        return (folder / name).string();
    };
    Scene s = pressed_skin();
    s.load = {.kind = Load::Kind::sequence};
    s.time.duration = 0.2; // held after the last frame
    s.load.path = written("frames.npy", 1);
    s.load.interval = 5e-3;
    const std::vector<FiredSpike> spikes = run(s).spikes;
    CHECK(spikes.size() > 100);
    s.load.path = written("closer.npy", closer);
    s.load.interval = 5e-3 / closer;
    CHECK(apart(run(s).spikes, spikes) < 1e-5);
}

TEST_CASE("a scene file has fibres in its sites, and keys that replace the class's numbers") {
    const Scene s =
        Scene::from_string("[sites]\n[[afferents]]\ntype = \"fa1\"\ncells = [[3, 4], [5, 6]]\nendings = 2\n"
                           "[[afferents]]\ntype = \"sa2\"\ncells = [[1, 1]]\nfollow = \"stress\"\n"
                           "time_constants = [\"2 ms\"]\nfrequency = \"0.1 kHz\"\nquality = 0.7\nvalue = 3\n"
                           "rate = \"5 ms\"\ngains = [[1, 2], [3, 4]]\nmembrane_time = \"20 ms\"\n"
                           "refractory_time = 1e-3\nreset = -0.5\nafter = [{ amplitude = -2, time = \"30 ms\" }]");
    REQUIRE(s.afferents.size() == 2);
    CHECK(!s.afferents[0].model);
    CHECK(s.afferents[0].cells[1].y == 6);
    CHECK(s.afferents[0].endings == 2);
    CHECK(s.afferents[1].endings == 1);
    const Afferents& a = s.afferents[1];
    CHECK(a.type == Quantity::sa2);
    CHECK(a.follow == Signal::stress);
    REQUIRE(a.model);
    CHECK(a.model->time_constants == std::vector<double>{2e-3});
    CHECK(*a.model->frequency == 100);
    CHECK(*a.model->quality == 0.7);
    CHECK(a.model->value == 3);
    CHECK(a.model->rate == 5e-3);
    CHECK(a.model->gains == std::array<std::array<double, 2>, 3>{{{1, 2}, {3, 4}, {0, 0}}});
    CHECK(a.model->membrane_time == 0.02);
    CHECK(a.model->refractory_time == 1e-3);
    CHECK(a.model->reset == -0.5);
    CHECK(a.model->after[0].amplitude == -2);
    CHECK(a.model->after[0].time == 0.03);
    CHECK(a.model->after[1].amplitude == 0);
}

TEST_CASE("a run writes spikes, fibres and rates, and removes them with the next run") {
    Scene s = vibrating_skin();
    s.sites = {{Quantity::fa2, {10, 8}}, {Quantity::sa1, {3, 3}}, {Quantity::fa2, {11, 8}}};
    s.afferents[1].endings = 2;
    s.afferents[2].cells.clear(); // those of the sites
    const Result r = run(s);
    const Folder folder;
    const std::filesystem::path out = folder / "out";
    output::write_result(output::Folder(out), s, r, output::origin_of("", {}, {}, {}));
    const std::string spikes = slurp(out / "spikes.npy");
    const std::string begin =
        output::npy_header("[('time', '<f8'), ('afferent', '<u4')]", "(" + std::to_string(r.spikes.size()) + ",)");
    REQUIRE(spikes.size() == begin.size() + 12 * r.spikes.size());
    CHECK(spikes.substr(0, begin.size()) == begin);
    CHECK(begin.size() % 64 == 0);
    for (size_t i = 0; i < r.spikes.size(); ++i) {
        double time = 0;
        uint32_t afferent = 0;
        std::memcpy(&time, spikes.data() + begin.size() + 12 * i, 8);
        std::memcpy(&afferent, spikes.data() + begin.size() + 12 * i + 8, 4);
        CHECK(time == r.spikes[i].time);
        CHECK(int(afferent) == r.spikes[i].afferent);
        CHECK((i == 0 || r.spikes[i - 1].time <= time));
    }
    std::ifstream list(out / "afferents.csv");
    std::vector<std::string> lines;
    for (std::string line; std::getline(list, line);) lines.push_back(line);
    REQUIRE(lines.size() == 6);
    CHECK(lines[0] == "number,class,x,y,spikes,rate");
    CHECK(lines[3].starts_with("2,fa1,8.5,7.5,"));
    CHECK(lines[5].starts_with("4,fa2,11,8,"));
    const Columns rates = read_csv((out / "psth.csv").string());
    REQUIRE(rates.size() == 4);
    REQUIRE(rates.at("time").size() == 300);
    double fired = 0;
    for (const auto& [column, fibres] : {std::pair{"sa1_0", 2}, {"fa1_1", 1}, {"fa2_2", 2}})
        for (double rate : rates.at(column)) fired += rate * fibres * 1e-3;
    CHECK(fired == doctest::Approx(double(r.spikes.size())));
    CHECK(slurp(out / "summary.json").find("\"spikes\": " + std::to_string(r.spikes.size()) + ",") !=
          std::string::npos);
    s.afferents.clear();
    output::write_result(output::Folder(out), s, run(s), output::origin_of("", {}, {}, {}));
    CHECK(!std::filesystem::exists(out / "spikes.npy"));
    CHECK(!std::filesystem::exists(out / "psth.csv"));
}
