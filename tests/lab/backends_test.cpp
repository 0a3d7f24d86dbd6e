// SPDX-License-Identifier: MIT
// labels: device threads long
// One body over every backend: the CPU in float and Vulkan. How far float is from the closed forms: the suite
// `planner`.
#include "host/core/cpu/backend.hpp"
#include "host/core/embedding/check.hpp"
#include "host/core/press/device.hpp"
#include "host/lab/march/march.hpp"
#include "host/lab/march/self_test.hpp"
#include "tests/oracle/family.hpp"
#include "tests/support.hpp"

#include <cfenv>
#include <cstdlib>
#include <random>

using namespace test;

namespace {

// How two models that keep a tolerance differ in a trace, or a model with some instruction set from itself with plain
// loops, or "". A value below 2^-337 is stored as 0 (kernels/NUMERICS.md).
std::string difference_of_models(Scene s, unsigned seed) {
    s.tolerance = 1e-6;
    s.precision = Precision::f64;
    std::optional<Result> first;
    for (Model model : {Model::march, Model::maps, Model::moments}) {
        s.model = model;
        Result r;
        try {
            r = run(s, cpu_with(1, plain_loops()));
        } catch (const Error&) { // a model that cannot serve the scene
            continue;
        }
        if (!same_bits(numbers_of(run(s, cpu_with(1 + int(seed % 3), seed))), numbers_of(r)))
            return std::string("the bits of ") + name(model);
        if (!first) first = std::move(r);
        else
            for (const Trace& t : first->traces) {
                double scale = 0, off = 0;
                for (auto of : {&Trace::min, &Trace::max, &Trace::mean})
                    for (size_t n = 0; n < (t.*of).size(); ++n) {
                        scale = std::max(scale, std::abs((t.*of)[n]));
                        off = std::max(off, std::abs((t.*of)[n] - (r.trace(t.quantity).*of)[n]));
                    }
                if (!(off <= 2e-6 * scale + 0x1p-337))
                    return std::string(name(model)) + " and march: " + name(t.quantity);
            }
    }
    return "";
}

} // namespace

TEST_CASE("on every backend and on grids of any tiles every cell has the same bits, by every kind of method") {
    const Validated vulkan;
    RunOptions check{.check = true};
    std::vector<std::pair<int, int>> grids = {{1, 1}, {9, 1}, {2, 2}, {7, 5}, {65, 3}, {129, 64}, {150, 150}};
    if (night())
        grids.insert(grids.end(), {{1, 9}, {3, 3}, {31, 37}, {63, 3}, {64, 3}, {127, 4}, {128, 63}, {5, 65}, {257, 2}});
    for (auto [width, height] : grids)
        for (Method method : {Method::exact, Method::euler, Method::published}) {
            if (method == Method::published && std::min(width, height) < 2) continue;
            CAPTURE(width);
            CAPTURE(height);
            CAPTURE(name(method));
            Scene s = small_scene(width, height);
            s.method = method;
            s.output.fields = {{0.2, {Quantity::curvature}}};
            for (auto [device, precision] : {std::pair{Device::cpu(), Precision::f32},
                                             {vulkan.device(), Precision::f32},
                                             {vulkan.device(), Precision::f32_compensated}}) {
                check.precision = precision;
                const Result r = run(s, device, check);
                CHECK(r.cells_compared >= 8LL * 5 * width * height);
                CHECK(r.cells_different == 0);
            }
        }
}

