// SPDX-License-Identifier: MIT
// labels: device threads
// Every two models agree where both can serve a scene.
#include "tests/support.hpp"

#include <random>

using namespace test;

namespace {

Result under(Scene s, Model model) {
    RunOptions options{.precision = Precision::f64};
    s.model = model;
    const Result r = run(s, Device::cpu(), options);
    CHECK(int(r.model) == int(model));
    return r;
}

void check_agree(const Result& a, const Result& b, double tolerance) {
    REQUIRE(a.time == b.time);
    for (const Trace& t : b.traces) {
        CAPTURE(name(t.quantity));
        const Trace& other = a.trace(t.quantity);
        // by the greatest value of any cell: a mean may cancel
        double largest = 1e-300;
        for (const auto* part : {&t.min, &t.max})
            for (double v : *part) largest = std::max(largest, std::abs(v));
        const auto close = [&](const std::vector<double>& x, const std::vector<double>& y) {
            for (size_t i = 0; i < x.size(); ++i) REQUIRE(std::abs(x[i] - y[i]) <= tolerance * largest);
        };
        close(other.mean, t.mean);
        close(other.min, t.min);
        close(other.max, t.max);
        for (size_t p = 0; p < t.probes.size(); ++p) close(other.probes[p], t.probes[p]);
    }
    REQUIRE(a.fields.size() == b.fields.size());
    for (size_t i = 0; i < a.fields.size(); ++i) {
        CAPTURE(name(a.fields[i].quantity));
        CHECK(difference(a.fields[i].values, b.fields[i].values) < tolerance);
    }
    REQUIRE(a.impulses.size() == b.impulses.size());
    for (size_t i = 0; i < a.impulses.size(); ++i) {
        CHECK(a.impulses[i].mean == relative(b.impulses[i].mean, tolerance));
        if (!std::isnan(a.impulses[i].min)) CHECK(a.impulses[i].min == relative(b.impulses[i].min, tolerance));
        CHECK(difference(a.impulses[i].probes, b.impulses[i].probes) < tolerance);
    }
}

const std::vector<Quantity> all_quantities = {Quantity::strain,     Quantity::sa1, Quantity::sa2,
                                              Quantity::fa1,        Quantity::fa2, Quantity::curvature,
                                              Quantity::deformation};

// Every kind begins, bends or jumps between outputs. A frequency of no whole periods leaves a dashpot a strain that is
// not rounding alone.
void take_envelope(Envelope& e, Envelope::Kind kind, double frequency) {
    e.kind = kind;
    if (kind == Envelope::Kind::table) e.times = {0.03, 0.21, 0.21}, e.values = {1, -0.5, 2};
    else e.start = kind == Envelope::Kind::sine ? 0 : 0.1;
    e.length = 0.07;
    e.period = 0.17;
    e.frequency = frequency;
}

// Gives every cell a stiffness of its own, within `decades` powers of ten, by which modulus and viscosity are
// multiplied.
void vary(Material& m, const Grid& grid, double decades) {
    std::vector<double> modulus, viscosity;
    for (int i = 0; i < grid.width * grid.height; ++i) {
        const double stiffness = std::pow(10, decades * std::sin(0.7 * i * (1 + i % 3)));
        modulus.push_back(m.modulus.value_or(1.54) * stiffness);
        viscosity.push_back(m.viscosity.value_or(1) * stiffness);
    }
    m.modulus_map = modulus;
    m.viscosity_map = viscosity;
}

} // namespace

TEST_CASE("without extremes: the same means and probes, by every model, and no least and greatest") {
    Scene s = small_scene(70, 45);
    s.load.envelope = {Envelope::Kind::pulse};
    const Validated vulkan;
    for (const Device& device : {Device::cpu(2), vulkan.device()})
        for (Model model : {Model::moments, Model::maps, Model::march}) {
            s.model = model;
            s.output.extremes = true;
            const Result all = run(s, device);
            s.output.extremes = false;
            const Result means = run(s, device);
            for (const Trace& t : all.traces) {
                const Trace& lean = means.trace(t.quantity);
                CHECK(lean.mean == t.mean);
                CHECK(lean.probes == t.probes);
                CHECK(lean.min.empty());
                CHECK(lean.max.empty());
                CHECK(t.max.size() == t.mean.size());
            }
            REQUIRE(means.impulses.size() == all.impulses.size());
            REQUIRE(!means.impulses.empty());
            CHECK(means.impulses[0].mean == all.impulses[0].mean);
            CHECK(std::isnan(means.impulses[0].max));
        }
}

