// SPDX-License-Identifier: MIT
// What the planner promises is kept: on random scenes, what is measured stays below what was predicted.
#include "host/device.hpp"
#include "host/planner/bound.hpp"
#include "host/reduced/moments.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

using namespace test;

namespace {

const std::vector<Quantity> all = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};

class Family {
  public:
    explicit Family(unsigned seed) : random_(seed) {
        path_ = std::filesystem::temp_directory_path() / ("dermis_planner_" + std::to_string(getpid()) + ".npy");
    }
    ~Family() { std::filesystem::remove(path_); }

    Scene next() {
        Scene s;
        s.grid = {5 + below(20), 3 + below(14), {}};
        s.surface.kind = Surface::Kind(below(3));
        s.surface.ridges = s.grid.width / std::pow(10, real(0.5, 2.7)); // ridges of 3 to 500 cells
        s.surface.noise = below(2) ? 0 : 0.5;
        if (s.surface.kind == Surface::Kind::flat) s.surface.ridges.reset(), s.surface.noise.reset();
        if (below(4) == 0) { // far from 0
            Scene shape = s;
            s.surface = {Surface::Kind::map, {}, {}, {}, {}, maps(shape).surface};
            for (double& v : s.surface.map.edit()) v += 1e4;
        }
        s.time.step = std::pow(10, real(-4, 0));
        s.time.duration = s.time.step * (20 + below(300));
        const double E = std::pow(10, real(-2, 2)), z = std::pow(10, real(-6, 4));
        s.material.modulus = E;
        s.material.viscosity = E * s.time.step / z;
        const int cells = s.grid.width * s.grid.height;
        const int kind = below(4); // uniform, uniform, classes, per cell
        for (int i = 0; kind > 1 && i < cells; ++i) {
            const double decades = kind == 2 ? i % 3 : real(-1, 1);
            s.material.modulus_map.edit().push_back(E * std::pow(10, decades));
            s.material.viscosity_map.edit().push_back(s.material.viscosity * std::pow(10, -decades * real(0, 1)));
        }
        s.load.kind = Load::Kind(below(3)); // circular, point and linear maps: kinks
        s.load.intensity = std::pow(10, real(-3, 3)) * (below(2) ? 1 : -1) * E * 0.01;
        Envelope& e = s.load.envelope;
        e.kind = Envelope::Kind(below(5));
        const double T = s.time.duration;
        if (e.kind != Envelope::Kind::sine && e.kind != Envelope::Kind::table) e.start = real(0, 0.3) * T;
        e.rise = real(0.1, 0.6) * T;
        e.frequency = real(0.5, 10) / T;
        e.phase = real(0, 6);
        e.mean = below(2);
        e.length = real(0.05, 0.1) * T;
        e.period = real(0.15, 0.3) * T;
        if (e.kind == Envelope::Kind::table) { // telegraph, or reversing
            const bool jumps = below(2);
            double sign = 1;
            for (double t = real(0, 0.1) * T; t < T; t += real(0.05, 0.2) * T, sign = -sign) {
                if (jumps && !e.times.empty()) e.times.push_back(t), e.values.push_back(e.values.back());
                e.times.push_back(t);
                e.values.push_back(sign * real(0.5, 1));
            }
        }
        s.receptors.fa2 = Fa2(below(2));
        if (below(3) == 0) s.receptors.sa2_adaptation = T * real(0.05, 2);
        if (below(3) == 0) s.receptors.fa2_gains = {1, below(2) ? 0.0 : 0.4};
        if (below(10) == 0) {
            s.method = Method(1 + below(6));
            s.allow_unstable = true;
            s.receptors.sa2_adaptation.reset();
        } else if (below(6) == 0) {
            frames(s);
        }
        return s;
    }

  private:
    int below(int n) { return int(random_() % unsigned(n)); }
    double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

