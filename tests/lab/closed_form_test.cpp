// SPDX-License-Identifier: MIT
// labels: long
// The oracle is held against numbers computed elsewhere, the equations integrated in small steps, and itself in more
// bits.
#include "tests/oracle/family.hpp"

#include "host/core/description/description.hpp"
#include "tests/oracle/closed_form.hpp"
#include "tests/oracle/oracle.hpp"
#include "tests/oracle/scene_files.hpp"
#include "tests/support.hpp"

using namespace test;

namespace {

oracle::Pressure straight(std::initializer_list<std::array<double, 3>> knots) {
    oracle::Pressure p;
    for (auto [time, left, right] : knots) p.knots.push_back({time, left, right});
    return p;
}

// Decimal fractions, each the quotient of two whole numbers, so that a time is not the nearest double.
oracle::Real ratio(double a, double b) { return oracle::Real(a) / oracle::Real(b); }

struct Vector {
    double ten_thousandths; // of a second
    std::array<long double, 4> values;
};

// The responses of a chain are the sums of those of its elements.
void check_chain(const oracle::Pressure& pressure, const std::vector<Vector>& vectors) {
    const oracle::Element chain[] = {{4e6, 0}, {2e6, 8e3}, {1e6, 7e4}, {5e5, 7e5}, {0, 2e7}};
    for (const Vector& v : vectors) {
        CAPTURE(v.ten_thousandths);
        const std::vector<oracle::Instant> instants = {{ratio(v.ten_thousandths, 10000)}};
        const oracle::PreparedPressure prepared(pressure, instants);
        std::array<oracle::Real, 4> sum;
        for (const oracle::Element& e : chain) {
            const oracle::Responses r = prepared.responses(e, {})[0];
            sum[0] += r.strain;
            sum[1] += r.integral;
            sum[2] += r.rate;
            sum[3] += r.acceleration;
        }
        for (size_t i = 0; i < 4; ++i)
            CHECK(std::abs(sum[i].rounded() - v.values[i]) <= 1e-16L * std::abs(v.values[i]));
    }
}

// eps, and its integral or y of tau_a*y' = -y + tau_a*eps, by Runge-Kutta steps of the equations.
struct State {
    long double strain = 0, integral = 0;
};

template <class Load>
State integrated(const oracle::Element& m, const std::optional<double>& adaptation, const Load& load, double to,
                 const std::vector<double>& breaks) {
    State s;
    std::vector<double> ends = breaks;
    ends.push_back(to);
    std::sort(ends.begin(), ends.end());
    long double from = 0;
    for (double end : ends) {
        if (end <= from || end > to) continue;
        const int steps = 4000;
        const long double h = (end - from) / steps;
        const auto slope = [&](long double t, const State& x) {
            // a time inside the piece, so that the pressure at its ends is the piece's own
            const long double inside = std::clamp(t, from + h * 1e-9L, (long double)end - h * 1e-9L);
            return State{(load(inside) - m.modulus * x.strain) / m.viscosity,
                         x.strain - (adaptation ? x.integral / *adaptation : 0)};
        };
        const auto ahead = [](const State& x, const State& d, long double by) {
            return State{x.strain + by * d.strain, x.integral + by * d.integral};
        };
        for (int i = 0; i < steps; ++i) {
            const long double t = from + i * h;
            const State a = slope(t, s), b = slope(t + h / 2, ahead(s, a, h / 2)),
                        c = slope(t + h / 2, ahead(s, b, h / 2)), d = slope(t + h, ahead(s, c, h));
            s = ahead(ahead(ahead(ahead(s, a, h / 6), b, h / 3), c, h / 3), d, h / 6);
        }
        from = end;
    }
    return s;
}

} // namespace

