// SPDX-License-Identifier: MIT
// labels: threads long
// The planner drops and merges elements in series where no output tells the difference, and nowhere else.
#include "host/lab/planner/reduction.hpp"

#include "tests/oracle/scene_files.hpp"
#include "tests/oracle/survey.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <filesystem>

using namespace test;

namespace {

// Sites alone on elements in series, with gains by which no response is a map times a function of time.
Scene sites_on(const std::vector<KelvinVoigt>& elements, double tolerance) {
    Scene s = small_scene(9, 8);
    s.material.elements = elements;
    s.receptors.fa2_gains = {1, 0};
    s.time = {0.01, 1};
    s.load.envelope.kind = Envelope::Kind::ramp;
    s.load.envelope.rise = 0.5;
    s.sites = {{Quantity::sa1, {4, 4}}, {Quantity::sa2, {3, 4}}, {Quantity::fa1, {5, 4}}};
    s.output = {{}, {}, {}};
    s.tolerance = tolerance;
    return s;
}

struct Count {
    int springs = 0, elements = 0, dashpots = 0;
    bool operator==(const Count&) const = default;
};

// What a run computes in place of a scene's elements, which keeps the scene's promise; nothing if it computes them all.
Count reduced(const Scene& s, const std::vector<std::vector<double>>& frames = {}) {
    Scene with_surface = s;
    if (s.surface.kind != Surface::Kind::map)
        with_surface.surface = {Surface::Kind::map, {}, {}, {}, {}, maps(s).surface};
    if (frames.empty()) {
        const Map pressure = maps(s).pressure;
        with_surface.load = {};
        with_surface.load.envelope = s.load.envelope;
        with_surface.load.kind = Load::Kind::map;
        with_surface.load.map = pressure;
    }
    const Result r = run(with_surface, Device::cpu(1));
    const double off = oracle::distance(oracle::exact({with_surface, frames}), with_surface, r).value;
    CHECK(off <= s.tolerance.value_or(1e-4));
    CHECK(!(off > r.predicted_error));
    const Explanation e = explain(with_surface, Device::cpu(1));
    CHECK(e.candidates[e.chosen].reduced.size() == r.reduced.size());
    Count c;
    for (const KelvinVoigt& m : r.reduced) ++(m.viscosity == 0 ? c.springs : m.modulus == 0 ? c.dashpots : c.elements);
    return c;
}

// The greatest difference of the impulses of two runs over the greatest of the first, of each response.
double impulses_apart(const Result& a, const Result& b) {
    REQUIRE(a.impulses.size() == b.impulses.size());
    double worst = 0;
    for (Quantity q : {Quantity::fa1, Quantity::fa2}) {
        double apart = 0, greatest = 0;
        for (size_t i = 0; i < a.impulses.size(); ++i) {
            const Impulse &x = a.impulses[i], &y = b.impulses[i];
            REQUIRE(x.quantity == y.quantity);
            if (x.quantity != q) continue;
            apart = std::max({apart, std::abs(x.mean - y.mean), std::abs(x.min - y.min), std::abs(x.max - y.max)});
            greatest = std::max({greatest, std::abs(x.min), std::abs(x.max)});
        }
        if (apart > 0) worst = std::max(worst, apart / greatest);
    }
    return worst;
}

const KelvinVoigt fast{1, 1e-4}, slow{1, 1e5}, own{2, 0.2}; // retardation times of 0.1 ms, a day and 0.1 s
const Count all{};

} // namespace

TEST_CASE("an element much faster than the step becomes a spring, or part of the one there is") {
    CHECK(reduced(sites_on({fast, own}, 1e-2)) == Count{1, 1, 0});
    Scene s = sites_on({fast, own}, 1e-2);
    s.material.spring = 3;
    CHECK(reduced(s) == Count{1, 1, 0});
    CHECK(reduced(sites_on({fast, own}, 1e-6)) == all); // the ramp lags behind by more
    CHECK(reduced(sites_on({own, {1, 0.01}}, 1e-2)) == all);
}