    void frames(Scene& s) {
        const int count = 5 + below(20), cells = s.grid.width * s.grid.height;
        std::ofstream out(path_, std::ios::binary);
        out << npy_header("<f8", "(" + std::to_string(count) + ", " + std::to_string(s.grid.height) + ", " +
                                     std::to_string(s.grid.width) + ")");
        const std::vector<double> map = maps(s).pressure;
        for (int k = 0; k < count; ++k)
            for (int i = 0; i < cells; ++i) {
                const double p = map[i] * real(0, 1);
                out.write(reinterpret_cast<const char*>(&p), 8);
            }
        s.load.kind = Load::Kind::sequence;
        s.load.path = path_.string();
        s.load.interval = s.time.step * (1 + below(8));
        s.load.envelope = {};
        s.load.intensity = 1;
    }

    std::mt19937 random_;
    std::filesystem::path path_;
};

// Every output of a plan's steps, one after another.
using Outputs = std::vector<std::vector<double>>;
Outputs outputs_of(const plan::PreparedRun& run, plan::Stepper& stepper) {
    Outputs outputs(all.size());
    std::vector<std::vector<double>> fields;
    plan::FrameFeed feed(run.schedule);
    plan::Timeline timeline(run.schedule, run.skin);
    for (plan::Step step; timeline.next(step);) {
        feed.before(step, [&](const std::vector<double>& frame) { stepper.frame(frame); });
        stepper.press(step);
        if (step.trace < 0) continue;
        stepper.read(all, fields);
        for (size_t q = 0; q < all.size(); ++q) outputs[q].insert(outputs[q].end(), fields[q].begin(), fields[q].end());
    }
    return outputs;
}

Outputs marched(const Scene& s, Precision precision) {
    const plan::PreparedRun run = everything(s);
    return outputs_of(run, *march(Device::cpu(1), run.skin, run.schedule, precision, [](auto&, auto&) {}));
}

bool is_separable(const Scene& s) {
    const plan::PreparedRun run = everything(s);
    return why_not_separable(run.skin, run.schedule).empty();
}

Outputs in_closed_form(const Scene& s) {
    const plan::PreparedRun run = everything(s);
    const auto moments = reduced::moments_of(run.skin, run.schedule, false, 0);
    return outputs_of(run, *reduced::separable(run.skin, run.schedule, moments, false, [](auto&, auto&) {}));
}

double median(std::vector<double> v) {
    REQUIRE(!v.empty());
    std::nth_element(v.begin(), v.begin() + v.size() / 2, v.end());
    return v[v.size() / 2];
}

} // namespace

TEST_CASE("on 1000 random scenes and four tolerances, what the planner takes stays within the tolerance") {
    Family family(2026);
    const double tolerances[] = {1e-2, 1e-4, 1e-6, 1e-9};
    std::vector<double> ratios; // of bound to measured
    int uniform = 0, near_cheapest = 0, met[4] = {};
    for (int i = 0; i < 1000; ++i) {
        CAPTURE(i);
        Scene s = family.next();
        const bool closed = is_separable(s);
        Scene exact = s;
        exact.method = Method::exact;
        const bool exactly = is_separable(exact);
        const Outputs truth =
            exactly ? in_closed_form(exact) : marched(exact, Precision::f64); // no flush, if it can be
        std::map<std::pair<Model, Precision>, double> measured;
        const auto measure = [&](Model m, Precision p, const Outputs& outputs) {
            double worst = 0;
            for (size_t q = 0; q < all.size(); ++q) worst = std::max(worst, difference(outputs[q], truth[q]));
            measured[{m, p}] = worst;
        };
        for (Precision p : {Precision::f32, Precision::f32_compensated, Precision::f64})
            measure(Model::march, p, marched(s, p));
        if (closed) measure(Model::moments, Precision::f64, in_closed_form(s));
        s.output.traces = all;
        double seconds_before = 0;
        for (int t = 0; t < 4; ++t) {
            CAPTURE(tolerances[t]);
            s.tolerance = tolerances[t];
            try {
                const Explanation e = explain(s, Device::cpu());
                const Candidate& c = e.candidates[e.chosen];
                REQUIRE(measured.count({c.model, c.precision}));
                const double error = measured[{c.model, c.precision}];
                CAPTURE(int(c.model));
                CAPTURE(int(c.precision));
                CAPTURE(error);
                CHECK(error <= tolerances[t]);
                CHECK(error <= c.error + (exactly ? 0 : 1e-12)); // the truth's own
                CHECK(c.seconds >= seconds_before);              // a tighter tolerance is never cheaper
                seconds_before = c.seconds;
                ++met[t];
                if (t == 0) {
                    for (const Candidate& other : e.candidates)
                        if (measured.count({other.model, other.precision}) && other.precision != Precision::f64 &&
                            s.method == Method::exact && std::isfinite(other.error)) {
                            const double off = measured[{other.model, other.precision}];
                            if (off > 0) ratios.push_back(other.error / off);
                        }
                }
                if (s.material.modulus_map.empty()) {
                    double cheapest = INFINITY;
                    for (const Candidate& other : e.candidates)
                        if (measured.count({other.model, other.precision}) &&
                            measured[{other.model, other.precision}] <= tolerances[t])
                            cheapest = std::min(cheapest, other.seconds);
                    ++uniform;
                    near_cheapest += c.seconds <= 1.5 * cheapest;
                }
            } catch (const Error& e) {
                CHECK(e.parameter() == "tolerance");
                CHECK(std::string(e.what()).find("attainable") != std::string::npos);
                seconds_before = INFINITY; // nor is it to be had again
            }
        }
    }
    MESSAGE("bound over measured, median: ", median(ratios));
    MESSAGE("within 1.5 of the cheapest: ", near_cheapest, " of ", uniform);
    MESSAGE("met: ", met[0], " ", met[1], " ", met[2], " ", met[3]);
    CHECK(median(ratios) <= 30);
    CHECK(near_cheapest >= 0.9 * uniform);
    CHECK(met[0] >= 800); // the others: baselines, and FA2 as the small difference of two large rates
}

