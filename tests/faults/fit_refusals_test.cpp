// SPDX-License-Identifier: MIT
// What fits and conversions of fit.hpp refuse, word for word.
#include "dermis/fit.hpp"
#include "tests/support.hpp"

using namespace test;

TEST_CASE("conversions refuse what is no chain and no relaxation") {
    const auto from_relaxation = [](const Relaxation& r) {
        return refusal(Error::Code::bad_input, [&] { chain_of(r); });
    };
    CHECK(from_relaxation({{1, 0}, {1, 2}, 1}) == "relaxation.moduli[1] = 0; allowed: a finite number > 0");
    CHECK(from_relaxation({{1}, {-1}, 1}) == "relaxation.times[0] = -1; allowed: a finite number > 0");
    CHECK(from_relaxation({{1}, {1}, -1}) == "relaxation.equilibrium = -1; allowed: a finite number >= 0");
    CHECK(from_relaxation({}) == "relaxation.equilibrium = 0; allowed: > 0 where there are no times");
    CHECK(from_relaxation({{1, 1}, {1}, 1}) == "relaxation.moduli = 2 numbers; allowed: 1, one for each time");
    CHECK(from_relaxation({std::vector<double>(8, 1), std::vector<double>(8, 1), 1}) ==
          "relaxation.times = 8 numbers; allowed: at most 7: a chain has at most 8 elements");
    CHECK(from_relaxation({{1e308, 1e308}, {1, 2}, 1}).find("modulus of the spring = inf; allowed: ") == 0);
    const auto from_chain = [](const std::vector<KelvinVoigt>& c) {
        return refusal(Error::Code::bad_input, [&] { relaxation_of(c); });
    };
    CHECK(from_chain({}) == "elements = 0 elements; allowed: 1 to 8");
    CHECK(from_chain(std::vector<KelvinVoigt>(9, {1, 1})) == "elements = 9 elements; allowed: 1 to 8");
    CHECK(from_chain({{1, 0}, {0, 0}}) == "elements[1].modulus = 0; allowed: > 0 where the viscosity is 0");
    CHECK(from_chain({{1, 0}, {1, NAN}}) == "elements[1].viscosity = nan; allowed: a finite number >= 0");
    CHECK(from_chain({{1, 2}, {0, 1}}) == "elements = a chain without a spring; allowed: at least one element of "
                                          "viscosity 0: without it a step of strain takes an infinite stress");
}

TEST_CASE("fits refuse what is no curve") {
    const std::vector<double> t = {1, 2, 3, 4, 5}, v = {5, 4, 3, 2, 1};
    const auto refused = [](const std::vector<double>& t, const std::vector<double>& v, int n,
                            Residual residual = Residual::relative) {
        return refusal(Error::Code::bad_input, [&] { fit_relaxation(t, v, n, residual); });
    };
    CHECK(refused(t, v, -1) == "n = -1; allowed: 1 to 8 elements, or 0: as few as describe the data");
    CHECK(refused(t, v, 9) == "n = 9; allowed: 1 to 8 elements, or 0: as few as describe the data");
    CHECK(refused(t, v, 3) == "times = 5 numbers; allowed: at least 7 for 3 elements");
    CHECK(refused(t, {1, 2}, 2) == "moduli = 2 numbers; allowed: 5, one for each time");
    CHECK(refused({1, 2, -3, 4, 5}, v, 2) == "times[2] = -3; allowed: a finite number >= 0");
    CHECK(refused({1, 2, 3e60, 4, 5}, v, 2) ==
          "times[2] = 3e+60; allowed: 0, or between 1e-50 and 1e50; other units may help");
    CHECK(refused({0, 0, 0, 0, 0}, v, 2) == "times = no time after 0; allowed: at least one");
    CHECK(refused(t, {1, 2, INFINITY, 4, 5}, 2, Residual::absolute) == "moduli[2] = inf; allowed: a finite number");
    CHECK(refused(t, {-1, -2, -3, -4, -5}, 2, Residual::absolute) == "moduli = no number > 0; allowed: at least one");
}

TEST_CASE("fits refuse what is no history") {
    const History right = {.times = {1, 2, 3, 4, 5}, .strains = {0, 1, 1, 1, 1}, .stresses = {0, 5, 4, 3, 2}};
    const auto refused = [&](auto change, int n = 1) {
        History h = right;
        change(h);
        return refusal(Error::Code::bad_input, [&] { fit_histories({right, h}, n); });
    };
    CHECK(refused([](History& h) { h.strains.pop_back(); }) ==
          "histories[1].strains = 4 numbers; allowed: 5, one for each time");
    CHECK(refused([](History& h) { h.stresses.pop_back(); }) ==
          "histories[1].stresses = 4 numbers; allowed: 5, one for each time");
    CHECK(refused([](History& h) { h.times[2] = NAN; }) == "histories[1].times[2] = nan; allowed: a finite number");
    CHECK(refused([](History& h) { h.times[2] = 1.5; }) ==
          "histories[1].times[2] = 1.5; allowed: no time before the one before it");
    CHECK(refused([](History& h) { h.strains[2] = INFINITY; }) ==
          "histories[1].strains[2] = inf; allowed: a finite number");
    CHECK(refused([](History& h) { h.strains[2] = 1e60; }) ==
          "histories[1].strains[2] = 1e+60; allowed: 0, or between 1e-50 and 1e50; other units may help");
    CHECK(refused([](History&) {}, 9) == "n = 9; allowed: 1 to 8 elements, or 0: as few as describe the data");
    const auto alone = [](const History& h) { return refusal(Error::Code::bad_input, [&] { fit_histories({h}, 1); }); };
    CHECK(alone({.times = {1, 1, 1}, .strains = {0, 1, 1}, .stresses = {0, 1, 1}}) ==
          "histories = no time after the first one; allowed: at least one");
    CHECK(alone({.times = {1, 2, 3}, .strains = {0, 1, 1}, .stresses = {0, 0, 0}}) ==
          "histories = no stress but 0; allowed: at least one");
}