// DERMIS_MARCHES=SEED repeats one scene of each kind.
TEST_CASE(
    "a march of any drawn scene has the same bits with every instruction set and on Vulkan in every cell at every "
    "output, and models that can serve it agree") {
    const Validated vulkan;
    const char* const given = std::getenv("DERMIS_MARCHES");
    unsigned first = night() ? std::random_device()() : 1, scenes = night() ? 1000 : 80, compared = 0, beyond_ring = 0;
    if (given) first = unsigned(std::stoul(given)), scenes = 1;
    MESSAGE(scenes, " scenes of each kind, seeds from ", first, " on");
    // The numbers of a march, or why it is refused: a sum of loads, or numbers beyond float.
    const auto marched = [&](const Scene& s, const Device& device, bool check) {
        std::pair<std::vector<double>, std::string> found;
        RunOptions options{.check = check};
        try {
            const Result r = run(s, device, options);
            CHECK(r.cells_different == 0);
            compared += r.cells_compared > 0;
            beyond_ring +=
                !check && device.info().vulkan && r.time.size() > 1024; // more outputs than a ring of results has
            found.first = numbers_of(r);
        } catch (const Error& e) {
            CHECK(int(e.code()) == int(Error::Code::bad_input));
            found.second = e.what();
        }
        return found;
    };
    for (auto next : {&oracle::Family::next, &oracle::Family::next_sparse})
        for (unsigned seed = first; seed != first + scenes; ++seed) {
            oracle::Family family(seed);
            Scene s = (family.*next)().scene;
            CAPTURE(seed);
            CAPTURE(family.kind());
            CHECK(difference_of_models(s, seed) == "");
            s.tolerance.reset();
            s.model = Model::march;
            if (s.sites.empty()) s.output.fields.push_back({0, {Quantity::curvature, Quantity::deformation}});
            for (Precision precision : {seed % 2 ? Precision::f32 : Precision::f32_compensated, Precision::f64}) {
                s.precision = precision;
                const auto plain = marched(s, cpu_with(1, plain_loops()), false),
                           threads = marched(s, cpu_with(2 + int(seed % 2), seed), false);
                CHECK(same_bits(threads.first, plain.first));
                CHECK(threads.second.empty() == plain.second.empty());
                if (precision == Precision::f64) continue;
                const auto device =
                    marched(s, vulkan.device(), plain.second.empty() && seed % 2); // or by the ring of results
                CHECK(same_bits(device.first, plain.first));
                CHECK(device.second.empty() == plain.second.empty());
            }
        }
    CHECK((given || 2 * compared > scenes));
    CHECK((given || beyond_ring > 0));
}

TEST_CASE("rows that nothing presses are left out, and once a skin is steady its steps, with the same bits; a jump "
          "wakes it") {
    Scene spot = small_scene(300, 90);
    spot.load.center = Cell{210, 11}, spot.load.radius = 9;
    const model::PressedBox pressed = everything(spot).schedule.pressed;
    CHECK(pressed.last_row - pressed.first_row < 30);

    const Validated vulkan; // which leaves nothing out
    Scene s = small_scene(40, 30);
    s.model = Model::march;
    s.precision = Precision::f32; // what compensated sums carry goes on changing
    s.material.viscosity = 0.02;
    s.receptors.sa2_adaptation = 0.05;
    s.time = {0.01, 6};
    s.load.envelope.kind = Envelope::Kind::pulse;
    s.load.envelope.length = 2;
    s.load.envelope.period = 3;
    s.output.fields = {{1.9, {Quantity::sa1, Quantity::sa2}}, {2.505, {Quantity::fa1}}, {5.9, {Quantity::strain}}};
    RunOptions check{.check = true};
    const Result r = run(s, Device::cpu(), check);
    CHECK(r.left_out > 200);
    CHECK(r.left_out < r.steps);
    CHECK(r.cells_compared > 600LL * 5 * 1200);
    CHECK(r.cells_different == 0);
    const Result device = run(s, vulkan.device());
    for (size_t i = 0; i < r.fields.size(); ++i) CHECK(device.fields[i].values == r.fields[i].values);
    s.receptors.sa2_adaptation.reset(); // the plain integral of a held load never ends
    s.load.envelope = {};
    CHECK(run(s, Device::cpu()).left_out == 0);
    s.output.traces = {Quantity::fa1, Quantity::fa2}; // unless nobody asks
    s.output.fields.clear();
    const Result two = run(s, Device::cpu(), check);
    CHECK(two.left_out > 200);
    CHECK(two.cells_different == 0);
}

TEST_CASE("a check takes any NaN for any other: the sign of one is no difference") {
    const Validated vulkan;
    Scene s;
    s.grid = {16, 3, {}};
    s.surface.kind = Surface::Kind::wave;
    s.material.modulus = 1000;
    s.method = Method::rk2;
    s.allow_unstable = true;
    s.time = {0.01, 0.9};
    for (double at : {0.5, 0.89})
        s.output.fields.push_back({at, {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2}});
    RunOptions check{.precision = Precision::f32, .check = true};
    const Result r = run(s, vulkan.device(), check);
    size_t nans = 0;
    for (const Field& f : r.fields)
        for (double v : f.values) nans += std::isnan(v);
    CHECK(nans > 0);
    CHECK(r.cells_different == 0);
}

