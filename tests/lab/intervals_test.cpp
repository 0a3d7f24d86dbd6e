// SPDX-License-Identifier: MIT
// Whether a fit finds what is there, and what it says about itself: residuals, intervals, and curves that no chain has.
#include "dermis/fit.hpp"
#include "host/lab/fit/problem.hpp"
#include "tests/support.hpp"

#include <algorithm>
#include <array>
#include <random>

using namespace test;

namespace {

using fit::Test;

std::vector<double> spaced(double from, double to, size_t count) {
    std::vector<double> t;
    for (size_t i = 0; i < count; ++i) t.push_back(from * std::pow(to / from, double(i) / double(count - 1)));
    return t;
}

struct Draw {
    std::mt19937_64 bits{1};
    double unit() { return double(bits() >> 11) * 0x1p-53; }
    double decades(double low, double high) { return std::pow(10, low + (high - low) * unit()); }
    double normal() { return std::sqrt(-2 * std::log(1 - unit())) * std::cos(6.283185307179586 * unit()); }
    std::vector<double> noisy(std::vector<double> values, double deviation) {
        for (double& v : values) v *= 1 + deviation * normal();
        return values;
    }
    // Times of elements each 1.6 to 20 times as long as the one before.
    std::vector<double> times(int count) {
        std::vector<double> t;
        for (double time = decades(-3, -1.5); int(t.size()) < count; time *= decades(0.2, 1.3)) t.push_back(time);
        return t;
    }
    std::vector<KelvinVoigt> creeping(int n) {
        std::vector<KelvinVoigt> chain;
        if (unit() < 0.5) chain.push_back({decades(4, 7), 0});
        for (double time : times(n - int(chain.size()))) {
            const double modulus = decades(4, 7);
            chain.push_back({modulus, modulus * time});
        }
        return chain;
    }
    std::vector<KelvinVoigt> relaxing(int n) {
        Relaxation r;
        r.times = times(n - 1);
        for (size_t k = 0; k < r.times.size(); ++k) r.moduli.push_back(decades(4, 7));
        r.equilibrium = decades(4, 7);
        return chain_of(r);
    }
};

Fit fit_of(Test test, const std::vector<double>& t, const std::vector<double>& v, int n) {
    return (test == Test::creep ? fit_creep : fit_relaxation)(t, v, n, Residual::relative);
}

bool tells(const Fit& f, const std::string& words) {
    return std::any_of(f.undetermined.begin(), f.undetermined.end(),
                       [&](const std::string& s) { return s.find(words) != std::string::npos; });
}

// Share of the four numbers of two elements within their intervals, in fits with so many more points than numbers. Of
// fits that leave something undetermined too.
double share_in_intervals(size_t more, double noise) {
    Draw draw;
    double inside = 0, all = 0;
    for (int i = 0; i < 500; ++i) {
        const double a = draw.decades(5, 6), b = draw.decades(5, 6), time = draw.decades(-1.8, -1.3);
        const std::vector<KelvinVoigt> truth = {{a, a * time}, {b, b * time * draw.decades(1, 1.5)}};
        const std::vector<double> t = spaced(3e-3, 3, 4 + more);
        const Fit f = fit_creep(t, draw.noisy(fit::curve_of(Test::creep, truth, t), noise), 2);
        for (size_t k = 0; k < 2; ++k)
            for (auto member : {&KelvinVoigt::modulus, &KelvinVoigt::viscosity}) {
                ++all;
                inside += f.elements.size() == 2 &&
                          std::abs(std::log(f.elements[k].*member / (truth[k].*member))) <= 2 * f.errors[k].*member;
            }
    }
    return inside / all;
}

} // namespace

TEST_CASE("Student's quantile is that of the printed tables") {
    const std::pair<size_t, double> table[] = {{1, 12.70620474},  {2, 4.302652730},  {3, 3.182446305},
                                               {4, 2.776445105},  {5, 2.570581836},  {10, 2.228138852},
                                               {30, 2.042272456}, {100, 1.983971519}};
    for (auto [freedom, quantile] : table) CHECK(fit::students_quantile(freedom) == relative(quantile, 1e-9));
    CHECK(fit::students_quantile(1000000) == relative(1.959966, 2e-4));
}

TEST_CASE("the chain is within the stated intervals in 95 of 100 fits from one point more than numbers on") {
    for (double noise : {1e-3, 1e-2})
        for (size_t more : {1, 2, 4, 10, 40}) {
            CAPTURE(noise);
            CAPTURE(more);
            const double share = share_in_intervals(more, noise);
            CHECK(share > 0.92);
            CHECK(share < 0.98);
        }
}

TEST_CASE("600 random fits: of exact data none leaves a residual, of others one at most leaves one above the truth's "
          "by 2 %") {
    const std::vector<double> t = spaced(1e-3, 100, 60);
    int above = 0;
    for (int i = 0; i < 600; ++i) {
        Draw draw;
        draw.bits.seed(unsigned(i));
        const Test test = i / 5 % 2 ? Test::relaxation : Test::creep;
        const int n = 1 + i % 5;
        const double noise = std::array{0.0, 1e-3, 1e-2}[size_t(i / 10 % 3)];
        const std::vector<KelvinVoigt> truth = test == Test::creep ? draw.creeping(n) : draw.relaxing(n);
        const std::vector<double> exact = fit::curve_of(test, truth, t), v = draw.noisy(exact, noise);
        double squares = 0;
        for (size_t k = 0; k < t.size(); ++k) squares += std::pow(exact[k] / v[k] - 1, 2);
        const double residual = fit_of(test, t, v, n).residual;
        CAPTURE(i);
        if (noise == 0) CHECK(residual < 1e-7);
        else above += residual > 1.02 * std::sqrt(squares / double(t.size()));
    }
    CHECK(above <= 1);
}