TEST_CASE("an element much slower than the scene becomes part of a dashpot") {
    Scene s = sites_on({own, slow}, 1e-4);
    s.material.dashpot = 50;
    CHECK(reduced(s) == Count{0, 1, 1});
    s.material.elements[1].viscosity = 5; // a retardation time of the scene's length
    CHECK(reduced(s) == all);
    CHECK(reduced(sites_on({own, {1e-3, 100}, {1e-5, 300}}, 1e-4)) == Count{0, 1, 1});
}

TEST_CASE("elements of nearly one retardation time become one") {
    CHECK(reduced(sites_on({own, {2, 0.2001}, {1, 3}}, 1e-4)) == Count{0, 2, 0});
    CHECK(reduced(sites_on({own, own, own, {1, 3}}, 1e-9)) == Count{0, 2, 0});
    CHECK(reduced(sites_on({own, {2, 0.4}}, 1e-4)) == all);
}

TEST_CASE("no element is dropped that an output shows, or where nothing is promised") {
    Scene s = sites_on({fast, own}, 1e-2);
    s.sites.push_back({Quantity::fa2, {4, 4}}); // a density, which has no spring
    CHECK(reduced(s) == all);
    s.receptors.fa2 = Fa2::step_mean;
    CHECK(reduced(s) == Count{1, 1, 0});
    s.tolerance.reset(); // the default one is tighter
    CHECK(reduced(s) == all);
    s.material.elements[0].viscosity = 1e-7;
    CHECK(reduced(s) == Count{1, 1, 0});
    for (auto change : {+[](Scene& x) { x.model = Model::sites; }, +[](Scene& x) { x.precision = Precision::f64; }}) {
        Scene forced = s;
        change(forced);
        CHECK(reduced(forced) == all);
        forced.tolerance = 1e-4;
        CHECK(reduced(forced) == Count{1, 1, 0});
    }
    s.receptors.fa2_gains = {1, -1}; // a product of a map and a function of time, for which a chain costs nothing
    CHECK(reduced(s) == all);
    s = sites_on({{1, 0.02}, {1.001, 0.02}}, 1e-2);
    s.tolerance.reset();
    s.method = Method::backward_euler;
    s.load.envelope = {};
    CHECK(run(s, Device::cpu(1)).reduced.empty());
}

TEST_CASE("frames drop what changes of their greatest pressures cannot show") {
    Scene s = sites_on({{1, 1e-5}, own, {1, 1e6}}, 1e-3);
    s.material.dashpot = 50;
    std::vector<std::vector<double>> frames;
    for (int k = 0; k < 9; ++k) {
        std::vector<double>& frame = frames.emplace_back();
        for (int i = 0; i < 72; ++i) frame.push_back(0.01 * (k + std::sin(0.3 * k)) * (1 + 0.5 * std::sin(0.7 * i)));
    }
    const auto path = temporary("reduction_frames.npy");
    oracle::write_frames(path, s.grid, frames);
    s.load = {};
    s.load.kind = Load::Kind::sequence;
    s.load.path = path.string();
    s.load.interval = 0.1;
    CHECK(reduced(s, frames) == Count{1, 1, 1});
    s.sites.push_back({Quantity::fa2, {4, 4}}); // of frames it has no spring
    CHECK(reduced(s, frames) == Count{0, 2, 1});
    s.sites.pop_back();
    s.load.interval = 0.095; // frames between outputs
    CHECK(reduced(s, frames) == all);
    std::filesystem::remove(path);
}