TEST_CASE("the closed forms of a chain's elements sum to numbers known to 17 digits: step, ramp and sine") {
    oracle::Real::bits = 400;
    check_chain(
        straight({{0, 0, 1}}),
        {{10, {3.762618274578382e-7L, 3.1544964648775754e-10L, 1.1291073273085571e-4L, -2.4539731057144471e-2L}},
         {100, {8.5681441607596831e-7L, 6.4193817864214467e-9L, 2.4112998527891302e-5L, -2.7430832095911917e-3L}},
         {1000, {1.6532234041432347e-6L, 1.2700135572221583e-7L, 4.8036759219099654e-6L, -4.9858439278956595e-5L}},
         {10000, {2.8209160560111428e-6L, 2.2737166905007153e-6L, 7.4935415472351798e-7L, -4.9965983117055346e-7L}},
         {100000, {4.2484190193537601e-6L, 3.7130213372904736e-5L, 5.1129271890171381e-8L, -8.0662277869384334e-10L}}});
    oracle::Pressure ramp = straight({{0, 0, 0}});
    ramp.knots.push_back({ratio(1, 20), 1, 1});
    check_chain(
        ramp,
        {{100, {1.2838763572842893e-7L, 5.4775230486285699e-10L, 1.7136288321519366e-5L, 4.8225997055782603e-4L}},
         {500, {1.031901357298585e-6L, 2.2545711306674149e-8L, 2.6662491767434414e-5L, 1.6844738920269881e-4L}},
         {1000, {1.5081257571457315e-6L, 8.7973224993311412e-8L, 6.40197631543028e-6L, -7.2373870764499497e-5L}},
         {10000, {2.80197212779063e-6L, 2.2035086411956133e-6L, 7.6199657434177507e-7L, -5.0874583747999328e-7L}},
         {100000, {4.2471404484412898e-6L, 3.7024024205515528e-5L, 5.1149679684792996e-8L, -8.2119977485214005e-10L}}});
    oracle::Pressure sine = straight({{0, 0, 0}});
    sine.waves = {{1, oracle::Real(500) * oracle::Real::pi(), 0}};
    check_chain(
        sine,
        {{5, {2.0205629989725789e-7L, 5.0958928633871802e-11L, 3.7159074663977233e-4L, -3.006741085014077e-1L}},
         {10, {3.3278477994647842e-7L, 1.8991454595819232e-10L, 1.2243533682894187e-4L, -6.4375376796448082e-1L}},
         {101, {6.0533811948200962e-8L, 7.214100983645855e-10L, -4.3036084860228752e-4L, -1.119104523849116e-1L}},
         {1003, {4.4097863712178041e-8L, 8.7921010561634309e-10L, 4.2977342823206678e-4L, -1.0128496682076634e-1L}},
         {10007, {1.9451771898733421e-7L, 1.6706200107730913e-9L, 3.0981869192869423e-4L, -4.7877670036479321e-1L}}});
}

TEST_CASE("the closed forms satisfy the equations, integrated in small steps") {
    oracle::Real::bits = 400;
    const oracle::Pressure table = straight({{0.1, 0, 0.5}, {0.4, 1.5, -1}, {0.75, 2, 2}});
    oracle::Pressure sine = straight({{0, 0, 0.25}});
    sine.waves = {{0.75, 19, 0.4}};
    const auto of_table = [](long double t) {
        return t < 0.1 ? 0 : t < 0.4 ? 0.5L + (t - 0.1) / 0.3L : t < 0.75 ? -1 + 3 * (t - 0.4) / 0.35L : 2.0L;
    };
    const auto of_sine = [](long double t) { return 0.25L + 0.75L * std::sin(19 * t + 0.4L); };
    for (oracle::Element m : {oracle::Element{1.54, 1}, {0, 2}, {30, 0.75}})
        for (std::optional<double> adaptation : {std::optional<double>(), {0.3}, {0.025}, {2.0}})
            for (double t : {0.3, 0.6, 2.0}) {
                CAPTURE(m.modulus);
                CAPTURE(adaptation.value_or(0));
                CAPTURE(t);
                const std::vector<oracle::Instant> instants = {{t}};
                const auto check = [&](const oracle::Pressure& p, const auto& load, std::vector<double> breaks) {
                    const oracle::Responses r = oracle::PreparedPressure(p, instants).responses(m, adaptation)[0];
                    // The steps are off by up to 2e-13, which stays where a value decays, and the rate by E/eta times
                    // that.
                    const State s = integrated(m, adaptation, load, t, breaks);
                    CHECK(double(r.strain.rounded()) == absolute(double(s.strain), 1e-12));
                    CHECK(double(r.integral.rounded()) == absolute(double(s.integral), 1e-12));
                    const long double before = t * (1 - 1e-15L),
                                      rate = (load(before) - m.modulus * s.strain) / m.viscosity;
                    CHECK(double(r.rate.rounded()) == absolute(double(rate), 5e-11));
                };
                check(table, of_table, {0.1, 0.4, 0.75});
                check(sine, of_sine, {});
            }
}

TEST_CASE("the exact scene is the straight reading of the model at every edge and stencil") {
    for (bool periodic : {false, true})
        for (bool fourth : {false, true}) {
            oracle::Case c;
            Scene& s = c.scene;
            s.grid = {9, 6, 2e-4};
            s.surface = {Surface::Kind::map, {}, {}, {}, 1.0, {}};
            s.load.kind = Load::Kind::map;
            for (int i = 0; i < 54; ++i) {
                s.surface.map.edit().push_back(1e-5 * std::sin(1.7 * i));
                s.load.map.edit().push_back(std::cos(0.3 * i));
            }
            s.material = {1.54, 0.7, 3e-4, 1e-4, {}, {}};
            s.stencil = fourth ? Stencil::fourth_order : Stencil::five_point;
            s.edges = periodic ? Edges::periodic : Edges::mirror;
            s.time = {0.05, 0.4};
            const auto outside = periodic ? oracle::Outside::periodic : oracle::Outside::mirror;
            const double at = 0.31;
            s.output.fields = {{at, s.output.traces}, {at, {Quantity::curvature, Quantity::deformation}}};
            const oracle::Fields f =
                oracle::model({9, 6, 2e-4, 3e-4, 1e-4, 1.54, 0.7, outside, fourth}, s.surface.map, s.load.map, at);
            const oracle::Exact e = oracle::exact(c);
            const std::vector<double>* expected[] = {&f.strain, &f.sa1,       &f.sa2,        &f.fa1,
                                                     &f.fa2,    &f.curvature, &f.deformation};
            for (size_t q = 0; q < std::size(expected); ++q)
                CHECK(difference(std::vector<double>(e.fields[q].values.begin(), e.fields[q].values.end()),
                                 *expected[q]) < 1e-13);
        }
}