TEST_CASE("what overflows is refused in every model: means, extremes, probes and impulses") {
    Scene s;
    s.grid = {2, 1, {}};
    s.material.viscosity_map = {1e-308, 1e-308};
    s.load.envelope.kind = Envelope::Kind::pulse;
    s.load.envelope.length = 0.1;
    s.load.envelope.period = 0.2;
    s.time = {0.05, 0.5};
    RunOptions f64;
    f64.precision = Precision::f64;
    for (Model model : {Model::moments, Model::maps, Model::march})
        for (bool extremes : {true, false}) {
            CAPTURE(name(model));
            CAPTURE(extremes);
            s.model = model;
            s.output.extremes = extremes;
            s.output.probes = {{0, 0}, {1, 0}};
            s.load.intensity = 1;
            for (const Impulse& i : run(s, Device::cpu(), f64).impulses)
                for (double v : {i.mean, extremes ? i.min : 0, extremes ? i.max : 0, i.probes[0], i.probes[1]})
                    CHECK(std::isfinite(v));
            s.load.intensity = 1.5;
            const std::string message = refusal(Error::Code::bad_input, [&] { run(s, Device::cpu(), f64); });
            CHECK(message.find("fa2 overflows at t = ") == 0);
        }
}

TEST_CASE("curvature: C is 0 on a level skin, and on a paraboloid it is its Laplacian whatever the offset") {
    Scene s = small_scene(30, 20);
    s.model = Model::march;
    s.grid.spacing = 2e-3;
    s.surface.kind = Surface::Kind::map;
    s.surface.relief = 1;
    s.material.modulus = 1.54;
    s.material.viscosity = 1;
    s.material.thickness = 0;
    s.material.curvature_length = 1;
    s.output.fields = {{0.2, {Quantity::curvature}}};
    for (double offset : {0.0, 1e4}) {
        s.surface.map.edit().assign(600, offset);
        const std::vector<double> level = run(s, Device::cpu()).fields[0].values;
        for (double C : level) REQUIRE(C == 0);
        for (int y = 0; y < 20; ++y)
            for (int x = 0; x < 30; ++x) s.surface.map.edit()[y * 30 + x] = offset + (3 * x * x + 5 * y * y) * 1024.0;
        for (Stencil stencil : {Stencil::five_point, Stencil::fourth_order, published_stencil}) {
            s.stencil = stencil;
            const std::vector<double> C = run(s, Device::cpu()).fields[0].values;
            CHECK(C[10 * 30 + 15] == relative(16 * 1024.0 / 4e-6, 1e-6));
        }
    }
}

TEST_CASE("a scene is read, receptors are drawn, chains relax and reports are made alike in every rounding mode") {
    const auto numbers = [] {
        const Scene s = Scene::from_string("[grid]\nwidth = 20\nheight = 10\nspacing = 0.1e-3\n[time]\nstep = 0.1\n"
                                           "duration = 0.3\n[surface]\nrelief = 5e-5\n[material]\nmodulus = 1.1e-3\n"
                                           "viscosity = 0.7\nthickness = 1e-3\ncurvature_length = 1e-5\n");
        std::vector<double> all = {*s.grid.spacing, s.time.step, s.time.duration, *s.material.modulus,
                                   *s.material.viscosity};
        for (const KelvinVoigt& e : fingertip().material.elements) all.insert(all.end(), {e.modulus, e.viscosity});
        for (const Site& site : population(s.grid, {}, 3))
            all.insert(all.end(), {1.0 * site.cell.x, 1.0 * site.cell.y});
        const Relaxation r = relaxation_of(fingertip().material.elements);
        all.insert(all.end(), r.moduli.begin(), r.moduli.end());
        const Report report = dermis::report(s, run(s));
        for (const Figure& f : report.retardation_times) all.push_back(f.value);
        all.insert(all.end(), {report.strain.value, report.indentation.value, report.gain.value});
        return all;
    };
    const std::vector<double> expected = numbers();
    for (int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
        CAPTURE(mode);
        std::fesetround(mode);
        const std::vector<double> found = numbers();
        std::fesetround(FE_TONEAREST);
        CHECK(found == expected);
    }
}