TEST_CASE("moments, maps and march agree to 1e-12 under every method, envelope, stencil, edge and receptor") {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int i = 0; i < 120; ++i) {
        CAPTURE(i);
        Scene s = small_scene(3 + int(random() % 90), 2 + int(random() % 40));
        s.method = Method(i % 8);
        s.surface.kind = Surface::Kind(random() % 3);
        s.load.kind = Load::Kind(random() % 3);
        s.load.intensity = 3 * number(random);
        s.material.modulus = std::pow(10, number(random));
        s.material.viscosity = std::pow(10, number(random));
        s.allow_unstable = true;
        take_envelope(s.load.envelope, Envelope::Kind(random() % 5), 4);
        if (s.method == Method::published) {
            if (std::min(s.grid.width, s.grid.height) < 2) continue;
        } else {
            s.stencil = Stencil(random() % 3);
            s.edges = *s.stencil == published_stencil ? published_edges : Edges(random() % 2);
            s.receptors.fa2 = Fa2(random() % 2);
            if (s.method == Method::exact && random() % 2) s.receptors.sa2_adaptation = 0.3;
            const double gain = 1 + number(random) / 2;
            s.receptors.fa2_gains = {gain, -gain};
        }
        s.time.duration = 0.5;
        const Result march = under(s, Model::march);
        check_agree(under(s, Model::moments), march, 1e-12);
        s.output.fields = {{0.3, all_quantities}, {0, all_quantities}};
        if (s.method == Method::exact) s.output.fields.push_back({0.123, all_quantities});
        check_agree(under(s, Model::maps), under(s, Model::march), 1e-12);
    }
}

TEST_CASE("moments, maps, sites and march agree to 1e-12 where materials differ but for their retardation time") {
    std::mt19937 random(12);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int i = 0; i < 80; ++i) {
        CAPTURE(i);
        Scene s = small_scene(3 + int(random() % 70), 2 + int(random() % 30));
        s.method = Method(i % 7); // the published one knows no maps
        s.allow_unstable = true;
        s.surface.kind = Surface::Kind(random() % 3);
        s.load.kind = Load::Kind(random() % 3);
        s.material.modulus = std::pow(10, number(random));
        s.material.viscosity = std::pow(10, number(random));
        s.stencil = Stencil(random() % 3);
        s.edges = Edges(random() % 2);
        s.receptors.fa2 = Fa2(random() % 2);
        if (s.method == Method::exact && random() % 2) s.receptors.sa2_adaptation = 0.3;
        const int kind = int(random() % 4);
        if (kind == 0) s.material.modulus = 0; // dashpots
        if (kind == 1 && s.method == Method::exact)
            s.material.viscosity = 0, s.receptors.fa2 = Fa2::step_mean; // springs
        vary(s.material, s.grid, 1.5);
        take_envelope(s.load.envelope, Envelope::Kind(random() % 5), 3.7);
        s.load.envelope.phase = 0.4;
        const Result march = under(s, Model::march);
        const Result moments = under(s, Model::moments);
        check_agree(moments, march, 1e-12);
        CHECK(moments.pressed_cells == march.pressed_cells);
        // A march of springs that a pulse has let go of keeps a rounding of their strain, 5, and so of the curvature,
        // 0.
        const double size = std::max(1.0, march.greatest_curvature);
        CHECK(moments.greatest_curvature == absolute(march.greatest_curvature, size * 1e-12));
        if (kind == 0) CHECK(moments.tau_max == HUGE_VAL);
        CHECK(moments.tau_max == relative(march.tau_max, 1e-12));
        s.output.fields = {{0.3, all_quantities}, {0, all_quantities}};
        if (s.method == Method::exact && s.material.viscosity > 0) s.output.fields.push_back({0.123, all_quantities});
        check_agree(under(s, Model::maps), under(s, Model::march), 1e-12);
        s.output = {{}, {}, {}, true};
        for (Quantity q : all_responses) s.sites.push_back({q, {int(random() % 3), int(random() % 2)}});
        CHECK(difference(under(s, Model::sites).responses, under(s, Model::march).responses) < 1e-12);
    }
}

// Up to eight classes of material over the cells, of as many retardation times, one a spring and one a dashpot.
void classify(Material& m, const Grid& grid, int classes, bool spring, bool dashpot) {
    std::vector<double> modulus, viscosity;
    for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x) {
            const int k = (x / 2 + y * y) % classes;
            modulus.push_back(dashpot && k == 1 ? 0 : m.modulus.value_or(1.54) * (1 + 0.1 * x));
            viscosity.push_back(spring && k == 2 ? 0 : m.viscosity.value_or(1) * (1 + 0.1 * x) * std::pow(3, k - 1));
        }
    m.modulus_map = modulus;
    m.viscosity_map = viscosity;
}