TEST_CASE("a reduced chain keeps every tolerance and every prediction in random scenes of sites") {
    int shortened = 0, framed = 0;
    std::vector<double> ratios; // of prediction to measurement
    const unsigned scenes = night() ? 300 : 50;
    for (unsigned seed = 1; seed <= scenes; ++seed) {
        oracle::Family family(seed);
        oracle::Case c = family.next_wide_chain(true);
        c.scene.load.hold = Hold::linear; // along parabolas every element is stepped
        const oracle::Verdict v = oracle::judge(c);
        CAPTURE(seed);
        CAPTURE(oracle::text(v, c.scene));
        CHECK(v.failure == "");
        if (v.accepted) CHECK(v.kept());
        if (v.accepted) CHECK(v.below_prediction());
        shortened += v.reduced > 0;
        framed += v.reduced > 0 && !c.frames.empty();
        if (v.reduced > 0 && v.measured.value > 0) ratios.push_back(v.predicted / v.measured.value);
    }
    std::nth_element(ratios.begin(), ratios.begin() + std::ptrdiff_t(ratios.size() / 2), ratios.end());
    MESSAGE(shortened, " of ", scenes, " with fewer elements, of which ", framed,
            " under frames; prediction over measurement ", ratios[ratios.size() / 2], " in the median");
    CHECK(shortened >= int(scenes / 2));
    CHECK(framed >= int(scenes / 4));
}

TEST_CASE("a looser tolerance never leaves more elements") {
    for (unsigned seed = 1; seed <= (night() ? 60 : 20); ++seed) {
        CAPTURE(seed);
        oracle::Family family(seed);
        Scene s = family.next_wide_chain(true).scene;
        s.model = Model::sites;
        size_t before = 99;
        for (double tolerance : {1e-7, 3e-6, 1.1e-5, 1.9e-5, 2.3e-4, 1e-3, 3.1e-3, 0.07}) {
            CAPTURE(tolerance);
            s.tolerance = tolerance;
            size_t left = scene::chain_of(s.material).size();
            try {
                const Explanation e = explain(s, Device::cpu(1));
                if (!e.candidates[e.chosen].reduced.empty()) left = e.candidates[e.chosen].reduced.size();
            } catch (const Error&) { // a tolerance that cannot be met
                continue;
            }
            CHECK(left <= before);
            before = left;
        }
    }
}

TEST_CASE("the traces, probes and fields of every cell are within the bound of a reduced chain, and impulses too") {
    int shortened = 0, impulses = 0;
    const int scenes = night() ? 200 : 80;
    for (int seed = 1; seed <= scenes; ++seed) {
        CAPTURE(seed);
        oracle::Family family(seed);
        oracle::Case c = family.next_wide_chain(false);
        Scene& s = c.scene;
        s.sites.clear();
        s.output.extremes = true;
        s.receptors.fa2_gains = {1, -1};
        s.tolerance.reset();
        s.precision = Precision::f64; // by which a run predicts its error
        s.model.reset();
        const plan::PreparedRun prepared = plan::prepare_run(s);
        planner::Peaks peaks{};
        const double allowed = std::pow(10, -1.0 - seed % 5);
        const planner::Replacement r =
            planner::reduced(prepared.skin, prepared.schedule, {.error = allowed, .seconds = 1e9, .impulses = true},
                             [&]() -> const planner::Peaks& {
                                 peaks = planner::measured_peaks(prepared.skin, prepared.schedule);
                                 return peaks;
                             });
        if (r.chain == prepared.skin.materials) continue;
        const std::vector<KelvinVoigt> elements = scene::listed(r.chain);
        ++shortened;
        const oracle::Exact truth = oracle::exact(c);
        const Result whole = dermis::run(s, Device::cpu(1));
        scene::take_chain(s.material, elements);
        if (s.material.elements.empty()) { // a scene has one at least
            s.material.elements = elements;
            s.material.spring = s.material.dashpot = {};
        }
        const Result run = dermis::run(s, Device::cpu(1));
        CHECK(r.error <= allowed);
        CHECK(oracle::distance(truth, s, run).value <= r.error + run.predicted_error);
        CHECK(impulses_apart(whole, run) <= r.error + 1e-13);
        impulses += !run.impulses.empty();
    }
    MESSAGE(shortened, " of ", scenes, " scenes have a shorter chain, and ", impulses,
            " of these scenes have impulses");
    CHECK(shortened >= scenes * 3 / 5);
    CHECK(impulses >= scenes / 4);
}