TEST_CASE("more bits change nothing in the exact outputs of random scenes") {
    for (unsigned seed = 1; seed <= 150; ++seed) {
        CAPTURE(seed);
        oracle::Family family(seed);
        const oracle::Case c = family.next();
        const oracle::Exact less = oracle::exact(c), more = oracle::exact(c, 640);
        const auto same = [&](const oracle::Numbers& a, const oracle::Numbers& b, Quantity q) {
            const long double largest = more.largest[size_t(q)] * (1 + std::abs(c.scene.receptors.fa2_gains[0]) +
                                                                   std::abs(c.scene.receptors.fa2_gains[1]));
            for (size_t i = 0; i < b.size(); ++i) REQUIRE(std::abs(a[i] - b[i]) <= 1e-18L * largest);
        };
        for (size_t t = 0; t < more.traces.size(); ++t) {
            same(less.traces[t].mean, more.traces[t].mean, c.scene.output.traces[t]);
            same(less.traces[t].min, more.traces[t].min, c.scene.output.traces[t]);
            same(less.traces[t].max, more.traces[t].max, c.scene.output.traces[t]);
        }
        for (size_t f = 0; f < more.fields.size(); ++f)
            same(less.fields[f].values, more.fields[f].values, more.fields[f].quantity);
    }
}

TEST_CASE(
    "a sine under a window has the numbers of the exact scene, fast or slow beside a material and its adaptation") {
    for (double frequency : {0.01, 0.3, 40.0})
        for (Fa2 fa2 : {Fa2::point, Fa2::step_mean}) {
            CAPTURE(frequency);
            Scene s = small_scene(4, 3);
            s.receptors.sa2_adaptation = 0.5, s.receptors.fa2 = fa2;
            s.precision = Precision::f64;
            s.output.traces = {Quantity::strain, Quantity::sa1, Quantity::sa2, Quantity::fa1, Quantity::fa2};
            s.load.envelope = {.kind = Envelope::Kind::sine, .frequency = frequency, .phase = 0.4};
            s.load.envelope.window = {.start = 0.03, .rise = 0.2, .until = 0.28, .fall = 0.07};
            const oracle::Case c = oracle::with_maps(s);
            CHECK(oracle::distance(oracle::exact(c), c.scene, run(c.scene, Device::cpu(1))).value < 1e-11);
        }
}

TEST_CASE("impulses have the weights of the exact scene") {
    int compared = 0;
    for (unsigned seed = 1; seed <= 300; ++seed) {
        CAPTURE(seed);
        oracle::Family family(seed);
        oracle::Case c = family.next();
        if (c.scene.method != Method::exact || scene::has_depth(c.scene.receptors)) continue; // a march spreads to 1e-3
        c.scene.tolerance.reset();
        c.scene.precision = Precision::f64;
        c.scene.model.reset(); // a sum of loads has no march
        if (c.scene.more_loads.empty())
            c.scene.model = Model::march; // exact, also where retardation times are nearly one
        c.scene.output.traces = {Quantity::fa1, Quantity::fa2};
        c.scene.output.extremes = true;
        Result r;
        try {
            r = run(c.scene, Device::cpu(1));
        } catch (const Error&) {
            continue; // FA2 of a sequence on an elastic skin
        }
        if (r.impulses.empty()) continue; // receptors without further cells
        const oracle::Exact e = oracle::exact(c);
        REQUIRE(r.impulses.size() == e.impulses.size());
        for (size_t i = 0; i < r.impulses.size(); ++i) {
            const oracle::Numbers& weights = e.impulses[i].values;
            long double largest = 0, total = 0;
            for (long double w : weights) {
                largest = std::max(largest, std::abs(w));
                total += w;
            }
            if (largest < 1e-18L) continue;
            const auto [least, greatest] = std::minmax_element(weights.begin(), weights.end());
            CHECK(int(r.impulses[i].quantity) == int(e.impulses[i].quantity));
            CHECK(std::abs(r.impulses[i].time - e.impulses[i].time) <= 1e-14L * e.impulses[i].time);
            CHECK(std::abs(r.impulses[i].min - *least) <= 1e-9L * largest);
            CHECK(std::abs(r.impulses[i].max - *greatest) <= 1e-9L * largest);
            CHECK(std::abs(r.impulses[i].mean - total / (long double)weights.size()) <= 1e-9L * largest);
            ++compared;
        }
    }
    CHECK(compared >= 200);
}