TEST_CASE("a caller's rounding mode changes nothing") {
    const Validated vulkan;
    Scene s = small_scene(40, 30);
    s.model = Model::march;
    const Result before = run(s, Device::cpu());
    std::fesetround(FE_UPWARD);
    const bool exact = self_test(*vulkan.device().impl().backend).exact();
    RunOptions check{.check = true};
    const Result after = run(s, vulkan.device(), check);
    const Result fresh = run(s, Device::open("vulkan"));
    const bool kept = std::fegetround() == FE_UPWARD;
    std::fesetround(FE_TONEAREST);
    CHECK(kept);
    CHECK(exact);
    CHECK(after.cells_different == 0);
    for (const Result* r : {&after, &fresh})
        for (const Trace& t : before.traces) {
            CHECK(r->trace(t.quantity).mean == t.mean);
            CHECK(r->trace(t.quantity).max == t.max);
        }
}

// What `dermis check` prints: the loops of a run that are wrong alone, each in one of its uses.
TEST_CASE("a device's test finds wrong means, wrong double precision and a wrong FA2 without gains") {
    const auto exact = [](auto change) {
        simd::Isa isa = simd::best();
        change(isa);
        cpu::CpuBackend backend(1, isa);
        return self_test(backend).exact();
    };
    CHECK(exact([](simd::Isa&) {}));
    CHECK_FALSE(exact([](simd::Isa& isa) {
        isa.in_f32.join_tiles = [](const f32::Summary* tiles, int count, simd::JoinedTiles<f32>& joined) {
            simd::plain.in_f32.join_tiles(tiles, count, joined);
            joined.sum.sum -= joined.sum.sum / 1024;
        };
    }));
    CHECK_FALSE(exact([](simd::Isa& isa) {
        isa.in_f32.join_tiles = [](const f32::Summary* tiles, int count, simd::JoinedTiles<f32>& joined) {
            simd::plain.in_f32.join_tiles(tiles, count, joined);
            joined.high = joined.low;
        };
    }));
    CHECK_FALSE(exact([](simd::Isa& isa) {
        isa.in_f64.join_tiles = [](const f64::Summary* tiles, int count, simd::JoinedTiles<f64>& joined) {
            simd::plain.in_f64.join_tiles(tiles, count, joined);
            joined.sum.sum *= 1 + 1e-9;
        };
    }));
    CHECK_FALSE(exact([](simd::Isa& isa) {
        isa.in_f64.advance = [](const simd::AdvanceArguments<f64>& a, const f64::Constants& c) {
            const int changed = simd::plain.in_f64.advance(a, c);
            a.to.value[simd::sum_strain][0] *= 1 + 0x1p-50;
            return changed;
        };
    }));
    CHECK_FALSE(exact([](simd::Isa& isa) {
        isa.in_f32.respond = [](const simd::RespondArguments<f32>& r, const f32::Constants& c) {
            f32::Constants wrong = c;
            if (c.gain_plus == 1 && c.gain_minus == -1) wrong.bend *= 2;
            simd::plain.in_f32.respond(r, wrong);
        };
    }));
}

TEST_CASE("the test of a march steps its very variant: what is wrong along parabolas alone is found along them alone") {
    simd::Isa isa = simd::best();
    isa.in_f32.advance = [](const simd::AdvanceArguments<f32>& a, const f32::Constants& c) {
        const int changed = simd::best().in_f32.advance(a, c);
        if (a.to.previous) a.to.previous[0] += 1;
        return changed;
    };
    cpu::CpuBackend right(1), wrong(1, isa);
    for (const model::Chain& chain : {model::Chain{}, {.length = 3, .spring = true}}) {
        model::Variant v{.compensated = true,
                         .materials = true,
                         .framed = true,
                         .parabolic = true,
                         .chain = chain,
                         .keeps_strain = chain.length > 1,
                         .wanted = {true, true, false, false, true}};
        CHECK(marches_exactly(right, v));
        CHECK_FALSE(marches_exactly(wrong, v));
        v.parabolic = false;
        CHECK(marches_exactly(wrong, v));
    }
    const Validated vulkan;
    CHECK(vulkan::exact(*vulkan.device().impl().backend,
                        {.framed = true, .parabolic = true, .wanted = {true, true, true, true, true}}));
}