TEST_CASE("a few retardation times are a part each: moments, maps, sites and march agree to 1e-12 without extremes") {
    std::mt19937 random(13);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int i = 0; i < 60; ++i) {
        CAPTURE(i);
        Scene s = small_scene(5 + int(random() % 70), 3 + int(random() % 30));
        s.method = Method(i % 7);
        s.allow_unstable = true;
        s.output.extremes = false;
        s.material.modulus = std::pow(10, number(random));
        s.material.viscosity = std::pow(10, number(random));
        s.stencil = Stencil(random() % 3);
        s.edges = Edges(random() % 2);
        const bool exact = s.method == Method::exact, spring = exact && random() % 2;
        s.receptors.fa2 = spring ? Fa2::step_mean : Fa2(random() % 2);
        if (exact && random() % 2) s.receptors.sa2_adaptation = 0.3;
        classify(s.material, s.grid, 2 + int(random() % 7), spring, random() % 2);
        take_envelope(s.load.envelope, Envelope::Kind(random() % 5), 3.7);
        const Result moments = under(s, Model::moments);
        s.output.extremes = true; // the scale of what is compared
        const Result march = under(s, Model::march);
        s.output.extremes = false;
        check_agree(moments, march, 1e-12);
        CHECK(moments.tau_max == relative(march.tau_max, 1e-12));
        s.output.fields = {{0.3, all_quantities}, {0, all_quantities}};
        if (exact && !spring) s.output.fields.push_back({0.123, all_quantities});
        const Result maps = under(s, Model::maps);
        s.output.extremes = true;
        check_agree(maps, under(s, Model::march), 1e-12);
        s.output.traces.clear(); // extremes are a default that no trace asks for
        s.output.fields = {{0.3, all_quantities}};
        CHECK(int(under(s, Model::maps).fields.size()) == int(all_quantities.size()));
        s.output = {{}, {}, {}, true};
        for (Quantity q : all_responses) s.sites.push_back({q, {int(random() % 5), int(random() % 3)}});
        for (Model model : {Model::sites, Model::moments})
            CHECK(difference(under(s, model).responses, under(s, Model::march).responses) < 1e-12);
    }
}

TEST_CASE("moments of several retardation times have the same bits on any number of threads") {
    Scene s = small_scene(300, 270);
    s.output.extremes = false;
    s.model = Model::moments;
    classify(s.material, s.grid, 3, false, false);
    const Result one = run(s, Device::cpu(1)), three = run(s, Device::cpu(3));
    for (const Trace& t : one.traces) CHECK(t.mean == three.trace(t.quantity).mean);
}

TEST_CASE("materials that differ are served without a march where retardation times are few, and `plan` says so") {
    Scene s = small_scene(8, 8);
    s.material = {0.7, 0.21, {}, {}, {}, {}};
    const auto taken = [&] { return run(s, Device::cpu()).model; };
    const auto times = [&] { return plan(s, Device::cpu()).retardation_times; };
    CHECK(times().empty()); // a uniform skin needs no saying
    vary(s.material, s.grid, 1.5);
    CHECK(int(taken()) == int(Model::moments));
    REQUIRE(times().size() == 1);
    CHECK(times()[0] == relative(0.3, 1e-12));
    s.receptors.fa2_gains = {1, 0};
    CHECK(int(taken()) == int(Model::march));
    CHECK(times().empty());
    s.receptors.fa2_gains = {1, -1};
    const Map viscosity = s.material.viscosity_map;
    for (double factor : {1 + 1e-6, 0.5, 0.0}) { // one cell alone
        CAPTURE(factor);
        s.material.viscosity_map = viscosity;
        s.material.viscosity_map.edit()[5] *= factor;
        s.receptors.fa2 = factor > 0 ? Fa2::point : Fa2::step_mean;
        CHECK(int(taken()) == int(Model::march)); // of extremes
        CHECK(times().size() == 2);
        s.output.extremes = false;
        CHECK(int(taken()) == int(Model::moments));
        s.output.extremes = true;
    }
    s.material.viscosity_map = {};
    s.material.viscosity = 0;
    CHECK(int(taken()) == int(Model::moments));
    CHECK(times() == std::vector<double>{0});
    s.material = {0, 1, {}, {}, {}, viscosity};
    CHECK(int(taken()) == int(Model::moments));
    CHECK(times() == std::vector<double>{HUGE_VAL});
    s.material.viscosity_map = std::vector<double>(64, 2); // a map, and yet uniform
    CHECK(int(taken()) == int(Model::moments));
    CHECK(times().empty());
    s.material = {1, 1, {}, {}, {}, {}};
    s.output.extremes = false;
    s.model = Model::moments;
    classify(s.material, s.grid, 8, false, false);
    CHECK(times().size() == 8);
    CHECK(int(taken()) == int(Model::moments));
    classify(s.material, s.grid, 9, false, false);
    CHECK_THROWS_WITH(taken(), doctest::Contains("more than 8 retardation times"));
}