TEST_CASE("a tolerance that cannot be met is refused and says what can; a default does not bind what is forced") {
    Scene s = small_scene(20, 20);
    s.method = Method::euler;
    s.tolerance = 1e-6;
    const auto refused = [](const Scene& scene, const RunOptions& options = {}) {
        return refusal(Error::Code::bad_input, [&] { run(scene, Device::cpu(), options); });
    };
    const std::string euler = refused(s);
    CHECK(euler.find("tolerance = 1e-06; attainable here: 0.") != std::string::npos);
    s.tolerance.reset();
    CHECK(run(s, Device::cpu()).time.size() == 8); // and `explain` says how far off
    const Explanation e = explain(s, Device::cpu());
    CHECK(e.candidates[e.chosen].error > 1e-3);
    CHECK_FALSE(e.binding);
    s.method = Method::exact;
    s.tolerance = 1e-9;
    RunOptions f32;
    f32.precision = Precision::f32;
    CHECK(refused(s, f32).find("attainable here") != std::string::npos);
    CHECK(int(run(s, Device::cpu()).model) == int(Model::moments));
    s.receptors.fa2_gains = {1, 0}; // has to march
    const Result r = run(s, Device::cpu());
    CHECK(int(r.model) == int(Model::march));
    CHECK(int(r.precision) == int(Precision::f64));
    CHECK(refusal(Error::Code::bad_input, [&] {
              run(s, Device::open("vulkan"));
          }).find("f32-compensated on llvmpipe") != std::string::npos);
    s.tolerance = 1e-2;
    CHECK(int(run(s, Device::cpu()).precision) == int(Precision::f32));
    s.tolerance = -1;
    CHECK(refused(s).find("tolerance = -1") != std::string::npos);
    s.tolerance = 1e-3;
    s.model = Model::moments;
    CHECK(refused(s).find("fa2_gains") != std::string::npos);
}

TEST_CASE("what is explained is what is run") {
    Family family(7);
    for (int i = 0; i < 40; ++i) {
        const Scene s = family.next();
        const Explanation e = explain(s, Device::cpu());
        const Result r = run(s, Device::cpu());
        CHECK(int(r.model) == int(e.candidates[e.chosen].model));
        CHECK(int(r.precision) == int(e.candidates[e.chosen].precision));
        for (size_t c = 0; c < e.candidates.size(); ++c) CHECK(e.candidates[c].refused.empty() == (c == e.chosen));
    }
}