TEST_CASE("four elements over 60 points of their creep are found, where the search once ended with a false spring") {
    const std::vector<KelvinVoigt> truth = {
        {817872.7, 71554.29}, {70652.69, 9793.462}, {27650.07, 19578.44}, {10923.56, 20851.33}};
    const std::vector<double> t = spaced(1e-3, 100, 60);
    const Fit f = fit_creep(t, fit::curve_of(Test::creep, truth, t), 4);
    CHECK(f.residual < 1e-9);
    REQUIRE(f.elements.size() == 4);
    for (size_t k = 0; k < 4; ++k) CHECK(f.elements[k].modulus == relative(truth[k].modulus, 1e-5));
    CHECK(f.undetermined.empty());
}

TEST_CASE("more elements never leave a greater residual") {
    Draw draw;
    std::vector<double> t, rising;
    for (int i = 0; i < 50; ++i) {
        t.push_back(i);
        rising.push_back(i + 1);
    }
    const std::vector<double> positive = spaced(1e-3, 10, 40);
    const std::vector<double> noisy = draw.noisy(fit::curve_of(Test::relaxation, draw.relaxing(4), positive), 0.03);
    for (const auto& [times, values] : {std::pair{t, rising}, {positive, noisy}}) {
        double before = HUGE_VAL;
        for (int n = 1; n <= 8; ++n) {
            const double residual = fit_relaxation(times, values, n).residual;
            CAPTURE(n);
            CHECK(residual <= before * (1 + 1e-12));
            before = residual;
        }
    }
}

TEST_CASE("creep that falls and a relaxation that rises are called that, and no noise about a true curve is") {
    const std::vector<double> t = spaced(1e-3, 10, 12);
    Draw draw;
    const std::vector<KelvinVoigt> chain = {{2e6, 0}, {1e6, 3e4}, {5e5, 1e6}};
    const std::vector<double> creep = fit::curve_of(Test::creep, chain, t),
                              relaxation = fit::curve_of(Test::relaxation, chain, t);
    for (double noise : {0.0, 1e-3, 0.03}) {
        CHECK(tells(fit_creep(t, draw.noisy(relaxation, noise), 3), "the compliances fall with time"));
        CHECK(tells(fit_relaxation(t, draw.noisy(creep, noise), 3), "the moduli rise with time"));
        CHECK_FALSE(tells(fit_creep(t, draw.noisy(creep, noise), 3), "fall with time"));
        CHECK_FALSE(tells(fit_relaxation(t, draw.noisy(relaxation, noise), 3), "rise with time"));
    }
    int doubted = 0; // springs, whose curves are flat
    for (int i = 0; i < 1000; ++i)
        doubted += tells(fit_creep(t, draw.noisy(std::vector<double>(t.size(), 1e-6), 0.01), 1), "fall with time");
    CHECK(doubted < 10);
}

TEST_CASE("points that stand together as one change nothing that noise does not hide") {
    Draw draw;
    const Relaxation truth{{2.5e5, 2.5e5, 2.5e5}, {4e-3, 7e-2, 1.4}, 2.5e5};
    std::vector<double> t;
    for (int i = 1; i <= 200000; ++i) t.push_back(i * 5e-5);
    const std::vector<double> exact = fit::curve_of(Test::relaxation, chain_of(truth), t);
    fit::Problem all{.test = Test::relaxation, .times = t, .values = exact, .weights = {}, .points = t.size()};
    for (double v : exact) all.weights.push_back(1 / v);
    const fit::Problem few = fit::condensed(all);
    CHECK(few.times.size() < 10000);
    CHECK(few.points == t.size());
    CHECK(few.scatter < 1e-14 * double(t.size()));
    CHECK(difference(fit::curve_of(Test::relaxation, chain_of(truth), few.times), few.values) < 1e-7);
    const Fit f = fit_relaxation(t, exact, 4);
    CHECK(f.residual < 1e-7);
    CHECK(f.model.size() == t.size());
    const Fit noisy = fit_relaxation(t, draw.noisy(exact, 0.01), 4);
    CHECK(noisy.residual == relative(0.01, 0.01));
    CHECK(noisy.undetermined.empty());
    const std::vector<KelvinVoigt> chain = chain_of(truth);
    REQUIRE(noisy.elements.size() == chain.size());
    for (size_t k = 0; k < chain.size(); ++k) {
        CHECK(f.elements[k].modulus == relative(chain[k].modulus, 1e-5));
        CHECK(std::abs(std::log(noisy.elements[k].modulus / chain[k].modulus)) <= 2 * noisy.errors[k].modulus);
        CHECK(noisy.errors[k].modulus < 0.01);
    }
}