TEST_CASE("the hull finds the extremes of a million cells, whatever lies on it") {
    Scene s = small_scene(1000, 1000);
    s.surface.kind = Surface::Kind::spiral;
    s.time.duration = 0.15;
    for (Load::Kind kind : {Load::Kind::circular, Load::Kind::point, Load::Kind::linear}) {
        s.load.kind = kind;
        check_agree(under(s, Model::moments), under(s, Model::march), 1e-12);
    }
}

TEST_CASE("extremes are those of a march where pressure and curvature have extreme magnitudes") {
    for (const auto& [length, pressure] : std::vector<std::pair<double, double>>{
             {1, 1}, {1e153, 1}, {1e156, 1}, {1e200, 1}, {1e-170, 1e-80}, {1, 1e-90}}) {
        CAPTURE(length);
        CAPTURE(pressure);
        Scene s = small_scene(90, 50);
        s.grid.spacing = 1;
        s.material.modulus = s.material.viscosity = s.material.thickness = 1;
        s.material.curvature_length = length;
        s.surface = {.kind = Surface::Kind::spiral, .relief = 1};
        s.load.intensity = pressure;
        check_agree(under(s, Model::moments), under(s, Model::march), 1e-12);
    }
}

TEST_CASE("materials in a row give what each gives alone, and read the maps once") {
    std::vector<Material> materials;
    for (double E : {0.5, 1.0, 3.0})
        for (double eta : {0.1, 2.0}) materials.push_back({E, eta, {}, {}});
    Scene s = small_scene(64, 40);
    // In a sweep that begins with a modulus of 0 the witness's cells are others; beyond 2^200 Pa maps have a unit.
    for (const double least : {0.5, 0.0})
        for (const double intensity : {1.0, 1e-70, 1e70}) {
            s.load.intensity = intensity;
            s.surface.kind = least == 0 ? Surface::Kind::flat : Surface::Kind::wave;
            s.tolerance = 1e-6;
            materials[0].modulus = least;
            const std::vector<Result> row = run(s, materials, Device::cpu());
            REQUIRE(row.size() == 6);
            for (size_t i = 0; i < row.size(); ++i) {
                s.material = materials[i];
                const Result alone = run(s, Device::cpu());
                CHECK(row[i].predicted_error == alone.predicted_error);
                CHECK(row[i].measured_error <= row[i].predicted_error);
                for (const Trace& t : alone.traces) {
                    CHECK(row[i].trace(t.quantity).mean == t.mean);
                    CHECK(row[i].trace(t.quantity).max == t.max);
                    CHECK(row[i].trace(t.quantity).probes == t.probes);
                }
            }
        }
    materials[3].viscosity = -1;
    refuses([&] { run(s, materials, Device::cpu()); }, "viscosity = -1");
}

TEST_CASE("a model that cannot serve a scene is refused, and why; left free, the first that can is taken") {
    const auto why = [](const Scene& s) { return refusal(Error::Code::bad_input, [&] { run(s, Device::cpu()); }); };
    Scene s = small_scene(8, 8);
    CHECK(int(run(s, Device::cpu()).model) == int(Model::moments));
    s.output.fields = {{0.1, {Quantity::sa1}}};
    CHECK(int(run(s, Device::cpu()).model) == int(Model::maps));
    s.model = Model::moments;
    CHECK(why(s).find("fields") != std::string::npos);
    s.model.reset();
    s.receptors.fa2_gains = {1, 0};
    CHECK(int(run(s, Device::cpu()).model) == int(Model::march));
    s.model = Model::maps;
    CHECK(why(s).find("fa2_gains") != std::string::npos);
    s = small_scene(8, 8);
    s.material.modulus_map.edit().assign(64, 1);
    s.material.modulus_map.edit()[3] = 2;
    CHECK(int(run(s, Device::cpu()).model) == int(Model::march));
    s.model = Model::moments;
    CHECK(why(s).find("extremes of several retardation times") != std::string::npos);
    s = small_scene(8, 8);
    RunOptions options{.precision = Precision::f32};
    CHECK(int(run(s, Device::cpu(), options).model) == int(Model::march));
    CHECK(int(run(s, Device::open("vulkan")).model) == int(Model::march));
    s.model = Model::moments;
    CHECK(int(run(s, Device::open("vulkan")).model) == int(Model::moments));
}

TEST_CASE("requests that contradict each other are refused word for word") {
    Scene s = small_scene(8, 8);
    RunOptions options;
    const auto why = [&] { return refusal(Error::Code::bad_input, [&] { run(s, Device::cpu(1), options); }); };
    s.model = Model::maps;
    options.precision = Precision::f32;
    CHECK(why() == "precision = f32; not allowed here: model \"maps\" works in f64");
    options = {.check = true};
    CHECK(why() == "model = \"maps\"; not allowed here: a check compares marches");
    s.model.reset();
    options.precision = Precision::f64;
    CHECK(why() == "precision = f64; not allowed here: a check of backends compares f32");
}
